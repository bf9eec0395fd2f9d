//! The DRDY pin at the processor. It has the chip's own edges; a fault removes some of them, or
//! adds others.

use super::Ads1258;
use super::timing::Timing;

impl Ads1258 {
    /// Level of the DRDY pin. Low: there is an unread result; high for the last tCLK before the
    /// next one.
    pub fn drdy_high(&mut self, now_ns: u64) -> bool {
        self.advance_to(now_ns);
        let pulse = self
            .conversion
            .as_ref()
            .is_some_and(|c| self.now_ns >= c.at_ns(self.clock, c.end_cycle - 1));
        self.faults.drdy_stuck.unwrap_or(!self.drdy_low || pulse)
    }

    /// Time of the latest falling edge that the chip itself has made.
    pub fn latest_drdy_fall_ns(&self) -> Option<u64> {
        self.latest_fall_ns
    }

    /// Time of the next falling edge that arrives, later than the time advanced to, as far as the
    /// faults in force show. `None` while idle, in reset, stalled, stuck, or when no input is
    /// selected.
    pub fn next_drdy_fall_ns(&self) -> Option<u64> {
        if self.is_drdy_stuck() {
            return None;
        }
        let own_ns = self.conversion.as_ref().map(|c| {
            let skipped =
                u64::from(self.faults.edges_lost) * Timing::of(&self.registers).period_cycles();
            c.at_ns(self.clock, c.end_cycle + skipped)
        });
        let repeated_ns = self
            .faults
            .edge_repeated_ns
            .filter(|repeated_ns| *repeated_ns > self.now_ns);
        let storm_ns = self.faults.storm_ns.map(|(from_ns, period_ns)| {
            let passed = self.now_ns.saturating_sub(from_ns) / period_ns;
            from_ns + (passed + 1) * period_ns
        });
        [own_ns, repeated_ns, storm_ns].into_iter().flatten().min()
    }

    /// True if the pin is stuck: then it has a level, but no edges.
    pub fn is_drdy_stuck(&self) -> bool {
        self.faults.drdy_stuck.is_some()
    }
}
