//! Result of the converter's latest set-up.

use crate::converter::REGISTERS;
use crate::faults::log::Counter;
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering::Relaxed};

/// Result that `drdy` has found and `detect` reports.
#[derive(Debug)]
pub struct Found {
    answers: AtomicBool,
    registers: [AtomicU8; REGISTERS],
    changes: Counter,
}

impl Default for Found {
    fn default() -> Self {
        Self::new()
    }
}

impl Found {
    pub const fn new() -> Self {
        Self {
            answers: AtomicBool::new(false),
            registers: [const { AtomicU8::new(0) }; REGISTERS],
            changes: Counter::new(),
        }
    }

    /// Keeps the result of a set-up: the registers, unless they could not be read; `answers` is
    /// true if they hold what was written.
    pub fn keep(&self, registers: Option<[u8; REGISTERS]>, answers: bool) {
        let mut has_changed = self.answers.swap(answers, Relaxed) != answers;
        for (kept, found) in self.registers.iter().zip(registers.into_iter().flatten()) {
            has_changed |= kept.swap(found, Relaxed) != found;
        }
        self.changes.add(has_changed.into());
    }

    /// True if the converter holds what was written to it.
    pub fn answers(&self) -> bool {
        self.answers.load(Relaxed)
    }

    /// Registers as read; zeros before the first set-up.
    pub fn registers(&self) -> [u8; REGISTERS] {
        self.registers.each_ref().map(|byte| byte.load(Relaxed))
    }

    /// Number of times that the result has changed.
    pub fn changes(&self) -> u32 {
        self.changes.get()
    }
}
