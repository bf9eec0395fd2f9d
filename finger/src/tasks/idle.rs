//! `idle`: measures the load and the stack, and knows when the run is over.

use super::load::LoadMeter;
use super::outbox::Outbox;
use super::shared::{PACKETS, Shared};
use super::stack_depth::DepthMeter;
use core::sync::atomic::Ordering::Relaxed;
use rtic_core::Mutex;

/// What the board does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Next {
    /// It sleeps until the next interrupt.
    Sleep,
    /// It resets: a request demands it. The last two bytes are still on the line.
    Restart,
    /// The signal is over, and all its events have left.
    Leave,
}

/// What the task owns.
#[derive(Debug, Default)]
pub struct Idle {
    load: LoadMeter,
    depth: DepthMeter,
}

impl Idle {
    /// Nothing measured.
    pub const fn new() -> Self {
        Self { load: LoadMeter::new(), depth: DepthMeter::new() }
    }

    /// Runs after each sleep, which lasted `slept_us`: from, to on the microsecond counter. The stack has `words`, which
    /// `word` reads by their number from its far end.
    pub fn run<P>(
        &mut self,
        slept_us: (u32, u32),
        words: usize,
        word: impl Fn(usize) -> u32,
        outbox: &mut impl Mutex<T = Outbox<PACKETS>>,
        shared: &Shared<P>,
    ) -> Next {
        if let Some(load) = self.load.slept(slept_us.0, slept_us.1) {
            shared.diagnostics.set_load(load);
        }
        shared.diagnostics.set_stack(self.depth.step(words, word), 4 * words as u32);
        // No interrupt is pending here, so no window is being fitted.
        let next = match (shared.is_restarting(), shared.finished.load(Relaxed)) {
            (true, _) => Next::Restart,
            (false, true) => Next::Leave,
            (false, false) => return Next::Sleep,
        };
        let is_silent = !shared.sending.load(Relaxed) && outbox.lock(|outbox| outbox.is_empty());
        if is_silent { next } else { Next::Sleep }
    }
}
