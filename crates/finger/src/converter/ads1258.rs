//! The ADS1258 as a [`Converter`].

use super::{Ads1258Plan, Converter, REGISTERS, Sample, Scanned, Tag};
use crate::frame::TimedConversion;
use ads1258::{Ads1258, Conversion, Register, Status};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use ridgetone_proto::plan::{Plan, PlanError};

/// Maximum clock of the chip, hertz (SBAS297G: 16 MHz).
const CLOCK_MAX_HZ: u64 = 16_000_000;
/// MUXMOD in CONFIG0: fixed channel.
const MUXMOD: u8 = 0x20;
/// Minimum clock periods of a conversion (SBAS297G, rate table): when scanning, 128 (1 + 4.265625),
/// and with a fixed channel.
const SCANNING_TICKS: u64 = 674;
const FIXED_TICKS: u64 = 128;

/// Power-up time of the chip once its clock runs, microseconds: 2^18 periods of the slowest clock
/// that a plan allows (SBAS297G).
const POWER_UP_US: u32 = 20_000;

/// Clock that a board feeds into CLKIO.
pub trait ChipClock {
    /// Starts a clock of `hz`, or stops the clock if that frequency cannot be generated. Returns
    /// true if the clock was off and is now on.
    fn run(&mut self, hz: u32) -> bool;
}

/// A crystal or an oscillator, which runs by itself.
impl ChipClock for () {
    fn run(&mut self, _: u32) -> bool {
        false
    }
}

/// An ADS1258 with its pins START and RESET, and with its clock if the board supplies it.
#[derive(Debug)]
pub struct WiredAds1258<SPI, START, RESET, CLOCK = ()> {
    adc: Ads1258<SPI>,
    start: START,
    reset: RESET,
    clock: CLOCK,
}

impl<SPI, START, RESET> WiredAds1258<SPI, START, RESET> {
    /// Takes the driver and the pins. Nothing is transferred.
    pub const fn new(adc: Ads1258<SPI>, start: START, reset: RESET) -> Self {
        Self {
            adc,
            start,
            reset,
            clock: (),
        }
    }

    /// Adds a clock that each set-up starts or stops, as the plan requires.
    pub fn clocked_by<CLOCK>(self, clock: CLOCK) -> WiredAds1258<SPI, START, RESET, CLOCK> {
        let Self {
            adc, start, reset, ..
        } = self;
        WiredAds1258 {
            adc,
            start,
            reset,
            clock,
        }
    }
}

impl<SPI: SpiDevice, START: OutputPin, RESET: OutputPin, CLOCK: ChipClock> Converter
    for WiredAds1258<SPI, START, RESET, CLOCK>
{
    const NAME: &'static str = "ADS1258";

    fn check(plan: &Plan) -> Result<(), PlanError> {
        Ads1258Plan::check(plan)
    }

    fn stop(&mut self) -> bool {
        self.adc.stop(&mut self.start).is_ok()
    }

    fn set_up(&mut self, plan: &Plan, scanned: Scanned, wait: &mut impl DelayNs) -> bool {
        let config = match scanned {
            Scanned::Inputs => Ads1258Plan::of(plan).config(),
            Scanned::Health => Ads1258Plan::of(plan).health_config(),
        };
        if self.clock.run(plan.adc_clock_hz) {
            wait.delay_us(POWER_UP_US);
        }
        self.adc.reset_by_pin(&mut self.reset, wait).is_ok() && self.adc.configure(&config).is_ok()
    }

    fn start(&mut self) -> bool {
        self.adc.start(&mut self.start).is_ok()
    }

    #[inline(always)]
    fn read(&mut self) -> Option<Sample> {
        self.adc.read().ok().map(Sample::from)
    }

    #[inline(always)]
    fn go_on(&mut self) -> bool {
        false
    }

    fn is_as_set_up(&mut self) -> bool {
        self.adc.verify().is_ok()
    }

    fn registers(&mut self) -> Option<[u8; REGISTERS]> {
        let mut found = [0; Register::ALL.len()];
        let read = self.adc.read_registers(Register::Config0, &mut found);
        read.is_ok().then_some(found)
    }

    fn min_period_us(&mut self) -> u32 {
        let config0 = self.adc.read_register(Register::Config0).ok();
        period_us(config0)
    }
}

/// Minimum duration of a conversion with this CONFIG0, microseconds. `None`, or all ones as from a
/// stuck bus, counts as scanning.
fn period_us(config0: Option<u8>) -> u32 {
    let is_fixed = config0.is_some_and(|config0| config0 != 0xff && config0 & MUXMOD != 0);
    let ticks = if is_fixed {
        FIXED_TICKS
    } else {
        SCANNING_TICKS
    };
    // Round down, so that the number of conversions is not underestimated.
    (ticks * 1_000_000 / CLOCK_MAX_HZ) as u32
}

impl From<Conversion> for Sample {
    #[inline(always)]
    fn from(Conversion { status, code }: Conversion) -> Self {
        let tag = Tag(status.0);
        Self { tag, code }
    }
}

/// The conversion in the ADS1258's format.
impl TimedConversion {
    /// Status byte and 24-bit code as read.
    #[inline(always)]
    pub const fn conversion(&self) -> Conversion {
        Conversion {
            status: self.status(),
            code: self.code(),
        }
    }

    /// Status byte as read.
    #[inline(always)]
    pub const fn status(&self) -> Status {
        Status(self.tag().0)
    }

    /// Returns the conversion with a different status byte.
    pub const fn with_status(self, status: Status) -> Self {
        self.with_tag(Tag(status.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_with_other_registers_is_at_most_as_fast_as_its_rate_table_says() {
        // SBAS297G, rate table at 16 MHz: 23,739 and 125,000 conversions a second.
        assert_eq!(period_us(Some(0x0a)), 1_000_000 / 23_739);
        assert_eq!(period_us(Some(0x2a)), 1_000_000 / 125_000);
        assert_eq!([period_us(None), period_us(Some(0xff))], [42, 42]);
    }

    #[test]
    fn the_status_byte_is_the_tag() {
        for byte in 0..=u8::MAX {
            let (tag, status) = (Tag(byte), Status(byte));
            assert_eq!(tag.is_new(), status.is_new());
            assert_eq!(tag.is_overload(), status.is_overflow());
            assert_eq!(tag.is_supply_low(), status.is_supply_low());
            assert_eq!(tag.id(), status.chid());
        }
    }
}
