//! Upper bound on the number of conversions that the board missed.
//!
//! After a gap, ids and time show how many conversions were lost, if the registers are right. With
//! other registers, as after a spontaneous reset, the chip may be faster and send the ids of a
//! different scan, so only an upper bound is known.

use ridgetone_proto::division::divide;

/// Maximum time from the start of a check that finds a changed register to the stop of the scan,
/// microseconds. The ADS1258's 26 bytes take 40 us at 5.25 MHz; the rest is the overhead of three
/// transfers.
const CHECK_US: u32 = 100;

/// Total length of the gaps between conversions since the registers were known to be right.
#[derive(Clone, Copy, Debug)]
pub struct Unseen {
    gaps_us: u32,
    /// Time in which a clock that is 2 % fast adds one conversion to the scan, microseconds.
    extra_us: u32,
    /// Time between two conversions above which there is a gap, microseconds: two conversions plus
    /// the delay of a late interrupt.
    gap_us: u32,
}

impl Unseen {
    /// Starts with no missed conversions; `conversion_ns` is the nominal period.
    pub const fn new(conversion_ns: u32) -> Self {
        let gap_us = divide(conversion_ns as u64 * 228, 100_000).0 as u32;
        Self {
            gaps_us: 0,
            extra_us: conversion_ns / 20,
            gap_us,
        }
    }

    /// Adds the time from one conversion to the next, microseconds.
    #[inline(always)]
    pub fn passed(&mut self, passed_us: u32) {
        if passed_us > self.gap_us {
            self.gaps_us = self.gaps_us.saturating_add(passed_us);
        }
    }

    /// Forgets the gaps, because the registers are right, and ids and times will show all losses.
    pub fn reset(&mut self) {
        self.gaps_us = 0;
    }

    /// Maximum number of conversions in the gaps and from the latest one to the stop of the scan,
    /// after a check has found a changed register. The check began `since_us` microseconds after
    /// the latest conversion; with the changed register a conversion takes at least `period_us`.
    pub fn at_most(&self, since_us: u32, period_us: u32) -> u32 {
        self.gaps_us
            .saturating_add(since_us)
            .saturating_add(CHECK_US)
            / period_us.max(1)
            + 1
    }

    /// Maximum number of conversions by which a chip with the right registers but a fast clock gets
    /// ahead of a nominal one in `since_us` microseconds, including those finished before the
    /// reset.
    pub fn of_clock(&self, since_us: u32) -> u32 {
        since_us / self.extra_us.max(1) + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_gaps_since_the_registers_were_right_count() {
        let mut unseen = Unseen::new(197_474);
        [197, 198, 400]
            .into_iter()
            .for_each(|passed_us| unseen.passed(passed_us));
        // 23,739 conversions a second (SBAS297G, rate table, 16 MHz), during the 100 us of the
        // check.
        assert_eq!(unseen.at_most(0, 42), 3);
        unseen.passed(10_000);
        assert!((239..=244).contains(&unseen.at_most(0, 42)));
        // A fixed channel at 125,000 conversions a second, for another 10 ms.
        assert_eq!(unseen.at_most(10_000, 8), 2501 + 12);
        unseen.reset();
        assert_eq!(unseen.at_most(100, 42), 5);
        // 5064 conversions a second.
        assert!((100..=104).contains(&unseen.of_clock(1_000_000)));
    }
}
