//! Commands over an async SPI device: the same as the blocking methods, with an `.await` at each
//! transfer.

use embedded_hal_async::digital::Wait;
use embedded_hal_async::spi::SpiDevice;

use crate::codec::{self, Block};
use crate::{Ads1258, Config, Conversion, Error, NextError, Register};

/// # Cancel safety
///
/// A future dropped while it waits for the bus leaves the chip in the state in which the SPI device
/// leaves it. A dropped read changes nothing and may be repeated. A dropped write, reset or
/// configuration may have reached the registers in part, while the driver still expects their
/// previous values: [`verify_async`](Self::verify_async) then fails, and
/// [`configure_async`](Self::configure_async) must be called again.
impl<SPI: SpiDevice> Ads1258<SPI> {
    /// Waits until DRDY is low, and reads the conversion. Returns a missed conversion at once: DRDY
    /// stays low until it is read.
    ///
    /// Cancel safe: if dropped while it waits for the pin, it has read nothing; if dropped during
    /// the transfer, the next call reads the same conversion, with NEW cleared.
    pub async fn read_next_async<P: Wait>(
        &mut self,
        drdy: &mut P,
    ) -> Result<Conversion, NextError<SPI::Error, P::Error>> {
        drdy.wait_for_low().await.map_err(NextError::Drdy)?;
        self.read_async().await.map_err(NextError::Adc)
    }

    /// Async version of [`reset`](Self::reset).
    pub async fn reset_async(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&codec::RESET).await.map_err(Error::Spi)?;
        self.after_reset();
        Ok(())
    }

    /// Async version of [`configure`](Self::configure).
    pub async fn configure_async(&mut self, config: &Config) -> Result<(), Error<SPI::Error>> {
        self.write_registers_async(Register::Config0, &config.registers()?)
            .await?;
        self.verify_async().await
    }

    /// Async version of [`verify`](Self::verify).
    pub async fn verify_async(&mut self) -> Result<(), Error<SPI::Error>> {
        let mut found = [0; Register::WRITABLE];
        self.read_registers_async(Register::Config0, &mut found)
            .await?;
        codec::compare(&self.written, &found)
    }

    /// Async version of [`read_register`](Self::read_register).
    pub async fn read_register_async(
        &mut self,
        register: Register,
    ) -> Result<u8, Error<SPI::Error>> {
        let mut value = [0];
        self.read_registers_async(register, &mut value).await?;
        Ok(value[0])
    }

    /// Async version of [`read_registers`](Self::read_registers).
    pub async fn read_registers_async(
        &mut self,
        first: Register,
        values: &mut [u8],
    ) -> Result<(), Error<SPI::Error>> {
        let mut block = Block::read(first, values.len())?;
        self.spi
            .transfer_in_place(block.bytes())
            .await
            .map_err(Error::Spi)?;
        block.copy_to(values);
        Ok(())
    }

    /// Async version of [`write_register`](Self::write_register).
    pub async fn write_register_async(
        &mut self,
        register: Register,
        value: u8,
    ) -> Result<(), Error<SPI::Error>> {
        self.write_registers_async(register, &[value]).await
    }

    /// Async version of [`write_registers`](Self::write_registers).
    pub async fn write_registers_async(
        &mut self,
        first: Register,
        values: &[u8],
    ) -> Result<(), Error<SPI::Error>> {
        let mut block = Block::write(first, values)?;
        self.spi.write(block.bytes()).await.map_err(Error::Spi)?;
        self.after_write(first, values);
        Ok(())
    }

    /// Async version of [`read_id`](Self::read_id).
    pub async fn read_id_async(&mut self) -> Result<u8, Error<SPI::Error>> {
        codec::check_id(self.read_register_async(Register::Id).await?, self.model)
    }

    /// Async version of [`pulse_convert`](Self::pulse_convert).
    pub async fn pulse_convert_async(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi
            .write(&codec::PULSE_CONVERT)
            .await
            .map_err(Error::Spi)
    }

    /// Async version of [`read`](Self::read).
    pub async fn read_async(&mut self) -> Result<Conversion, Error<SPI::Error>> {
        let mut frame = codec::READ_DATA;
        let bytes = self.model.read_frame(&mut frame);
        self.spi
            .transfer_in_place(bytes)
            .await
            .map_err(Error::Spi)?;
        let [_, bytes @ ..] = frame;
        Ok(Conversion::from_bytes(bytes))
    }
}
