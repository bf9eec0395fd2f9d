//! Rules that the image must keep, and records of broken ones.

use std::fmt;

/// Declares the rules and a list of all of them.
macro_rules! rules {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// A rule that is checked in every run.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Rule {
            $($(#[$doc])* $name,)*
        }

        impl Rule {
            /// All rules.
            pub const ALL: &[Self] = &[$(Self::$name),*];
        }
    };
}

rules! {
    /// A peripheral is used only while its clock is on (RM0090, 7.3.10 to 7.3.14).
    ClockOn,
    /// PLLCFGR is written only while the PLL is off (RM0090, 7.3.2).
    PllOff,
    /// HSEBYP is written only while HSE is off (RM0090, 7.3.1).
    HseOff,
    /// The flash has enough wait states for the new clock (RM0090, table 10, 2.7 to 3.6 V).
    WaitStates,
    /// Clocks stay within their limits (datasheets; VCO: RM0090, 7.3.2).
    ClockLimit,
    /// Pads are fast enough: SCK's for the APB clock (errata ES0182 and ES0298, delayed SCK
    /// feedback), the clock output's for the ADC's clock.
    PadSpeed,
    /// Pins have the functions in the board's table.
    PinFunction,
    /// SPI runs in mode 0 with 8 bits, most significant bit first (SBAS297G).
    SpiMode,
    /// SCLK is at most half the ADC's clock (SBAS297G).
    SpiClock,
    /// CS is low for 2.5 tCLK before SCLK and high for 2 tCLK between transactions; it rises only
    /// while SPI is idle (SBAS297G).
    ChipSelect,
    /// ADC registers are written only while START is low (SBAS297G).
    AdcWrite,
    /// The clock output for the ADC is at most 16 MHz, and high for 40 to 60 % of a period
    /// (SBAS297G).
    AdcClock,
    /// The on-chip ADC's sequence, sampling times and clock do not change while it converts
    /// (RM0090, 13.13).
    AdcSequence,
    /// The on-chip ADC has settled (tSTAB) before it converts (DS8626 and DS10693, ADC
    /// characteristics).
    AdcSettling,
    /// ADCDC1 in PWR_CR is set only with flash prefetch off, ADCxDC2 in SYSCFG_PMC only with the
    /// on-chip ADC clocked at 30 MHz or more, and never both (AN4073; RM0390, PWR_CR and
    /// SYSCFG_PMC).
    AdcAccuracy,
    /// No sample of the on-chip ADC is lost.
    AdcOverrun,
    /// A DMA stream is configured only while it is off (RM0090, 9.5.5 to 9.5.10).
    DmaEnabled,
    /// A stream starts with its flags cleared (RM0090, 9.3.18).
    DmaFlags,
    /// A stream's direction, sizes, channel and memory fit ADC1 and its inputs, or the USART's
    /// receiver (RM0090, 9.3.3).
    DmaSetting,
    /// Software has read that a stream stopped before it starts the stream again (RM0090, 9.5.5).
    DmaStop,
    /// No byte is lost in SPI's receiver.
    SpiOverrun,
    /// No byte is lost in the USART's receiver.
    UsartOverrun,
    /// Software does not read a byte from the USART's data register that the DMA is about to fetch
    /// (RM0090, 30.3.13).
    UsartData,
    /// The flash is written only after its keys, with PG or SER set, in the width of PSIZE (RM0090,
    /// 3.6).
    FlashSequence,
    /// A word of flash is programmed at most once between erases.
    FlashWordTwice,
    /// The watchdog is fed in time.
    Watchdog,
    /// The stack stays above its end.
    StackEnd,
    /// An interrupt has a cause in its peripheral, unless software has pended it, or a run of the
    /// same priority has already served the cause.
    SpuriousInterrupt,
    /// TIM2's reload register is written, because manuals disagree on its reset value.
    TimerReload,
}

/// A broken rule, recorded once per instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Broken rule.
    pub rule: Rule,
    /// Description of the first violation.
    pub detail: String,
    /// Address of the instruction running at the time.
    pub pc: u32,
    /// Virtual time of the first violation, nanoseconds since power-up.
    pub at_ns: u64,
    /// Number of violations at this instruction.
    pub times: u64,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            rule,
            detail,
            pc,
            at_ns,
            times,
        } = self;
        write!(
            f,
            "{rule:?}: {detail} ({times} times, first {:.6} s, at {pc:#010x})",
            *at_ns as f64 * 1e-9
        )
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Findings(pub Vec<Finding>);

impl Findings {
    /// Records a broken rule; repeats at the same instruction are only counted.
    pub fn add(&mut self, rule: Rule, detail: String, pc: u32, at_ns: u64) {
        match self
            .0
            .iter_mut()
            .find(|found| found.rule == rule && found.pc == pc)
        {
            Some(found) => found.times += 1,
            None => self.0.push(Finding {
                rule,
                detail,
                pc,
                at_ns,
                times: 1,
            }),
        }
    }
}
