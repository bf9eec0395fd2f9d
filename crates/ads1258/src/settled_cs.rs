//! CS with the delays that the chip requires.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, OutputPin};

/// The CS pin for an SPI device such as `embedded_hal_bus`'s `ExclusiveDevice`, which adds no
/// delays: CS is low for 2.5 tCLK before SCLK, and high for as long between transfers (SBAS297G,
/// SPI timing: at least 2). It also rises half a period of SCLK late: on some processors, such as
/// the STM32F4, SPI reports the end of a transfer before the last bit ends, and the chip stores a
/// register only at that end.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettledCs<P, D> {
    pin: P,
    delay: D,
    settle_ns: u32,
    half_bit_ns: u32,
}

impl<P, D> SettledCs<P, D> {
    /// Wraps a pin that is high, for a chip with a clock of `clock_hz` and a bus with `sclk_hz`.
    pub const fn new(pin: P, delay: D, clock_hz: u32, sclk_hz: u32) -> Self {
        Self {
            pin,
            delay,
            settle_ns: rounded_up_ns(2_500_000_000, clock_hz),
            half_bit_ns: rounded_up_ns(500_000_000, sclk_hz),
        }
    }

    /// Returns pin and delay.
    pub fn destroy(self) -> (P, D) {
        (self.pin, self.delay)
    }
}

/// Duration of `billionths` of a period at `hz`, nanoseconds, rounded up; the maximum if `hz` is 0.
const fn rounded_up_ns(billionths: u32, hz: u32) -> u32 {
    if hz == 0 {
        u32::MAX
    } else {
        billionths.div_ceil(hz)
    }
}

impl<P: ErrorType, D> ErrorType for SettledCs<P, D> {
    type Error = P::Error;
}

impl<P: OutputPin, D: DelayNs> OutputPin for SettledCs<P, D> {
    fn set_low(&mut self) -> Result<(), P::Error> {
        self.pin.set_low()?;
        self.delay.delay_ns(self.settle_ns);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), P::Error> {
        self.delay.delay_ns(self.half_bit_ns);
        self.pin.set_high()?;
        self.delay.delay_ns(self.settle_ns);
        Ok(())
    }
}
