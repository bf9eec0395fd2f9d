//! Where a device's run ends and its next one begins.

use super::events::Events;

/// How much older a greeting or `health` may be than what came before, microseconds: a window may
/// end a frame after the latest conversion, and the slowest plan has 12 frames a second.
const EARLY_US: u64 = 100_000;

/// Notices that a device has started anew, by its time, which begins at zero: greetings and
/// `health` are dated when they are made, so one that is older than what came before is of another
/// run. Every reader asks this; numbers of packets say nothing of it, for they wrap.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    latest_us: Option<u64>,
}

impl Starts {
    /// Before the first event.
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
