//! Commands over a blocking SPI device.

use embedded_hal::spi::SpiDevice;

use crate::codec::{self, Block};
use crate::{Ads1258, Config, Conversion, Error, Register};

/// Every command fails with [`Error::Spi`] if the SPI device does. Other errors are listed with the
/// command.
impl<SPI: SpiDevice> Ads1258<SPI> {
    /// Sends the reset command (0xC0): all registers return to their reset values.
    ///
    /// The chip finishes a running conversion first; discard its result.
    /// [`reset_by_pin`](Self::reset_by_pin) aborts the conversion instead.
    pub fn reset(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&codec::RESET).map_err(Error::Spi)?;
        self.after_reset();
        Ok(())
    }

    /// Writes the whole configuration, CONFIG0 to GPIOD, and reads it back. START must be low.
    ///
    /// This also checks that there is a chip: CONFIG0 always holds ones (STAT) and zeros, and a
    /// stuck wire reads as all ones or all zeros.
    ///
    /// # Errors
    /// [`Error::Config`] before anything is transferred; [`Error::Verify`] if a register does not
    /// hold what was written.
    pub fn configure(&mut self, config: &Config) -> Result<(), Error<SPI::Error>> {
        self.write_registers(Register::Config0, &config.registers()?)?;
        self.verify()
    }

    /// Compares all registers with what the driver has written to them, without writing.
    ///
    /// Call this about once a second: registers have been reported to change by themselves after
    /// minutes to hours. The best time is right after a [`read`](Self::read), when the next
    /// conversion is furthest away. On a mismatch [`stop`](Self::stop), [`reset`](Self::reset) (for
    /// the reserved bits), [`configure`](Self::configure) and [`start`](Self::start) again.
    ///
    /// # Errors
    /// [`Error::Verify`] with the first register that differs.
    pub fn verify(&mut self) -> Result<(), Error<SPI::Error>> {
        let mut found = [0; Register::WRITABLE];
        self.read_registers(Register::Config0, &mut found)?;
        codec::compare(&self.written, &found)
    }

    /// Reads one register.
    pub fn read_register(&mut self, register: Register) -> Result<u8, Error<SPI::Error>> {
        let mut value = [0];
        self.read_registers(register, &mut value)?;
        Ok(value[0])
    }

    /// Reads as many registers as `values` has elements, starting at `first`, in one transaction.
    ///
    /// # Errors
    /// [`Error::RegisterRange`] if `values` is empty or extends beyond ID. On an error `values` is
    /// unchanged.
    pub fn read_registers(
        &mut self,
        first: Register,
        values: &mut [u8],
    ) -> Result<(), Error<SPI::Error>> {
        let mut block = Block::read(first, values.len())?;
        self.spi
            .transfer_in_place(block.bytes())
            .map_err(Error::Spi)?;
        block.copy_to(values);
        Ok(())
    }

    /// Writes one register, without reading it back. START must be low.
    ///
    /// # Errors
    /// [`Error::RegisterRange`] for ID, which is read-only.
    pub fn write_register(
        &mut self,
        register: Register,
        value: u8,
    ) -> Result<(), Error<SPI::Error>> {
        self.write_registers(register, &[value])
    }

    /// Writes registers starting at `first` in one transaction, without reading them back. START
    /// must be low.
    ///
    /// # Errors
    /// [`Error::RegisterRange`] if `values` is empty or extends beyond GPIOD (ID is read-only).
    pub fn write_registers(
        &mut self,
        first: Register,
        values: &[u8],
    ) -> Result<(), Error<SPI::Error>> {
        let mut block = Block::write(first, values)?;
        self.spi.write(block.bytes()).map_err(Error::Spi)?;
        self.after_write(first, values);
        Ok(())
    }

    /// Reads ID and checks it against the driver's [`Model`](crate::Model). START must be low: with
    /// START high, ID has been seen to read wrong.
    ///
    /// Only bit 4 (ID4) is guaranteed, so this distinguishes the ADS1258 from the ADS1158 and from
    /// a DOUT that is stuck high, but not from a DOUT that is stuck low, which
    /// [`configure`](Self::configure) detects.
    ///
    /// # Errors
    /// [`Error::Id`] if ID4 is that of the other model.
    pub fn read_id(&mut self) -> Result<u8, Error<SPI::Error>> {
        codec::check_id(self.read_register(Register::Id)?, self.model)
    }

    /// Sends the pulse convert command (0x80): converts the next channel of the scan once, for
    /// boards with START wired low.
    pub fn pulse_convert(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&codec::PULSE_CONVERT).map_err(Error::Spi)
    }

    /// Reads the latest conversion by command in one transaction of 5 bytes. Call this when DRDY
    /// falls.
    ///
    /// Safe at any time, unlike the direct read, which is one byte shorter: if the next conversion
    /// ends during the read, the data is not torn, and if there is nothing new, it returns the last
    /// conversion again, with NEW cleared.
    #[inline]
    pub fn read(&mut self) -> Result<Conversion, Error<SPI::Error>> {
        let mut frame = codec::READ_DATA;
        let bytes = self.model.read_frame(&mut frame);
        self.spi.transfer_in_place(bytes).map_err(Error::Spi)?;
        let [_, bytes @ ..] = frame;
        Ok(Conversion::from_bytes(bytes))
    }
}
