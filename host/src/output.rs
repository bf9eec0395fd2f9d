//! Output: lines on standard output, complete files, and messages and progress on standard error.

mod file;

pub use file::{check_new, force, new_file, new_text, whole_file, whole_text};

use anyhow::Result;
use hal_mock::printable;
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};
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

/// Writes one line to standard error. The text may quote files, boards and peers, so control
/// characters are escaped and a long text is cut.
pub fn error_line(text: Arguments<'_>) {
    // If standard error is closed, the failure cannot be reported anywhere.
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(&text.to_string()));
}

/// Writes a message of the command to standard error, as [`output::error_line`](error_line) does.
#[macro_export]
macro_rules! note {
    ($($text:tt)+) => {
        $crate::output::error_line(format_args!("ridgetone: {}", format_args!($($text)+)))
    };
}

/// True if no progress is shown, because the program that uses this library has its own screen.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses progress output from now on.
pub fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Shows the progress of a run on standard error, every two seconds of wall time.
#[derive(Debug)]
pub struct Progress {
    shown: Instant,
    is_terminal: bool,
    /// True if the cursor is at the end of a progress line.
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
    /// Shows the number of items done and their total.
    pub fn show_count(&mut self, what: &str, done: u64, total: u64) {
        self.show(format_args!("{what}: {done} of {total}"));
    }

    pub fn show(&mut self, text: Arguments<'_>) {
        if self.shown.elapsed() < EVERY || IS_QUIET.load(Ordering::Relaxed) {
            return;
        }
        self.shown = Instant::now();
        if self.is_terminal {
            let text = text.to_string();
            let _ = write!(
                std::io::stderr().lock(),
                "\rridgetone: {} ",
                printable(&text)
            );
            self.is_open = true;
        } else {
            note!("{text}");
        }
    }

    pub fn end(&mut self) {
        if std::mem::take(&mut self.is_open) {
            let _ = writeln!(std::io::stderr().lock());
        }
    }
}
