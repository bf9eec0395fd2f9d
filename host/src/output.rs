//! Output: lines on standard output, complete files, and progress on standard error.

use crate::recording;
use anyhow::{Context, Result, bail};
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Writes one line to standard output and flushes it, for a live reader.
pub fn line(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.write_all(b"\n")?;
    out.flush()?;
    Ok(())
}

/// Writes a file under a temporary name beside its place and renames it, so that it is never
/// incomplete. An existing file is replaced, but for a recording of telemetry, which nobody can
/// make again. Errors, those of `write` too, have the file's name.
pub fn whole_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let named = || path.display().to_string();
    if recording::is_telemetry(path).unwrap_or(false) {
        bail!(
            "{}: that is a recording of telemetry, which is not overwritten: choose another name",
            named()
        );
    }
    let directory = match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ridgetone-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Permissions as for any new file: the process's mask decides.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(directory).with_context(named)?;
    let mut writer = std::io::BufWriter::new(file.as_file_mut());
    write(&mut writer).with_context(named)?;
    writer.flush().with_context(named)?;
    drop(writer);
    file.persist(path)
        .map_err(|error| error.error)
        .with_context(named)?;
    Ok(())
}

/// Whether existing files may be replaced, as `--force` says.
static IS_FORCED: AtomicBool = AtomicBool::new(false);

/// Existing files may be replaced from now on.
pub fn force() {
    IS_FORCED.store(true, Ordering::Relaxed);
}

/// Refuses a file that exists already, unless files may be replaced. Ask before the work whose
/// result it takes.
pub fn check_new(path: &Path) -> Result<()> {
    let may_replace =
        IS_FORCED.load(Ordering::Relaxed) && !recording::is_telemetry(path).unwrap_or(false);
    // A device or a pipe takes what is written.
    if path.is_file() && !may_replace {
        let (path, what) = (
            path.display(),
            if IS_FORCED.load(Ordering::Relaxed) {
                ""
            } else {
                ", or add --force"
            },
        );
        bail!("{path}: this file exists already and is not overwritten: choose another name{what}");
    }
    Ok(())
}

/// Writes a complete file as [`whole_file`] does, but replaces none unless [`force`] was called.
pub fn new_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    check_new(path)?;
    whole_file(path, write)
}

/// Writes a text to a new file.
pub fn new_text(path: &Path, text: &str) -> Result<()> {
    new_file(path, |file| Ok(file.write_all(text.as_bytes())?))
}

/// As [`whole_file`] with a text.
pub fn whole_text(path: &Path, text: &str) -> Result<()> {
    whole_file(path, |file| Ok(file.write_all(text.as_bytes())?))
}

/// Whether there is no progress to show: whoever calls this library has a screen of their own.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// Shows no progress from now on.
pub fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Shows the progress of a run on standard error, every two seconds of wall time.
#[derive(Debug)]
pub struct Progress {
    shown: Instant,
    is_terminal: bool,
    /// Whether the cursor is at the end of a progress line.
    is_open: bool,
}

/// Time between two reports.
const EVERY: Duration = Duration::from_secs(2);

impl Default for Progress {
    fn default() -> Self {
        Self {
            shown: Instant::now(),
            is_terminal: std::io::stderr().is_terminal(),
            is_open: false,
        }
    }
}

/// Calls `run` with a function that shows the progress: seconds of the input done, and its length.
pub fn with_progress<T>(run: impl FnOnce(&mut dyn FnMut(f64, f64)) -> Result<T>) -> Result<T> {
    let mut progress = Progress::default();
    let result =
        run(&mut |done_s, total_s| progress.show(format_args!("{done_s:.1} of {total_s:.1} s")));
    progress.end();
    result
}

impl Progress {
    /// Items done, and their number.
    pub fn show_count(&mut self, what: &str, done: u64, total: u64) {
        self.show(format_args!("{what}: {done} of {total}"));
    }

    pub fn show(&mut self, text: Arguments<'_>) {
        if self.shown.elapsed() < EVERY || IS_QUIET.load(Ordering::Relaxed) {
            return;
        }
        self.shown = Instant::now();
        if self.is_terminal {
            eprint!("\rridgetone: {text} ");
            self.is_open = true;
        } else {
            eprintln!("ridgetone: {text}");
        }
    }

    /// Ends the progress line.
    pub fn end(&mut self) {
        if std::mem::take(&mut self.is_open) {
            eprintln!();
        }
    }
}
