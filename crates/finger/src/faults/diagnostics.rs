//! Counters that the tasks write, each from its own priority, and that `health` reports.

use crate::faults::found::Found;
use crate::faults::log::{Counter, FaultLog};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::FRAME_RATE_HZ;

/// Maximum time between two sightings of an input that stays at a rail, microseconds: 2.2 scans.
const TWO_SCANS_US: u32 = (2.2e6 / FRAME_RATE_HZ) as u32;

/// Counters of the tasks. Every task may write without a lock.
#[derive(Debug, Default)]
pub struct Diagnostics {
    /// Conversions lost before they reached the queue or because it was full, except whole scans
    /// that were never read.
    pub queue_overruns: Counter,
    /// Maximum number of further conversions that the chip may have made while it ran with wrong
    /// registers.
    pub unseen: Counter,
    /// Windows not fitted because the fit was busy.
    pub overruns: Counter,
    /// Messages dropped because the line was slow.
    pub messages_dropped: Counter,
    /// Raw frames for which the line had no room.
    pub frames_thinned: Counter,
    /// Number of times that the ADC was set up again.
    pub chip_restarts: Counter,
    /// Requests that were damaged, or arrived before the previous one was taken.
    pub requests_damaged: Counter,
    /// Minimum number of request bytes that were lost because earlier ones had not been read.
    pub bytes_overrun: Counter,
    /// Result of the converter's latest set-up.
    pub(crate) converter: Found,
    /// Bits of the processor load, an f32 from 0 to 1.
    pub(crate) load_bits: AtomicU32,
    /// Maximum stack use since start-up, and the stack's size, bytes.
    pub(crate) stack: [AtomicU32; 2],
    /// Board time (microseconds) since which the same number of inputs has been at a rail, and that
    /// number.
    railed_us: AtomicU32,
    railed: AtomicU32,
    /// Counts and times of faults.
    pub faults: FaultLog,
}

impl Diagnostics {
    /// Creates counters at zero.
    pub const fn new() -> Self {
        Self {
            queue_overruns: Counter::new(),
            unseen: Counter::new(),
            overruns: Counter::new(),
            messages_dropped: Counter::new(),
            frames_thinned: Counter::new(),
            chip_restarts: Counter::new(),
            requests_damaged: Counter::new(),
            bytes_overrun: Counter::new(),
            converter: Found::new(),
            load_bits: AtomicU32::new(0),
            stack: [const { AtomicU32::new(0) }; 2],
            railed_us: AtomicU32::new(0),
            railed: AtomicU32::new(0),
            faults: FaultLog::new(),
        }
    }

    /// Fraction of time that the processor was busy, 0 to 1; zero if not measured.
    pub fn load(&self) -> f32 {
        f32::from_bits(self.load_bits.load(Relaxed))
    }

    /// Maximum stack use since start-up, and the stack's size, bytes; zero if not measured.
    pub fn stack_bytes(&self) -> [u32; 2] {
        self.stack.each_ref().map(|bytes| bytes.load(Relaxed))
    }

    /// Adds a fault that was seen at this board time, microseconds.
    pub fn fault(&self, kind: FaultKind, board_us: u32) {
        self.faults.add(kind, 1, board_us);
    }

    /// Records that `inputs` inputs were at a rail in the scan before this board time,
    /// microseconds. Zero has no effect.
    pub fn overload(&self, inputs: u32, board_us: u32) {
        if inputs == 0 {
            return;
        }
        let is_new = board_us.wrapping_sub(self.faults.seen_us(FaultKind::Overload)) > TWO_SCANS_US;
        if self.railed.swap(inputs, Relaxed) != inputs || is_new {
            self.railed_us.store(board_us, Relaxed);
        }
        self.faults.add(FaultKind::Overload, inputs, board_us);
    }

    /// True if an input has reached a rail or left one between two device times (low 32 bits,
    /// microseconds). An input that stays at a rail, such as a broken bridge's, does neither.
    pub fn rails_change(&self, from_us: u32, to_us: u32) -> bool {
        let is_since = |since_us| self.faults.since(since_us).has(FaultKind::Overload);
        let is_steady = || self.faults.is_before(self.railed_us.load(Relaxed), from_us);
        is_since(from_us) && !(is_steady() && is_since(to_us.wrapping_sub(TWO_SCANS_US)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_stop_at_their_largest_value() {
        let diagnostics = Diagnostics::new();
        for _ in 0..2 {
            diagnostics.unseen.add(u32::MAX - 100_000);
            diagnostics.queue_overruns.add(u32::MAX - 1);
        }
        assert_eq!(
            (diagnostics.queue_overruns.get(), diagnostics.unseen.get()),
            (u32::MAX, u32::MAX)
        );
    }
}
