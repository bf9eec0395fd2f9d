//! Processor load from the time spent asleep.

/// From one reading to the next, microseconds: once a second, as `health` is sent.
const PERIOD_US: u32 = 1_000_000;

/// Adds up sleep and turns it into a load.
#[derive(Debug)]
pub struct LoadMeter {
    began_us: u32,
    asleep_us: u32,
}

impl LoadMeter {
    /// A meter whose first period begins when the microsecond counter starts.
    pub const fn new() -> Self {
        Self { began_us: 0, asleep_us: 0 }
    }

    /// Takes one sleep, from `from_us` to `to_us` on the wrapping microsecond counter. When a period is over, gives the
    /// load since the last reading, 0 to 1.
    pub fn slept(&mut self, from_us: u32, to_us: u32) -> Option<f32> {
        self.asleep_us += to_us.wrapping_sub(from_us);
        let elapsed_us = to_us.wrapping_sub(self.began_us);
        if elapsed_us < PERIOD_US {
            return None;
        }
        let load = 1.0 - self.asleep_us as f32 / elapsed_us as f32;
        *self = Self { began_us: to_us, asleep_us: 0 };
        Some(load.clamp(0.0, 1.0))
    }
}

impl Default for LoadMeter {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn load_is_the_share_of_time_awake() {
        let mut meter = LoadMeter::new();
        assert_eq!(meter.slept(100_000, 500_000), None);
        assert_eq!(meter.slept(650_000, 1_000_000), Some(0.25));
        assert_eq!(meter.slept(1_000_000, 1_500_000), None);
        assert_eq!(meter.slept(2_000_000, 2_000_000), Some(0.5));
    }

    #[test]
    fn the_counter_may_wrap() {
        let mut meter = LoadMeter { began_us: u32::MAX - 499_999, asleep_us: 0 };
        assert_eq!(meter.slept(u32::MAX, 499_999), None);
        assert_eq!(meter.slept(500_000, 500_000), Some(0.5));
    }
}
