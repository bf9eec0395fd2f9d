//! Signs of life of the tasks, and the policy that feeds the watchdog.
//!
//! The watchdog is fed twice a second if each of these has made progress since the last feeding:
//!
//! - **Acquisition**: `drdy` ran to its end, for a conversion or for a check of the chip. The check
//!   also comes twice a second without conversions, because a reset of the board would not mend a
//!   silent chip, which is reported as a fault.
//! - **Detection**: `detect`, which each `drdy` starts, emptied its queue.
//! - **The fit**: it has nothing to do, or finished a window. A fit that is slower than the stride
//!   skips strides; only a fit that takes longer than the watchdog's period counts as hung.
//!
//! `watch` interrupts the fit, so a busy fit does not delay the feeding. If a task of the same or a
//! higher priority hangs, the watchdog is not fed. The line does not count: a blocked line only
//! costs telemetry, and a reset would not free it.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Period of the watchdog, seconds. Its oscillator may be 47 / 32 faster than nominal (DS8626,
/// LSI), which leaves 5.4 s; erasing a sector of flash stops the processor for up to 2 s at 3.3 V
/// (DS8626, flash programming, x32).
pub const WATCHDOG_S: u32 = 8;

/// Counts the progress of one task. Only one priority writes to it, so a load and a store suffice.
#[derive(Debug, Default)]
pub struct Progress(AtomicU32);

impl Progress {
    const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Counts one step.
    pub fn bump(&self) {
        self.0.store(self.get().wrapping_add(1), Relaxed);
    }

    fn get(&self) -> u32 {
        self.0.load(Relaxed)
    }
}

/// Progress of the tasks.
#[derive(Debug, Default)]
pub struct Liveness {
    /// Runs of `drdy`.
    pub acquired: Progress,
    /// Runs of `detect` that emptied its queue.
    pub detected: Progress,
    /// Windows passed to the fit.
    pub fits_due: Progress,
    /// Windows that the fit has finished, with any result.
    pub fits_done: Progress,
}

impl Liveness {
    /// Starts without progress.
    pub const fn new() -> Self {
        let [acquired, detected, fits_due, fits_done] = [const { Progress::new() }; 4];
        Self {
            acquired,
            detected,
            fits_due,
            fits_done,
        }
    }
}

/// Decides when to feed the watchdog.
#[derive(Debug, Default)]
pub struct WatchdogPolicy {
    acquired: u32,
    detected: u32,
    fits_done: u32,
}

impl WatchdogPolicy {
    /// Creates the policy for a watchdog that was just fed.
    pub const fn new() -> Self {
        Self {
            acquired: 0,
            detected: 0,
            fits_done: 0,
        }
    }

    /// True if the watchdog is to be fed now.
    pub fn feeds(&mut self, liveness: &Liveness) -> bool {
        let now = Self {
            acquired: liveness.acquired.get(),
            detected: liveness.detected.get(),
            fits_done: liveness.fits_done.get(),
        };
        let fit_idle = now.fits_done == liveness.fits_due.get();
        let alive = now.acquired != self.acquired
            && now.detected != self.detected
            && (fit_idle || now.fits_done != self.fits_done);
        if alive {
            *self = now;
        }
        alive
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stage that makes no progress in a test.
    #[derive(Clone, Copy, PartialEq)]
    enum Still {
        None,
        Acquisition,
        Detection,
        Fit,
    }

    /// Simulates half a second of progress, with a window due.
    fn live(liveness: &Liveness, still: Still) {
        for _ in 0..2532 {
            if still != Still::Acquisition {
                liveness.acquired.bump();
            }
            if still != Still::Detection {
                liveness.detected.bump();
            }
        }
        liveness.fits_due.bump();
        if still != Still::Fit {
            liveness.fits_done.bump();
        }
    }

    #[test]
    fn it_is_fed_as_long_as_all_go_on_and_never_again_once_one_stands_still() {
        for still in [
            Still::None,
            Still::Acquisition,
            Still::Detection,
            Still::Fit,
        ] {
            let (liveness, mut watchdog_policy) = (Liveness::new(), WatchdogPolicy::new());
            for _ in 0..10 {
                live(&liveness, Still::None);
                assert!(watchdog_policy.feeds(&liveness));
            }
            for _ in 0..100 {
                live(&liveness, still);
                assert_eq!(watchdog_policy.feeds(&liveness), still == Still::None);
            }
        }
    }

    #[test]
    fn nothing_done_since_the_last_feeding_is_no_life() {
        let (liveness, mut watchdog_policy) = (Liveness::new(), WatchdogPolicy::new());
        assert!(!watchdog_policy.feeds(&liveness));
        live(&liveness, Still::None);
        assert!(watchdog_policy.feeds(&liveness));
        assert!(!watchdog_policy.feeds(&liveness));
    }

    #[test]
    fn a_silent_chip_and_an_idle_fit_are_no_reason_for_a_reset() {
        let (liveness, mut watchdog_policy) = (Liveness::new(), WatchdogPolicy::new());
        for _ in 0..100 {
            // Only the check of the chip runs, and the detection that it starts.
            liveness.acquired.bump();
            liveness.detected.bump();
            assert!(watchdog_policy.feeds(&liveness));
        }
    }

    #[test]
    fn a_fit_that_takes_its_time_is_no_reason_for_a_reset() {
        let (liveness, mut watchdog_policy) = (Liveness::new(), WatchdogPolicy::new());
        let mut fed = 0;
        // Every window takes as long as five checks; strides are skipped, and one always waits.
        liveness.fits_due.bump();
        for look in 1..=100 {
            liveness.acquired.bump();
            liveness.detected.bump();
            if look % 5 == 0 {
                liveness.fits_due.bump();
                liveness.fits_done.bump();
            }
            fed += u32::from(watchdog_policy.feeds(&liveness));
        }
        assert_eq!(fed, 20, "whenever a window is done");
    }

    #[test]
    fn the_counters_may_wrap() {
        let (liveness, mut watchdog_policy) = (Liveness::new(), WatchdogPolicy::new());
        liveness.acquired.0.store(u32::MAX, Relaxed);
        liveness.detected.bump();
        assert!(watchdog_policy.feeds(&liveness));
        liveness.acquired.bump();
        liveness.detected.bump();
        assert!(watchdog_policy.feeds(&liveness));
    }
}
