//! Ctrl-C and the signals that end a program: the first one is a request, a second one ends it at
//! once.

use anyhow::{Context, Result};
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Exit status after Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

/// From now on the first Ctrl-C sets [`is_requested`] instead of ending the process.
pub fn on_signal() -> Result<()> {
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    })
    .context("Ctrl-C")
}

/// Requests the end, as Ctrl-C does.
pub fn request() {
    REQUESTED.store(true, Ordering::Relaxed);
}

/// Whether this process is to end.
pub fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
