//! Signs of life of the tasks, for the watchdog: it is fed while samples are made and `requests`
//! runs.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// What the tasks have done, wrapping. Each has one writer.
#[derive(Debug, Default)]
pub struct Liveness {
    samples: AtomicU32,
    requests: AtomicU32,
}

impl Liveness {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self {
            samples: AtomicU32::new(0),
            requests: AtomicU32::new(0),
        }
    }

    /// `requests` has run to its end; the sampler had made `samples` samples by then.
    pub fn ran(&self, samples: u32) {
        self.samples.store(samples, Relaxed);
        self.requests
            .store(self.requests.load(Relaxed).wrapping_add(1), Relaxed);
    }
}

/// Decides twice a second.
#[derive(Debug, Default)]
pub struct WatchdogPolicy {
    samples: u32,
    requests: u32,
}

impl WatchdogPolicy {
    /// The watchdog was just fed; nothing done since.
    pub const fn new() -> Self {
        Self {
            samples: 0,
            requests: 0,
        }
    }

    /// Whether to feed the watchdog now: both have gone on.
    #[must_use]
    pub fn feeds(&mut self, liveness: &Liveness) -> bool {
        let (samples, requests) = (
            liveness.samples.load(Relaxed),
            liveness.requests.load(Relaxed),
        );
        let is_alive = samples != self.samples && requests != self.requests;
        if is_alive {
            (self.samples, self.requests) = (samples, requests);
        }
        is_alive
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_fed_only_while_both_go_on() {
        let (liveness, mut policy) = (Liveness::new(), WatchdogPolicy::new());
        assert!(!policy.feeds(&liveness));
        liveness.ran(40);
        assert!(policy.feeds(&liveness));
        assert!(!policy.feeds(&liveness), "nothing since");
        liveness.ran(40);
        assert!(!policy.feeds(&liveness), "no sample since");
        liveness.ran(80);
        assert!(policy.feeds(&liveness));
    }
}
