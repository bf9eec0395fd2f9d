//! Duration of a conversion and its sampling instant, in clock cycles (tCLK).

use super::registers::{CHOP, MUXMOD, Registers};

/// Timing settings of the filter at the start of the conversion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timing {
    fixed: bool,
    chop: bool,
    /// Averaging: N = 4^(3 - DRATE).
    n: u64,
    /// Switching delay TD in units of 128 tCLK.
    td: u64,
}

/// 4.265625 * 128: four more filter periods and the multiplexer's overhead of 34 tCLK.
const SETTLE_CYCLES: u64 = 546;
/// Extra duration of the first conversion after START, which makes it 128 (N + 4) + 68.
const START_CYCLES: u64 = 34;

impl Timing {
    pub(crate) fn of(registers: &Registers) -> Self {
        const TD: [u64; 8] = [0, 1, 2, 4, 8, 16, 32, 48];
        Self {
            fixed: registers.bit(MUXMOD),
            chop: registers.bit(CHOP),
            n: 1 << (2 * (3 - registers.drate())),
            td: TD[usize::from(registers.dly())],
        }
    }

    /// One pass through the filter after a step of the multiplexer.
    fn pass_cycles(self) -> u64 {
        128 * (self.n + self.td) + SETTLE_CYCLES
    }

    /// Cycles from one result to the next. Source: the datasheet's rate table, all entries.
    pub(crate) fn period_cycles(self) -> u64 {
        if self.fixed && !self.chop {
            128 * self.n
        } else {
            self.pass_cycles() << u32::from(self.chop)
        }
    }

    /// Cycles from the start condition in standby to the first result: 128 (N + 4) + 68 without
    /// chopping. Chopping needs two passes. The datasheet does not specify whether DLY counts here:
    /// `with_delay` decides.
    pub(crate) fn first_cycles(self, with_delay: bool) -> u64 {
        let pass = 128 * self.n + SETTLE_CYCLES + if with_delay { 128 * self.td } else { 0 };
        (pass << u32::from(self.chop)) + START_CYCLES
    }

    /// Cycles from the sampling instant to the result. The filter is symmetric, so this is half of
    /// its length of 128 (N + 4) tCLK; with chopping, the middle of two such passes.
    pub(crate) fn sample_delay_cycles(self) -> u64 {
        64 * (self.n + 4) + if self.chop { self.pass_cycles() / 2 } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chip::registers::{CONFIG0, CONFIG1};

    fn timing(config0: u8, config1: u8) -> Timing {
        let mut registers = Registers::new(0x8B);
        registers.write(CONFIG0, config0);
        registers.write(CONFIG1, config1);
        Timing::of(&registers)
    }

    #[test]
    fn the_rate_table_at_16_mhz() {
        let sps = |t: Timing| 16e6 / t.period_cycles() as f64;
        for (drate, auto, fixed) in [
            (3, 23739.0, 125000.0),
            (2, 15123.0, 31250.0),
            (1, 6168.0, 7812.5),
            (0, 1831.0, 1953.0),
        ] {
            assert!(
                (sps(timing(0x02, drate)) - auto).abs() < 1.0,
                "auto, DRATE {drate}"
            );
            assert!(
                (sps(timing(0x22, drate)) - fixed).abs() < 1.0,
                "fixed, DRATE {drate}"
            );
        }
    }

    #[test]
    fn the_projects_scan() {
        let t = timing(0x02, 0x31); // DRATE 1, DLY 3
        assert_eq!(t.period_cycles(), 3106);
        assert!((15_728_640.0 / 3106.0 / 21.0 - 241.14_f64).abs() < 0.005);
        // The alternative: 16 MHz, CHOP 1, DRATE 2, DLY 4, 16 slots.
        assert!((16e6 / timing(0x06, 0x42).period_cycles() as f64 / 16.0 - 240.15).abs() < 0.005);
    }

    #[test]
    fn the_first_conversion() {
        assert_eq!(timing(0x02, 0x03).first_cycles(false), 708);
        assert_eq!(timing(0x02, 0x31).first_cycles(false), 128 * 20 + 68);
        assert_eq!(timing(0x02, 0x31).first_cycles(true), 128 * 24 + 68);
    }
}
