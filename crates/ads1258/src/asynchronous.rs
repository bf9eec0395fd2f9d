//! Commands over an async SPI device: the blocking methods word for word, with an `.await` at each
//! transfer.

use embedded_hal_async::spi::SpiDevice;

use crate::codec::{self, Block};
use crate::{Ads1258, Config, Conversion, Error, Register};

impl<SPI: SpiDevice> Ads1258<SPI> {
    /// As [`reset`](Self::reset).
    pub async fn reset_async(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&codec::RESET).await.map_err(Error::Spi)?;
        self.after_reset();
        Ok(())
    }

    /// As [`configure`](Self::configure).
    pub async fn configure_async(&mut self, config: &Config) -> Result<(), Error<SPI::Error>> {
        self.write_registers_async(Register::Config0, &config.registers()?)
            .await?;
        self.verify_async().await
    }

    /// As [`verify`](Self::verify).
    pub async fn verify_async(&mut self) -> Result<(), Error<SPI::Error>> {
        let mut found = [0; Register::WRITABLE];
        self.read_registers_async(Register::Config0, &mut found)
            .await?;
        codec::compare(&self.written, &found)
    }

    /// As [`read_register`](Self::read_register).
    pub async fn read_register_async(
        &mut self,
        register: Register,
    ) -> Result<u8, Error<SPI::Error>> {
        let mut value = [0];
        self.read_registers_async(register, &mut value).await?;
        Ok(value[0])
    }

    /// As [`read_registers`](Self::read_registers).
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

    /// As [`write_register`](Self::write_register).
    pub async fn write_register_async(
        &mut self,
        register: Register,
        value: u8,
    ) -> Result<(), Error<SPI::Error>> {
        self.write_registers_async(register, &[value]).await
    }

    /// As [`write_registers`](Self::write_registers).
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

    /// As [`read_id`](Self::read_id).
    pub async fn read_id_async(&mut self) -> Result<u8, Error<SPI::Error>> {
        codec::check_id(self.read_register_async(Register::Id).await?)
    }

    /// As [`pulse_convert`](Self::pulse_convert).
    pub async fn pulse_convert_async(&mut self) -> Result<(), Error<SPI::Error>> {
        self.spi
            .write(&codec::PULSE_CONVERT)
            .await
            .map_err(Error::Spi)
    }

    /// As [`read`](Self::read).
    pub async fn read_async(&mut self) -> Result<Conversion, Error<SPI::Error>> {
        let mut frame = codec::READ_DATA;
        self.spi
            .transfer_in_place(&mut frame)
            .await
            .map_err(Error::Spi)?;
        let [_, bytes @ ..] = frame;
        Ok(Conversion::from_bytes(bytes))
    }
}
