//! How many conversions a chip can have made that nobody saw.
//!
//! Behind a gap the chip's ids and the time say what was lost, if it ran as it was told to. With other registers, as after
//! a reset of its own, it is up to five times as fast (SBAS297G, rate table), and its ids are those of another scan: then
//! only the most that it can have made is known.

use crate::scan::CONVERSION_NS;

/// The chip's clock, at most, hertz (SBAS297G: 16 MHz).
const CLOCK_MOST_HZ: u64 = 16_000_000;
/// MUXMOD in CONFIG0: fixed channel.
const MUXMOD: u8 = 0x20;
/// Clock periods of a conversion, at least (SBAS297G, rate table): scanning, 128 (1 + 4.265625), and with a fixed channel.
const SCANNING_TICKS: u64 = 674;
const FIXED_TICKS: u64 = 128;
/// In so much time a clock that is 2 % fast makes one conversion of the scan more, microseconds.
const CLOCK_SHARE_US: u32 = (50 * CONVERSION_NS / 1000) as u32;
/// A gap in time that is one, microseconds: two conversions of the scan and an interrupt that was late.
const GAP_US: u32 = 450;

/// Times without a conversion since the registers were known to be right.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unseen {
    gaps_us: u32,
}

impl Unseen {
    /// None.
    pub const fn new() -> Self {
        Self { gaps_us: 0 }
    }

    /// From one conversion to the next so much time passed, microseconds.
    #[inline(always)]
    pub fn passed(&mut self, passed_us: u32) {
        if passed_us > GAP_US {
            self.gaps_us = self.gaps_us.saturating_add(passed_us);
        }
    }

    /// The registers are right, or were just written: what is missing will be known by ids and time.
    pub fn is_sound(&mut self) {
        self.gaps_us = 0;
    }

    /// The most conversions that the chip can have made in the gaps and in the time since the latest one, microseconds,
    /// its CONFIG0 being this now; as a bus reads that is stuck it is none.
    pub fn at_most(&self, since_us: u32, config0: Option<u8>) -> u32 {
        let is_fixed = config0.is_some_and(|config0| config0 != 0xff && config0 & MUXMOD != 0);
        let ticks = if is_fixed { FIXED_TICKS } else { SCANNING_TICKS };
        // Rounded down, so that there are not too few.
        let period_us = (ticks * 1_000_000 / CLOCK_MOST_HZ) as u32;
        self.gaps_us.saturating_add(since_us) / period_us + 1
    }

    /// The most conversions that a chip made with the right registers and a clock that is fast, beyond those that the
    /// nominal one makes in this time, microseconds; and what it finishes until it is reset.
    pub fn of_clock(since_us: u32) -> u32 {
        since_us / CLOCK_SHARE_US + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_gaps_count_and_only_since_all_was_right() {
        let mut unseen = Unseen::new();
        [197, 198, 400].into_iter().for_each(|passed_us| unseen.passed(passed_us));
        assert_eq!(unseen.at_most(0, None), 1);
        unseen.passed(10_000);
        // 23,739 conversions a second (SBAS297G, rate table, 16 MHz).
        assert!((237..=242).contains(&unseen.at_most(0, Some(0x0a))));
        // 125,000 of a fixed channel, for another 10 ms.
        assert_eq!(unseen.at_most(10_000, Some(0x2a)), 2501);
        unseen.is_sound();
        assert_eq!(unseen.at_most(100, Some(0xff)), 3);
        // 5064 conversions a second.
        assert!((100..=104).contains(&Unseen::of_clock(1_000_000)));
    }
}
