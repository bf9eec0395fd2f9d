//! Ctrl-C and the signals that end a program: the first one is a request, a second one ends it at
//! once.

use anyhow::{Context, Result};
use signal_hook::consts::signal;
use signal_hook::flag;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Exit status after Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

/// Signals that end a program.
#[cfg(unix)]
const SIGNALS: [i32; 3] = [signal::SIGINT, signal::SIGTERM, signal::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [signal::SIGINT, signal::SIGTERM];

/// From now on the first Ctrl-C sets [`is_requested`] instead of ending the process.
pub fn on_signal() -> Result<()> {
    for signal in SIGNALS {
        // In this order, or the first signal would end the process.
        flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&REQUESTED))
            .and_then(|_| flag::register(signal, Arc::clone(&REQUESTED)))
            .context("Ctrl-C")?;
    }
    Ok(())
}

/// Requests the end, as Ctrl-C does.
pub fn request() {
    REQUESTED.store(true, Ordering::Relaxed);
}

/// True if this process is to end.
pub fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
