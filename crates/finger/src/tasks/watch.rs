//! `watch`: the task that feeds the watchdog.

use super::liveness::WatchdogPolicy;
use super::shared::{Platform, Shared, Task};
use core::sync::atomic::Ordering::Relaxed;

impl WatchdogPolicy {
    /// Runs twice a second, above `fit`, so that a busy fit does not delay it. Requests a check of
    /// the chip, at the next conversion, or at once if none is expected soon. Returns true if the
    /// watchdog is to be fed.
    #[must_use]
    pub fn run<P: Platform>(&mut self, shared: &Shared<P>) -> bool {
        let is_alive = self.feeds(&shared.liveness);
        shared.check.store(true, Relaxed);
        shared.look.store(true, Relaxed);
        shared.health.store(!shared.touched.load(Relaxed), Relaxed);
        P::pend(shared, Task::Drdy);
        is_alive
    }
}
