//! Handles Ctrl-C and signals that end a program: the first one requests a stop, a second one ends
//! the process at once.

use anyhow::{Context, Result};
use signal_hook::consts::signal;
use signal_hook::flag;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Exit status after Ctrl-C, as in shells.
const INTERRUPTED: i32 = 130;

/// Signals that end a program.
#[cfg(unix)]
const SIGNALS: [i32; 3] = [signal::SIGINT, signal::SIGTERM, signal::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [signal::SIGINT, signal::SIGTERM];

/// Makes the first Ctrl-C set [`is_requested`] instead of ending the process.
pub fn on_signal() -> Result<()> {
    for signal in SIGNALS {
        // Keep this order, otherwise the first signal would end the process.
        flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&REQUESTED))
            .and_then(|_| flag::register(signal, Arc::clone(&REQUESTED)))
            .context("Ctrl-C")?;
    }
    Ok(())
}

/// Requests a stop, like Ctrl-C.
pub fn request() {
    REQUESTED.store(true, Ordering::Relaxed);
}

pub fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
