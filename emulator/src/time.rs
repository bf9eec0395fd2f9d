//! Virtual time: processor cycles, and nanoseconds through the present clock.

/// Time since power-up. Cycles are what instructions and on-chip peripherals count; nanoseconds are
/// what the ADC counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time {
    /// Processor cycles since power-up.
    pub cycles: u64,
    base_cycles: u64,
    base_ns: u64,
    khz: u64,
}

impl Time {
    /// Power-up with a processor clock in kilohertz.
    pub const fn new(khz: u64) -> Self {
        Self {
            cycles: 0,
            base_cycles: 0,
            base_ns: 0,
            khz,
        }
    }

    /// Nanoseconds since power-up.
    pub const fn ns(&self) -> u64 {
        self.ns_at(self.cycles)
    }

    /// Time at another number of cycles, not before the clock's latest change.
    pub const fn ns_at(&self, cycles: u64) -> u64 {
        self.base_ns + cycles.saturating_sub(self.base_cycles) * 1_000_000 / self.khz
    }

    /// The first cycle at or after a time.
    pub const fn cycle_at(&self, ns: u64) -> u64 {
        self.base_cycles + (ns.saturating_sub(self.base_ns) * self.khz).div_ceil(1_000_000)
    }

    /// Cycles in a second.
    pub const fn hz(&self) -> u64 {
        self.khz * 1000
    }

    /// From now on the processor's clock is another.
    pub const fn change(&mut self, khz: u64) {
        (self.base_ns, self.base_cycles, self.khz) = (self.ns(), self.cycles, khz);
    }
}

#[cfg(test)]
mod tests {
    use super::Time;

    #[test]
    fn an_hour_at_168_mhz_is_exact() {
        let mut time = Time::new(16_000);
        time.cycles = 16;
        time.change(168_000);
        time.cycles += 168_000_000 * 3600;
        assert_eq!(time.ns(), 3_600_000_001_000);
        assert_eq!(time.cycle_at(time.ns()), time.cycles);
    }
}
