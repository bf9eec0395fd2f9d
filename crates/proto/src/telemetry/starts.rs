//! Detects the end of a device's run and the beginning of the next.

use super::events::Events;

/// Time by which a greeting or `health` may be older than the previous event, microseconds: a
/// window may end a frame after the latest conversion, and the slowest plan has 12 frames a second.
const EARLY_US: u64 = 100_000;

/// Detects a restart of a device by its time, which begins at zero: greetings and `health` have the
/// time at which they are created, so one that is older than the previous event belongs to a new
/// run. All readers use this, because packet numbers wrap and cannot show a restart.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    latest_us: Option<u64>,
}

impl Starts {
    /// Creates a detector that has seen no event.
    pub const fn new() -> Self {
        Self { latest_us: None }
    }

    /// Takes the next event. Returns true if the device has restarted before it.
    pub fn take(&mut self, event: &impl Events) -> bool {
        let made_us = event.made_us();
        let is_new = made_us
            .zip(self.latest_us)
            .is_some_and(|(made_us, latest_us)| made_us.saturating_add(EARLY_US) < latest_us);
        if is_new {
            self.latest_us = None;
        }
        self.latest_us = self.latest_us.max(event.dated_us()).max(made_us);
        is_new
    }
}
