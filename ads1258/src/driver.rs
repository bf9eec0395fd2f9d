//! The chip on its SPI bus: commands out, registers and conversions in.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{self, SpiDevice};

use crate::{Config, Conversion, Error, Register};

/// SPI mode 0: SCLK idles low, DIN is sampled on its rising edge (SBAS297G, SPI timing). MSB first.
pub const MODE: spi::Mode = spi::MODE_0;

/// Clock periods (tCLK) from power-up to the first command, 2^18: 16.7 ms with the crystal (SBAS297G, power-up).
///
/// The crystal itself needs about 150 ms more after power-down by the PWDN pin.
pub const POWER_UP_TICKS: u32 = 1 << 18;

/// How long [`Ads1258::reset_by_pin`] holds RESET low, in us: more than the 2 tCLK required at the slowest clock, 20 us
/// (SBAS297G, reset timing).
pub const RESET_LOW_US: u32 = 25;

/// Command bytes C\[2:0\] MUL A\[3:0\] (SBAS297G, commands).
mod command {
    /// Data read by command, with the MUL bit.
    pub const READ_DATA: u8 = 0x30;
    /// Register read, to be combined with the address.
    pub const READ_REGISTER: u8 = 0x40;
    /// Register write, to be combined with the address.
    pub const WRITE_REGISTER: u8 = 0x60;
    /// MUL: several registers, with ascending addresses.
    pub const MULTIPLE: u8 = 0x10;
    /// One conversion.
    pub const PULSE_CONVERT: u8 = 0x80;
    /// All registers to their reset values.
    pub const RESET: u8 = 0xC0;
}

/// Command byte and all ten registers.
const LONGEST_TRANSFER: usize = 11;

/// An ADS1258 on an SPI device.
///
/// The SPI device owns the bus and the CS pin, with [`MODE`] and at most half of the chip's clock as SCLK. The pins
/// START and RESET stay with the caller, who lends them where they are needed; a board that has wired them to a fixed
/// level leaves those methods alone.
///
/// Every method on the bus is one or two SPI transactions, and none waits for the chip.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ads1258<SPI> {
    spi: SPI,
}

impl<SPI> Ads1258<SPI> {
    /// Takes the SPI device. Nothing is transferred.
    pub const fn new(spi: SPI) -> Self {
        Self { spi }
    }

    /// Gives the SPI device back.
    pub fn destroy(self) -> SPI {
        self.spi
    }

    /// START high: the chip converts continuously until [`stop`](Self::stop).
    ///
    /// # Errors
    ///
    /// The error of the pin.
    pub fn start<P: OutputPin>(&self, start: &mut P) -> Result<(), P::Error> {
        start.set_high()
    }

    /// START low: the running conversion is finished, then the chip idles.
    ///
    /// DRDY therefore may still fall once after this. Registers are to be written with START low.
    ///
    /// # Errors
    ///
    /// The error of the pin.
    pub fn stop<P: OutputPin>(&self, start: &mut P) -> Result<(), P::Error> {
        start.set_low()
    }

    /// RESET low for [`RESET_LOW_US`], then high: all registers at their reset values, at once and in any state.
    ///
    /// The chip is ready on release, and no conversion is running unless START is high.
    ///
    /// # Errors
    ///
    /// The error of the pin.
    pub fn reset_by_pin<P: OutputPin, D: DelayNs>(&mut self, reset: &mut P, delay: &mut D) -> Result<(), P::Error> {
        reset.set_low()?;
        delay.delay_us(RESET_LOW_US);
        reset.set_high()
    }
}

impl<SPI: SpiDevice> Ads1258<SPI> {
    /// The reset command (0xC0): all registers at their reset values.
    ///
    /// A conversion that is running is finished first; drop its result. [`reset_by_pin`](Self::reset_by_pin) ends it.
    ///
    /// # Errors
    ///
    /// [`Error::Spi`].
    pub fn reset(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&[command::RESET]).map_err(Error::Spi)
    }

    /// Writes the whole configuration, CONFIG0 to GPIOD, and reads it back. START must be low.
    ///
    /// This is also the check that there is a chip at all: no wire that is stuck reads back as what was written, since
    /// CONFIG0 always holds both ones (STAT) and zeros.
    ///
    /// # Errors
    ///
    /// [`Error::Config`] before anything is transferred; [`Error::Verify`] if a register holds something else than
    /// written; [`Error::Spi`].
    pub fn configure(&mut self, config: &Config) -> Result<(), Error<SPI::Error>> {
        let image = config.registers()?;
        self.write_registers(Register::Config0, &image)?;
        self.compare(&image)
    }

    /// Compares all registers with the configuration, without writing.
    ///
    /// To be called about once a second in the field: registers have been reported to change by themselves after minutes
    /// to hours. On a mismatch [`stop`](Self::stop), [`reset`](Self::reset), [`configure`](Self::configure) and
    /// [`start`](Self::start) again: reserved bits, which a write cannot be relied on to change back, need the reset.
    /// Best right after a [`read`](Self::read): then the next conversion is furthest away.
    ///
    /// # Errors
    ///
    /// [`Error::Verify`] with the first register that differs; [`Error::Config`]; [`Error::Spi`].
    pub fn verify(&mut self, config: &Config) -> Result<(), Error<SPI::Error>> {
        let image = config.registers()?;
        self.compare(&image)
    }

    /// Reads one register.
    ///
    /// # Errors
    ///
    /// [`Error::Spi`].
    pub fn read_register(&mut self, register: Register) -> Result<u8, Error<SPI::Error>> {
        let mut frame = [command::READ_REGISTER | register.address(), 0];
        self.spi.transfer_in_place(&mut frame).map_err(Error::Spi)?;
        let [_, value] = frame;
        Ok(value)
    }

    /// Reads as many registers as `values` has places, from `first` on, in one transaction.
    ///
    /// # Errors
    ///
    /// [`Error::RegisterRange`] if `values` is empty or leads beyond ID; [`Error::Spi`]. On an error `values` is unchanged.
    pub fn read_registers(&mut self, first: Register, values: &mut [u8]) -> Result<(), Error<SPI::Error>> {
        let mut buffer = [0; LONGEST_TRANSFER];
        let frame = frame(&mut buffer, first, values.len(), first.to_last())?;
        if let Some(command) = frame.first_mut() {
            *command = command::READ_REGISTER | command::MULTIPLE | first.address();
        }
        self.spi.transfer_in_place(frame).map_err(Error::Spi)?;
        // What came in during the command byte has no meaning.
        for (value, byte) in values.iter_mut().zip(frame.iter().skip(1)) {
            *value = *byte;
        }
        Ok(())
    }

    /// Writes one register, without reading it back. START must be low.
    ///
    /// # Errors
    ///
    /// [`Error::RegisterRange`] for ID, which is read-only; [`Error::Spi`].
    pub fn write_register(&mut self, register: Register, value: u8) -> Result<(), Error<SPI::Error>> {
        if register.to_last_writable() == 0 {
            return Err(Error::RegisterRange { first: register, count: 1 });
        }
        self.spi.write(&[command::WRITE_REGISTER | register.address(), value]).map_err(Error::Spi)
    }

    /// Writes the registers from `first` on in one transaction, without reading them back. START must be low.
    ///
    /// # Errors
    ///
    /// [`Error::RegisterRange`] if `values` is empty or leads beyond GPIOD (ID is read-only); [`Error::Spi`].
    pub fn write_registers(&mut self, first: Register, values: &[u8]) -> Result<(), Error<SPI::Error>> {
        let mut buffer = [0; LONGEST_TRANSFER];
        let frame = frame(&mut buffer, first, values.len(), first.to_last_writable())?;
        let bytes = core::iter::once(command::WRITE_REGISTER | command::MULTIPLE | first.address());
        for (place, byte) in frame.iter_mut().zip(bytes.chain(values.iter().copied())) {
            *place = byte;
        }
        self.spi.write(frame).map_err(Error::Spi)
    }

    /// Reads ID and checks that this is an ADS1258. START must be low: with START high ID has been seen to read wrong.
    ///
    /// Only bit 4 (ID4) is guaranteed, so this tells the ADS1258 from the ADS1158 and from a DOUT that is stuck high,
    /// but not from one that is stuck low. [`configure`](Self::configure) finds that one.
    ///
    /// # Errors
    ///
    /// [`Error::Id`] if ID4 is set; [`Error::Spi`].
    pub fn read_id(&mut self) -> Result<u8, Error<SPI::Error>> {
        let id = self.read_register(Register::Id)?;
        if id & 0x10 == 0 { Ok(id) } else { Err(Error::Id { read: id }) }
    }

    /// The pulse convert command (0x80): one conversion, as a pulse on START does, for boards that have it wired low.
    ///
    /// Each one converts the next channel of the scan.
    ///
    /// # Errors
    ///
    /// [`Error::Spi`].
    pub fn pulse_convert(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&[command::PULSE_CONVERT]).map_err(Error::Spi)
    }

    /// The latest conversion, read by command in one transaction of 5 bytes: the thing to do when DRDY falls.
    ///
    /// Safe at any time: when the next conversion ends in the middle of it, the data is not torn, and when there is
    /// nothing new it gives the last conversion again, with NEW cleared. At 8 MHz SCLK it takes 5 us.
    ///
    /// (The direct read, one byte shorter, has neither property, which is why this driver does without it.)
    ///
    /// # Errors
    ///
    /// [`Error::Spi`].
    #[inline]
    pub fn read(&mut self) -> Result<Conversion, Error<SPI::Error>> {
        let mut frame = [command::READ_DATA, 0, 0, 0, 0];
        self.spi.transfer_in_place(&mut frame).map_err(Error::Spi)?;
        let [_, status, high, middle, low] = frame;
        Ok(Conversion::from_bytes([status, high, middle, low]))
    }

    /// Reads CONFIG0 to GPIOD and compares them with `image`.
    fn compare(&mut self, image: &[u8; Register::WRITABLE]) -> Result<(), Error<SPI::Error>> {
        let mut found = [0; Register::WRITABLE];
        self.read_registers(Register::Config0, &mut found)?;
        let [.., gpio_inputs, _] = *image;
        for ((register, &wrote), read) in Register::ALL.into_iter().zip(image).zip(found) {
            // An input pin reads as what is connected to it.
            let compared = if register == Register::Gpiod { !gpio_inputs } else { 0xFF };
            if (wrote ^ read) & compared != 0 {
                return Err(Error::Verify { register, wrote, read });
            }
        }
        Ok(())
    }
}

/// The part of `buffer` for a command byte and `count` registers, of which at most `room` exist.
fn frame<E>(
    buffer: &mut [u8; LONGEST_TRANSFER],
    first: Register,
    count: usize,
    room: usize,
) -> Result<&mut [u8], Error<E>> {
    if count == 0 || count > room {
        return Err(Error::RegisterRange { first, count });
    }
    buffer.get_mut(..=count).ok_or(Error::RegisterRange { first, count })
}
