//! Ctrl-C, and the signals that ask a program to end: a second one ends it at once.

use anyhow::{Context, Result};
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit status of a program that was ended by Ctrl-C twice, as a shell has it.
const INTERRUPTED: i32 = 130;

/// From now on Ctrl-C only asks; [`is_asked`] says so.
///
/// # Errors
/// The system refuses.
pub fn on_signal() -> Result<()> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    })
    .context("Ctrl-C")
}

/// Whether this process was asked to end.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
