//! Clock cycles to nanoseconds, exactly: integers only, from the absolute count, so nothing
//! accumulates.

/// The chip's clock as an integer number of microhertz (1 ppm of 16 MHz is 16 million of them).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    microhertz: u64,
}

/// Nanoseconds per second times microhertz per hertz.
const SCALE: u128 = 1_000_000_000_000_000;

impl Clock {
    pub(crate) fn new(nominal_hz: u32, error_ppm: f64) -> Self {
        let microhertz = libm::rint(f64::from(nominal_hz) * (1e6 + error_ppm));
        Self {
            microhertz: (microhertz as u64).max(1),
        }
    }

    /// Duration of `cycles` in nanoseconds, rounded down.
    pub(crate) fn ns(self, cycles: u64) -> u64 {
        (u128::from(cycles) * SCALE / u128::from(self.microhertz)) as u64
    }

    /// Cycles that have passed in `ns`, rounded down.
    pub(crate) fn cycles(self, ns: u64) -> u64 {
        (u128::from(ns) * u128::from(self.microhertz) / SCALE) as u64
    }

    /// Duration of `cycles` in seconds.
    pub(crate) fn seconds(self, cycles: u64) -> f64 {
        cycles as f64 / (self.microhertz as f64 * 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_of_cycles_does_not_drift() {
        let clock = Clock::new(15_728_640, 0.0);
        assert_eq!(clock.ns(15_728_640 * 3600), 3_600_000_000_000);
        assert_eq!(clock.ns(1), 63);
    }

    #[test]
    fn a_fast_clock_needs_less_time() {
        // 100 ppm fast: a nominal second's cycles take 1/1.0001 s.
        assert_eq!(Clock::new(16_000_000, 100.0).ns(16_000_000), 999_900_009);
    }
}
