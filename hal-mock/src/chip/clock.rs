//! Converts clock cycles to nanoseconds with integers, always from the absolute count, so that no
//! rounding error accumulates.

use super::Ads1258;

/// The chip's clock as an integer number of microhertz (1 ppm of 16 MHz is 16 million of them).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    microhertz: u64,
}

/// Nanoseconds per second times microhertz per hertz.
const SCALE: u128 = 1_000_000_000_000_000;

impl Clock {
    pub(crate) fn new(nominal_hz: u32, error_ppm: f64) -> Self {
        let microhertz = (f64::from(nominal_hz) * (1e6 + error_ppm)).round_ties_even();
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

    pub(crate) fn seconds(self, cycles: u64) -> f64 {
        cycles as f64 / (self.microhertz as f64 * 1e-6)
    }
}

impl Ads1258 {
    /// Changes the nominal frequency on CLKIO. At 0 Hz (no clock) the chip neither converts nor
    /// answers. The first clock begins the power-up; when a stopped clock starts, a conversion
    /// begins if START is high.
    pub fn set_clock(&mut self, now_ns: u64, clock_hz: u32) {
        self.advance_to(now_ns);
        let was_clocked = self.is_clocked();
        self.options.clock_hz = clock_hz;
        self.take_clock();
        if !self.is_clocked() {
            self.conversion = None;
        } else if !was_clocked {
            let power_up_ns = self.clock.ns(self.options.power_up_cycles);
            self.powered_ns.get_or_insert(now_ns + power_up_ns);
            self.start_again();
        }
    }

    pub(crate) fn is_clocked(&self) -> bool {
        self.options.clock_hz > 0
    }

    pub(crate) fn is_powered(&self, now_ns: u64) -> bool {
        self.is_clocked() && self.powered_ns.is_some_and(|end_ns| end_ns <= now_ns)
    }

    pub(crate) fn take_clock(&mut self) {
        self.conversion = self
            .conversion
            .take()
            .map(|running| running.rebased(self.clock, self.now_ns));
        self.clock = Clock::new(self.options.clock_hz, self.options.clock_error_ppm);
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
        // 100 ppm fast: the cycles of a nominal second take 1/1.0001 s.
        assert_eq!(Clock::new(16_000_000, 100.0).ns(16_000_000), 999_900_009);
    }
}
