//! Counters of the tasks, each written from its own priority, that `health` reports.

use crate::faults::log::{FaultLog, raise};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::FRAME_RATE_HZ;

/// Within this time, microseconds, an input that stays at its rail is seen there again: 2.2 scans.
const TWO_SCANS_US: u32 = (2.2e6 / FRAME_RATE_HZ) as u32;

/// What the tasks counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Conversions lost before the queue or at it, except whole scans that were never read.
    pub overruns: u32,
    /// Conversions that the chip may have made besides, at most, while it ran with other registers.
    pub unseen: u32,
    /// Windows not fitted because the fit was busy.
    pub hops_skipped: u32,
    /// Messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// Times the ADC was set up again because its registers had changed.
    pub chip_restarts: u32,
    /// Requests that were damaged.
    pub requests_damaged: u32,
    /// Processor load, 0 to 1.
    pub load: f32,
    /// Most stack in use since start-up, and the stack's size, bytes.
    pub stack: [u32; 2],
}

/// Counters that every task may raise without a lock. They stop at their largest value: after a wrap `health` would report
/// less than was lost.
#[derive(Debug, Default)]
pub struct Diagnostics {
    overruns: AtomicU32,
    unseen: AtomicU32,
    hops_skipped: AtomicU32,
    messages_dropped: AtomicU32,
    chip_restarts: AtomicU32,
    requests_damaged: AtomicU32,
    load_bits: AtomicU32,
    stack: [AtomicU32; 2],
    /// Board time since which the inputs that are at a rail have been the same, microseconds, and how many there are.
    railed_us: AtomicU32,
    railed: AtomicU32,
    /// The faults.
    pub faults: FaultLog,
}

impl Diagnostics {
    /// Everything at zero.
    pub const fn new() -> Self {
        Self {
            overruns: AtomicU32::new(0),
            unseen: AtomicU32::new(0),
            hops_skipped: AtomicU32::new(0),
            messages_dropped: AtomicU32::new(0),
            chip_restarts: AtomicU32::new(0),
            requests_damaged: AtomicU32::new(0),
            load_bits: AtomicU32::new(0),
            stack: [const { AtomicU32::new(0) }; 2],
            railed_us: AtomicU32::new(0),
            railed: AtomicU32::new(0),
            faults: FaultLog::new(),
        }
    }

    /// A fault was seen at this board time, microseconds.
    pub fn fault(&self, kind: FaultKind, board_us: u32) {
        self.faults.add(kind, 1, board_us);
    }

    /// So many inputs were at a rail in the scan before this board time, microseconds. Zero changes nothing: scans on the
    /// assembler's fast path do not call this.
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

    /// Whether an input has reached a rail or left one between two device times, their low 32 bits, microseconds. An input
    /// that is always there, such as a broken bridge's, does neither.
    pub fn rails_change(&self, from_us: u32, to_us: u32) -> bool {
        let is_since = |since_us| self.faults.since(since_us).has(FaultKind::Overload);
        let is_steady = || self.faults.is_before(self.railed_us.load(Relaxed), from_us);
        is_since(from_us) && !(is_steady() && is_since(to_us.wrapping_sub(TWO_SCANS_US)))
    }

    /// Conversions were lost before the queue or at it.
    pub fn overrun(&self, conversions: u32) {
        raise(&self.overruns, conversions);
    }

    /// The chip may have made at most so many conversions that nobody saw.
    pub fn unseen(&self, at_most: u32) {
        raise(&self.unseen, at_most);
    }

    /// A window was not fitted.
    pub fn hop_skipped(&self) {
        raise(&self.hops_skipped, 1);
    }

    /// A message was dropped.
    pub fn message_dropped(&self) {
        raise(&self.messages_dropped, 1);
    }

    /// The ADC was set up again.
    pub fn chip_restarted(&self) {
        raise(&self.chip_restarts, 1);
    }

    /// A request was damaged, or arrived before the previous one was taken.
    pub fn request_damaged(&self) {
        raise(&self.requests_damaged, 1);
    }

    /// Processor load, 0 to 1.
    pub fn set_load(&self, load: f32) {
        self.load_bits.store(load.to_bits(), Relaxed);
    }

    /// Sets the most stack in use since start-up, and the stack's size, bytes.
    pub fn set_stack(&self, used_bytes: u32, size_bytes: u32) {
        let [used, size] = &self.stack;
        used.store(used_bytes, Relaxed);
        size.store(size_bytes, Relaxed);
    }

    /// All counters.
    pub fn counters(&self) -> Counters {
        Counters {
            overruns: self.overruns.load(Relaxed),
            unseen: self.unseen.load(Relaxed),
            hops_skipped: self.hops_skipped.load(Relaxed),
            messages_dropped: self.messages_dropped.load(Relaxed),
            chip_restarts: self.chip_restarts.load(Relaxed),
            requests_damaged: self.requests_damaged.load(Relaxed),
            load: f32::from_bits(self.load_bits.load(Relaxed)),
            stack: self.stack.each_ref().map(|bytes| bytes.load(Relaxed)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_counters_are_reported() {
        let diagnostics = Diagnostics::new();
        diagnostics.overrun(1);
        diagnostics.unseen(6);
        diagnostics.hop_skipped();
        diagnostics.hop_skipped();
        diagnostics.message_dropped();
        diagnostics.chip_restarted();
        (0..4).for_each(|_| diagnostics.request_damaged());
        diagnostics.set_load(0.25);
        diagnostics.set_stack(1234, 32768);
        let expected = Counters {
            overruns: 1,
            unseen: 6,
            hops_skipped: 2,
            messages_dropped: 1,
            chip_restarts: 1,
            requests_damaged: 4,
            load: 0.25,
            stack: [1234, 32768],
        };
        assert_eq!(diagnostics.counters(), expected);
    }

    /// A second of the fastest chip, unseen, when nearly as many were counted as can be.
    #[test]
    fn counters_stop_at_their_largest_value() {
        let diagnostics = Diagnostics::new();
        for _ in 0..2 {
            diagnostics.unseen(u32::MAX - 100_000);
            diagnostics.overrun(u32::MAX - 1);
        }
        let Counters { overruns, unseen, .. } = diagnostics.counters();
        assert_eq!((overruns, unseen), (u32::MAX, u32::MAX));
    }
}
