//! The driver: its SPI device, its pins, and its copy of the chip's registers.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi;

use crate::Register;
use crate::register::Image;

/// SPI mode 0: SCLK idles low, DIN is sampled on its rising edge (SBAS297G, SPI timing). MSB first.
pub const MODE: spi::Mode = spi::MODE_0;

/// Clock periods (tCLK) from power-up to the first command, 2^18: 16.7 ms with the crystal
/// (SBAS297G, power-up).
///
/// The crystal itself needs about 150 ms more after power-down by the PWDN pin.
pub const POWER_UP_TICKS: u32 = 1 << 18;

/// Time for which [`Ads1258::reset_by_pin`] holds RESET low, in us: over 2 tCLK of the slowest
/// clock, 20 us (SBAS297G, reset).
pub const RESET_LOW_US: u32 = 25;

const RESET_IMAGE: Image = {
    let [written @ .., _id] = Register::RESET_VALUES;
    written
};

/// Model of the chip: the models differ in the length of codes and a bit of ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Model {
    /// 24 bits.
    Ads1258,
    /// 16 bits. Codes are returned as the upper 16 of 24 bits, so that [`reading`](crate::reading)
    /// applies to them.
    Ads1158,
}

impl Model {
    /// Returns the bytes to transfer for a read: command, status and code. Any other bytes stay
    /// zero.
    #[inline]
    pub(crate) fn read_frame(self, frame: &mut [u8; 5]) -> &mut [u8] {
        match self {
            Self::Ads1258 => frame,
            Self::Ads1158 => {
                let [max @ .., _] = frame;
                max
            }
        }
    }
}

/// Driver of an ADS1258 or ADS1158 on an SPI device.
///
/// The SPI device owns the bus and the CS pin, with [`MODE`] and an SCLK of at most half of the
/// chip's clock. With the feature `async` each method has a version with the suffix `_async`, for
/// an `embedded_hal_async::spi::SpiDevice`.
///
/// The pins START and RESET stay with the caller, who lends them to the methods. A board with these
/// pins hard-wired does not need these methods.
///
/// Every method on the bus is one or two SPI transactions, and none waits for the chip. The driver
/// remembers the value written to each register, for comparison by [`verify`](Self::verify).
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ads1258<SPI> {
    pub(crate) spi: SPI,
    /// Expected content of the writable registers.
    pub(crate) written: Image,
    pub(crate) model: Model,
}

/// Methods that use a pin fail only if the pin fails.
impl<SPI> Ads1258<SPI> {
    /// Creates a driver. Nothing is transferred: the driver assumes the reset values.
    pub const fn new(spi: SPI) -> Self {
        Self::of_model(spi, Model::Ads1258)
    }

    /// Creates a driver like [`new`](Self::new), for either chip.
    pub const fn of_model(spi: SPI, model: Model) -> Self {
        Self {
            spi,
            written: RESET_IMAGE,
            model,
        }
    }

    /// Returns the SPI device.
    pub fn destroy(self) -> SPI {
        self.spi
    }

    /// Sets START high: the chip converts continuously until [`stop`](Self::stop).
    pub fn start<P: OutputPin>(&self, start: &mut P) -> Result<(), P::Error> {
        start.set_high()
    }

    /// Sets START low: the chip finishes the running conversion, then idles.
    ///
    /// DRDY may therefore still fall once after this. Write registers only with START low.
    pub fn stop<P: OutputPin>(&self, start: &mut P) -> Result<(), P::Error> {
        start.set_low()
    }

    /// Sets RESET low for [`RESET_LOW_US`], then high: all registers return to their reset values,
    /// at once and in any state.
    ///
    /// The chip is ready on release, and no conversion is running unless START is high.
    pub fn reset_by_pin<P: OutputPin, D: DelayNs>(
        &mut self,
        reset: &mut P,
        delay: &mut D,
    ) -> Result<(), P::Error> {
        reset.set_low()?;
        delay.delay_us(RESET_LOW_US);
        self.after_reset();
        reset.set_high()
    }

    pub(crate) const fn after_reset(&mut self) {
        self.written = RESET_IMAGE;
    }

    pub(crate) fn after_write(&mut self, first: Register, values: &[u8]) {
        for (place, value) in self.written.iter_mut().skip(first as usize).zip(values) {
            *place = *value;
        }
    }
}
