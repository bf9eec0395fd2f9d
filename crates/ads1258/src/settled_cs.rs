//! CS with the times that the chip wants around it.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, OutputPin};

/// The CS pin for an SPI device such as `embedded_hal_bus`'s `ExclusiveDevice`, which has no delays
/// around it: CS is low for 2.5 tCLK before SCLK, and high for as long between transfers
/// (SBAS297G, SPI timing: at least 2). It also rises half a period of SCLK late, for the SPI of some
/// processors, the STM32F4 among them, is done before the last bit ends, at whose end the chip takes
/// a register.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettledCs<P, D> {
    pin: P,
    delay: D,
    settle_ns: u32,
    half_bit_ns: u32,
}

impl<P, D> SettledCs<P, D> {
    /// A pin that is high, for a chip with a clock of `clock_hz` and a bus with `sclk_hz`.
    pub const fn new(pin: P, delay: D, clock_hz: u32, sclk_hz: u32) -> Self {
        Self {
            pin,
            delay,
            settle_ns: rounded_up_ns(2_500_000_000, clock_hz),
            half_bit_ns: rounded_up_ns(500_000_000, sclk_hz),
        }
    }

    /// Gives pin and delay back.
    pub fn destroy(self) -> (P, D) {
        (self.pin, self.delay)
    }
}

/// The time of so many billionths of periods at `hz`, nanoseconds; of no frequency the longest.
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
