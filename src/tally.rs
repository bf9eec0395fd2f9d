//! What the tasks count, each from its own priority, for `health` to report.

use crate::fault::FaultKind;
use crate::ledger::{Ledger, raise};
use crate::pipeline::Counters;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Counters that every task may bump without a lock. They stop at their largest value: one that began anew would tell of
/// less than was lost.
#[derive(Debug, Default)]
pub struct Tally {
    overruns: AtomicU32,
    unseen: AtomicU32,
    hops_skipped: AtomicU32,
    messages_dropped: AtomicU32,
    chip_restarts: AtomicU32,
    orders_damaged: AtomicU32,
    load_bits: AtomicU32,
    stack: [AtomicU32; 2],
    /// The faults.
    pub faults: Ledger,
}

impl Tally {
    /// Everything at zero.
    pub const fn new() -> Self {
        Self {
            overruns: AtomicU32::new(0),
            unseen: AtomicU32::new(0),
            hops_skipped: AtomicU32::new(0),
            messages_dropped: AtomicU32::new(0),
            chip_restarts: AtomicU32::new(0),
            orders_damaged: AtomicU32::new(0),
            load_bits: AtomicU32::new(0),
            stack: [const { AtomicU32::new(0) }; 2],
            faults: Ledger::new(),
        }
    }

    /// A fault was seen at this board time, microseconds.
    pub fn fault(&self, kind: FaultKind, board_us: u32) {
        self.faults.add(kind, 1, board_us);
    }

    /// Conversions were lost before the queue or at it.
    pub fn overrun(&self, conversions: u32) {
        raise(&self.overruns, conversions);
    }

    /// The chip may have made so many conversions, at most, that nobody can have seen.
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

    /// The ADC had to be set up anew.
    pub fn chip_restarted(&self) {
        raise(&self.chip_restarts, 1);
    }

    /// An order came damaged, or while the one before it had not been taken yet.
    pub fn order_damaged(&self) {
        raise(&self.orders_damaged, 1);
    }

    /// Processor load, 0 to 1.
    pub fn set_load(&self, load: f32) {
        self.load_bits.store(load.to_bits(), Relaxed);
    }

    /// The most of the stack that was in use since start-up, and its size, bytes.
    pub fn set_stack(&self, used_bytes: u32, size_bytes: u32) {
        let [used, size] = &self.stack;
        used.store(used_bytes, Relaxed);
        size.store(size_bytes, Relaxed);
    }

    /// All of it, as the detector reports it.
    pub fn counters(&self) -> Counters {
        Counters {
            overruns: self.overruns.load(Relaxed),
            unseen: self.unseen.load(Relaxed),
            hops_skipped: self.hops_skipped.load(Relaxed),
            messages_dropped: self.messages_dropped.load(Relaxed),
            chip_restarts: self.chip_restarts.load(Relaxed),
            orders_damaged: self.orders_damaged.load(Relaxed),
            load: f32::from_bits(self.load_bits.load(Relaxed)),
            stack: self.stack.each_ref().map(|bytes| bytes.load(Relaxed)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_counted_is_reported() {
        let tally = Tally::new();
        tally.overrun(1);
        tally.unseen(6);
        tally.hop_skipped();
        tally.hop_skipped();
        tally.message_dropped();
        tally.chip_restarted();
        (0..4).for_each(|_| tally.order_damaged());
        tally.set_load(0.25);
        tally.set_stack(1234, 32768);
        let expected = Counters {
            overruns: 1,
            unseen: 6,
            hops_skipped: 2,
            messages_dropped: 1,
            chip_restarts: 1,
            orders_damaged: 4,
            load: 0.25,
            stack: [1234, 32768],
        };
        assert_eq!(tally.counters(), expected);
    }

    /// A second of the fastest chip, unseen, when nearly as many were counted as can be.
    #[test]
    fn counters_stop_at_their_largest_value() {
        let tally = Tally::new();
        for _ in 0..2 {
            tally.unseen(u32::MAX - 100_000);
            tally.overrun(u32::MAX - 1);
        }
        let Counters { overruns, unseen, .. } = tally.counters();
        assert_eq!((overruns, unseen), (u32::MAX, u32::MAX));
    }
}
