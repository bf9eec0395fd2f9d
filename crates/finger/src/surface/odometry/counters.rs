//! What was counted of a robot's messages.

use crate::faults::log::Counter;
use ridgetone_proto::telemetry::OdometryCounts;

/// What was counted. Every task may read.
#[derive(Debug, Default)]
pub struct Counters {
    pub(super) received: Counter,
    /// Numbers up to the newest message's.
    pub(super) numbers: Counter,
    pub(super) late: Counter,
    pub(super) doubled: Counter,
    /// Windows that were fitted by time although a robot streams.
    pub windows_by_time: Counter,
}

impl Counters {
    /// Nothing counted.
    pub const fn new() -> Self {
        let [received, numbers, late, doubled, windows_by_time] = [const { Counter::new() }; 5];
        Self {
            received,
            numbers,
            late,
            doubled,
            windows_by_time,
        }
    }

    /// As `health` reports them.
    pub fn get(&self) -> OdometryCounts {
        let (received, doubled) = (self.received.get(), self.doubled.get());
        OdometryCounts {
            received,
            lost: self
                .numbers
                .get()
                .saturating_sub(received.saturating_sub(doubled)),
            late: self.late.get(),
            doubled,
            windows_by_time: self.windows_by_time.get(),
        }
    }
}
