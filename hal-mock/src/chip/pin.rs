//! The DRDY pin as it arrives at the processor: the chip's own edges, less and more what a fault takes and adds.

use super::Ads1258;
use super::timing::Timing;

/// What is wrong with the line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drdy {
    /// Stuck at this level, true for high.
    stuck: Option<bool>,
    /// So many of the chip's next edges do not arrive.
    to_lose: u32,
    /// One edge more than the chip's own.
    repeat_ns: Option<u64>,
    /// Edges every so often, from this time on.
    storm: Option<(u64, u64)>,
}

impl Drdy {
    /// The chip has made an edge.
    pub(crate) fn passed(&mut self) {
        self.to_lose = self.to_lose.saturating_sub(1);
    }
}

impl Ads1258 {
    /// Level of the DRDY pin. Low: there is an unread result. While one stays unread the pin is high for the last tCLK
    /// before the next falls.
    pub fn drdy_high(&mut self, now_ns: u64) -> bool {
        self.advance_to(now_ns);
        let pulse = self.conversion.as_ref().is_some_and(|c| self.now_ns >= c.at_ns(self.clock, c.end_cycle - 1));
        self.drdy.stuck.unwrap_or(!self.drdy_low || pulse)
    }

    /// Time of the latest falling edge that the chip itself has made.
    pub fn latest_drdy_fall_ns(&self) -> Option<u64> {
        self.latest_fall_ns
    }

    /// Time of the next falling edge that arrives, later than the time advanced to, as far as faults that are in force
    /// tell. `None` while idle, in reset, stalled, stuck, or when no input is selected.
    pub fn next_drdy_fall_ns(&self) -> Option<u64> {
        if self.drdy.stuck.is_some() {
            return None;
        }
        let own_ns = self.conversion.as_ref().map(|c| {
            let skipped = u64::from(self.drdy.to_lose) * Timing::of(&self.registers).period_cycles();
            c.at_ns(self.clock, c.end_cycle + skipped)
        });
        let repeat_ns = self.drdy.repeat_ns.filter(|repeat_ns| *repeat_ns > self.now_ns);
        let storm_ns = self.drdy.storm.map(|(from_ns, period_ns)| {
            let passed = self.now_ns.saturating_sub(from_ns) / period_ns;
            from_ns + (passed + 1) * period_ns
        });
        [own_ns, repeat_ns, storm_ns].into_iter().flatten().min()
    }

    /// Whether the pin is stuck: then it has a level, but no edges.
    pub fn is_drdy_stuck(&self) -> bool {
        self.drdy.stuck.is_some()
    }

    /// The pin stuck at a level, true for high; `None`: free again.
    pub fn set_drdy_stuck(&mut self, level: Option<bool>) {
        self.drdy.stuck = level;
    }

    /// The next `count` falling edges do not arrive.
    pub fn lose_drdy_edges(&mut self, count: u32) {
        self.drdy.to_lose = count;
    }

    /// A falling edge without a new result `after_ns` from now.
    pub fn repeat_drdy_edge(&mut self, after_ns: u64) {
        self.drdy.repeat_ns = Some(self.now_ns + after_ns);
    }

    /// Falling edges without a new result every `period_ns` (at least 1), between the chip's own; `None`: no more.
    pub fn set_drdy_storm(&mut self, period_ns: Option<u64>) {
        self.drdy.storm = period_ns.map(|period_ns| (self.now_ns, period_ns.max(1)));
    }
}
