//! Clocks of a board: dividers are computed from its oscillator and the required clocks at compile
//! time. A clock that the chip cannot produce is a compile error.

use stm32f4xx_hal::rcc::{PCLK1_MAX, PCLK2_MAX, SYSCLK_MAX};

/// Clock at the processor's pin OSC_IN, megahertz.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "each board has one of them")]
pub enum Oscillator {
    /// A crystal between OSC_IN and OSC_OUT.
    Crystal(u32),
    /// Output of another chip.
    Clock(u32),
}

/// Clocks of a board, megahertz.
#[derive(Clone, Copy)]
pub struct Clocks {
    pub oscillator: Oscillator,
    /// Processor and AHB.
    pub sysclk_mhz: u32,
    pub apb1_mhz: u32,
    pub apb2_mhz: u32,
    /// Field VOS of PWR_CR for the regulator's highest range, if the reset value does not allow
    /// `sysclk_mhz`.
    pub vos: Option<u32>,
}

/// Main PLL: VCO = oscillator / `m` * `n`, processor = VCO / `p` (RM0090, 7.3.2).
#[derive(Clone, Copy)]
pub struct Pll {
    pub m: u32,
    pub n: u32,
    pub p: u32,
    /// VCO / `q` is at most 48 MHz, the limit of USB, which is not used here.
    pub q: u32,
}

impl Clocks {
    pub const fn oscillator_mhz(&self) -> u32 {
        let (Oscillator::Crystal(mhz) | Oscillator::Clock(mhz)) = self.oscillator;
        assert!(4 <= mhz && mhz <= 26, "OSC_IN takes 4 to 26 MHz");
        mhz
    }

    pub const fn is_clock(&self) -> bool {
        matches!(self.oscillator, Oscillator::Clock(_))
    }

    /// Settings of the PLL. Its input is 2 MHz, which has the least jitter, or 1 MHz if the
    /// oscillator's frequency is odd; its VCO runs at 192 to 432 MHz, as all chips of the family
    /// allow.
    pub const fn pll(&self) -> Pll {
        assert!(
            self.sysclk_mhz * 1_000_000 <= SYSCLK_MAX,
            "the processor's clock is too fast"
        );
        assert!(
            self.apb1_mhz * 1_000_000 <= PCLK1_MAX,
            "APB1's clock is too fast"
        );
        assert!(
            self.apb2_mhz * 1_000_000 <= PCLK2_MAX,
            "APB2's clock is too fast"
        );
        assert!(
            is_divided(self.sysclk_mhz, self.apb1_mhz),
            "APB1 divides by 1, 2, 4, 8 or 16"
        );
        assert!(
            is_divided(self.sysclk_mhz, self.apb2_mhz),
            "APB2 divides by 1, 2, 4, 8 or 16"
        );
        let input_mhz = if self.oscillator_mhz().is_multiple_of(2) {
            2
        } else {
            1
        };
        let mut p = 2;
        while self.sysclk_mhz * p < 192 {
            p += 2;
        }
        let vco_mhz = self.sysclk_mhz * p;
        assert!(
            p <= 8 && vco_mhz <= 432,
            "the PLL cannot make the processor's clock"
        );
        assert!(
            vco_mhz.is_multiple_of(input_mhz),
            "the PLL cannot make the processor's clock"
        );
        Pll {
            m: self.oscillator_mhz() / input_mhz,
            n: vco_mhz / input_mhz,
            p,
            q: vco_mhz.div_ceil(48),
        }
    }

    /// Clock of the timers on APB1, megahertz: twice the bus clock if that is divided (RM0090,
    /// 7.2).
    pub const fn apb1_timers_mhz(&self) -> u32 {
        timers_mhz(self.sysclk_mhz, self.apb1_mhz)
    }

    #[allow(dead_code, reason = "for the ADS1258's clock alone")]
    pub const fn apb2_timers_mhz(&self) -> u32 {
        timers_mhz(self.sysclk_mhz, self.apb2_mhz)
    }

    /// Fastest SCLK of SPI1 up to `max_hz`, hertz: APB2's clock divided by a power of two.
    #[allow(dead_code, reason = "for the ADS1258 alone")]
    pub const fn spi1_hz(&self, max_hz: u32) -> u32 {
        let mut divider = 2;
        while self.apb2_mhz * 1_000_000 / divider > max_hz {
            divider *= 2;
        }
        assert!(divider <= 256, "SPI1 divides by 256 at most");
        self.apb2_mhz * 1_000_000 / divider
    }

    /// Number of processor cycles that take at least `ns` nanoseconds.
    #[allow(dead_code, reason = "for the ADS1258 alone")]
    pub const fn cycles(&self, ns: u32) -> u32 {
        (self.sysclk_mhz * ns).div_ceil(1000)
    }
}

const fn timers_mhz(sysclk_mhz: u32, apb_mhz: u32) -> u32 {
    if apb_mhz == sysclk_mhz {
        apb_mhz
    } else {
        2 * apb_mhz
    }
}

const fn is_divided(sysclk_mhz: u32, apb_mhz: u32) -> bool {
    sysclk_mhz.is_multiple_of(apb_mhz)
        && (sysclk_mhz / apb_mhz).is_power_of_two()
        && sysclk_mhz / apb_mhz <= 16
}
