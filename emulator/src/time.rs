//! Virtual time: processor cycles, and nanoseconds according to the current clock.

const SECOND_NS: u64 = 1_000_000_000;

/// Time since power-up. Instructions and on-chip peripherals count cycles; the ADC counts
/// nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time {
    /// Processor cycles since power-up.
    pub cycles: u64,
    base_cycles: u64,
    base_ns: u64,
    hz: u64,
}

impl Time {
    /// Creates the time of power-up, with a processor clock in hertz.
    pub const fn new(hz: u64) -> Self {
        Self {
            cycles: 0,
            base_cycles: 0,
            base_ns: 0,
            hz,
        }
    }

    pub const fn ns(&self) -> u64 {
        self.ns_at(self.cycles)
    }

    /// Time at a number of cycles, which must be no earlier than the latest change of the clock and
    /// less than 100 s ahead.
    pub const fn ns_at(&self, cycles: u64) -> u64 {
        self.base_ns + cycles.saturating_sub(self.base_cycles) * SECOND_NS / self.hz
    }

    /// Returns the first cycle at or after a time.
    pub const fn cycle_at(&self, ns: u64) -> u64 {
        let ns = ns.saturating_sub(self.base_ns);
        let whole = ns / SECOND_NS * self.hz;
        self.base_cycles + whole + (ns % SECOND_NS * self.hz).div_ceil(SECOND_NS)
    }

    pub const fn hz(&self) -> u64 {
        self.hz
    }

    /// Changes the processor's clock from now on.
    pub const fn change(&mut self, hz: u64) {
        (self.base_ns, self.base_cycles, self.hz) = (self.ns(), self.cycles, hz);
    }

    /// Moves the base by whole seconds, so that products fit in 64 bits. Call this at least every
    /// minute.
    pub const fn settle(&mut self) {
        while self.cycles - self.base_cycles >= self.hz {
            self.base_cycles += self.hz;
            self.base_ns += SECOND_NS;
        }
    }

    /// Lets time pass without cycles while the processor's clock is stopped.
    pub const fn stand_still_until(&mut self, ns: u64) {
        (self.base_ns, self.base_cycles) = (ns, self.cycles);
    }
}

#[cfg(test)]
mod tests {
    use super::Time;

    #[test]
    fn a_year_at_168_mhz_is_exact() {
        let mut time = Time::new(16_000_000);
        time.cycles = 16;
        time.change(168_000_000);
        for _ in 0..365 * 24 * 60 {
            time.cycles += 168_000_000 * 60;
            time.settle();
        }
        assert_eq!(time.ns(), 365 * 86_400 * 1_000_000_000 + 1000);
        assert_eq!(time.cycle_at(time.ns()), time.cycles);
        let later_ns = time.ns() + 3_600_000_000_000;
        assert_eq!(time.cycle_at(later_ns), time.cycles + 168_000_000 * 3600);
        time.stand_still_until(later_ns);
        assert_eq!(
            (time.ns(), time.cycle_at(later_ns)),
            (later_ns, time.cycles)
        );
    }
}
