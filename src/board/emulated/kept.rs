//! What the emulated board keeps over a reset of its processor: the host's files, and the time.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use ridgetone_proto::boot::ResetCause;

/// The words. The emulator's memory starts as zeros.
pub struct Kept {
    /// [`SEAL`], if the time and the cause are valid.
    seal: AtomicU32,
    /// The microsecond counter at the reset.
    now_us: AtomicU32,
    /// Whether the reset stands for one by the watchdog.
    watchdog: AtomicU32,
    /// The host's handles of the files `spi.request`, `spi.reply` and `defmt.log`, 0 for none.
    pub request: AtomicU32,
    pub reply: AtomicU32,
    pub log: AtomicU32,
}

const SEAL: u32 = 0x5ea1_ed01;

// Not cleared by start-up (cortex-m-rt, link.x), and not initialized either.
#[unsafe(link_section = ".uninit.kept")]
pub static KEPT: Kept = Kept {
    seal: AtomicU32::new(0),
    now_us: AtomicU32::new(0),
    watchdog: AtomicU32::new(0),
    request: AtomicU32::new(0),
    reply: AtomicU32::new(0),
    log: AtomicU32::new(0),
};

impl Kept {
    /// Before a reset: keeps all until [`Kept::take`].
    pub fn put(&self, now_us: u32, cause: ResetCause) {
        self.now_us.store(now_us, Relaxed);
        self.watchdog
            .store(u32::from(cause == ResetCause::Watchdog), Relaxed);
        self.seal.store(SEAL, Relaxed);
    }

    /// The time and the cause, if this run began with a reset by [`Kept::put`]'s caller. The files
    /// are then open.
    pub fn take(&self) -> Option<(u32, ResetCause)> {
        let cause = if self.watchdog.load(Relaxed) == 1 {
            ResetCause::Watchdog
        } else {
            ResetCause::Software
        };
        (self.seal.swap(0, Relaxed) == SEAL).then(|| (self.now_us.load(Relaxed), cause))
    }
}
