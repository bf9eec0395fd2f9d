//! What the emulated board keeps over a reset of its processor: the bridge's files, and the time.

use super::semihost::File;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use ridgetone_proto::boot::ResetCause;

/// The first word, if the others are valid. The emulator's memory starts as zeros.
const SEAL: u32 = 0x5ea1_ed01;

// Not cleared by start-up (cortex-m-rt, link.x), and not initialized either.
#[unsafe(link_section = ".uninit.kept")]
static WORDS: [AtomicU32; 6] = [const { AtomicU32::new(0) }; 6];

/// Kept by the run before.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// Requests to the chip.
    pub request: File,
    /// Its replies.
    pub reply: File,
    /// The log.
    pub log: File,
    /// The microsecond counter at the reset.
    pub now_us: u32,
    /// What the reset stands for.
    pub cause: ResetCause,
}

impl Kept {
    /// Keeps it until [`Kept::take`].
    pub fn put(&self) {
        let watchdog = u32::from(self.cause == ResetCause::Watchdog);
        let words = [SEAL, self.request.handle(), self.reply.handle(), self.log.handle(), self.now_us, watchdog];
        for (kept, word) in WORDS.iter().zip(words) {
            kept.store(word, Relaxed);
        }
    }

    /// What was kept, if this run began with a reset by [`Kept::put`]'s caller.
    pub fn take() -> Option<Self> {
        let [seal, request, reply, log, now_us, watchdog] = WORDS.each_ref().map(|word| word.swap(0, Relaxed));
        (seal == SEAL).then_some(Self {
            request: File::of(request),
            reply: File::of(reply),
            log: File::of(log),
            now_us,
            cause: if watchdog == 1 { ResetCause::Watchdog } else { ResetCause::Software },
        })
    }
}
