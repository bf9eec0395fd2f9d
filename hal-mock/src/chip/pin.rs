//! The DRDY pin at the processor: the chip's own edges, less those that a fault removes and plus
//! those that a fault adds.

use super::Ads1258;
use super::timing::Timing;

impl Ads1258 {
    /// Level of the DRDY pin. Low while a result is unread; high for the last tCLK before the next
    /// result.
    pub fn drdy_high(&mut self, now_ns: u64) -> bool {
        self.advance_to(now_ns);
        let pulse = self
            .conversion
            .as_ref()
            .is_some_and(|c| self.now_ns >= c.at_ns(self.clock, c.end_cycle - 1));
        self.faults.drdy_stuck.unwrap_or(!self.drdy_low || pulse)
    }

    /// Time of the chip's latest falling edge, not counting those that faults add.
    pub fn latest_drdy_fall_ns(&self) -> Option<u64> {
        self.latest_fall_ns
    }

    /// Time of the next falling edge that will arrive, given the current faults; always later than
    /// now. `None` while idle, in reset, stalled, stuck, or when no input is selected.
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

    /// True if the pin is stuck: it keeps its level and has no edges.
    pub fn is_drdy_stuck(&self) -> bool {
        self.faults.drdy_stuck.is_some()
    }
}
