//! Where results go: standard output line by line, files whole or not at all, progress beside them.

use crate::recording;
use anyhow::{Context, Result, bail};
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Writes one line to standard output at once: whoever reads it reads live.
///
/// # Errors
/// Standard output is closed or full.
pub fn line(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.write_all(b"\n")?;
    out.flush()?;
    Ok(())
}

/// Writes a file under a temporary name beside its place and renames it: it is there whole or not at all. A file that was
/// there is replaced, but for a recording of telemetry, which nobody can make again.
///
/// # Errors
/// There is a recording; those of the system and of `write`, with the file's name.
pub fn whole_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let named = || path.display().to_string();
    if recording::is_telemetry(path).unwrap_or(false) {
        bail!("{}: that is a recording of telemetry, which is not overwritten: choose another name", named());
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
        // As for any other new file: the process's mask decides.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(directory).with_context(named)?;
    let mut writer = std::io::BufWriter::new(file.as_file_mut());
    write(&mut writer).with_context(named)?;
    writer.flush().with_context(named)?;
    drop(writer);
    file.persist(path).map_err(|error| error.error).with_context(named)?;
    Ok(())
}

/// Tells how far a run has come, every two seconds of wall time.
#[derive(Debug)]
pub struct Progress {
    told: Instant,
    terminal: bool,
    shown: bool,
}

/// Between two reports.
const EVERY: Duration = Duration::from_secs(2);

impl Default for Progress {
    fn default() -> Self {
        Self { told: Instant::now(), terminal: std::io::stderr().is_terminal(), shown: false }
    }
}

impl Progress {
    /// So much is done, in seconds of the input.
    pub fn tell(&mut self, done_s: f64, total_s: f64) {
        self.say(format_args!("{done_s:.1} of {total_s:.1} s"));
    }

    /// So many of something are done.
    pub fn tell_count(&mut self, what: &str, done: usize, total: usize) {
        self.say(format_args!("{what}: {done} of {total}"));
    }

    /// It is so far, in the caller's words.
    pub fn say(&mut self, how_far: Arguments<'_>) {
        if self.told.elapsed() < EVERY {
            return;
        }
        self.told = Instant::now();
        let text = format!("ridgetone: {how_far}");
        if self.terminal {
            eprint!("\r{text} ");
            self.shown = true;
        } else {
            eprintln!("{text}");
        }
    }

    /// Ends the line that [`tell`](Self::tell) has written over and over.
    pub fn end(&mut self) {
        if std::mem::take(&mut self.shown) {
            eprintln!();
        }
    }
}
