//! Errors of a configuration and of the bus.

use crate::Register;

/// Why a [`Config`](crate::Config) cannot work; found before anything is written.
///
/// The chip also has no internal readings in fixed mode, but [`Mux`](crate::Mux) cannot express
/// that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the sentence of each variant names its fields")]
#[non_exhaustive]
pub enum ConfigError {
    /// `clock_hz` is outside 0.1 to 16 MHz.
    #[error("clock of {clock_hz} Hz is outside 0.1 to 16 MHz")]
    Clock { clock_hz: u32 },
    /// CHOP together with REF, GAIN, TEMP or VCC.
    #[error("CHOP excludes the readings REF, GAIN, TEMP and VCC")]
    ChopWithInternalReadings,
    /// An auto-scan without any channel.
    #[error("no channel selected for the scan")]
    EmptyScan,
    /// A fixed channel with the `number` of an input above AIN15.
    #[error("no input AIN{number}: the last is AIN15")]
    ChannelNumber { number: u8 },
}

/// Why an operation on the chip failed. `E` is the error of the SPI device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the sentence of each variant names its fields")]
#[non_exhaustive]
pub enum Error<E> {
    /// The SPI device failed. (embedded-hal requires Debug of its errors, not Display.)
    #[error("SPI: {0:?}")]
    Spi(E),
    /// A `register` reads as `read`, not as the driver `wrote` it. Several may differ; this is the
    /// one with the lowest address. Of GPIOD only the bits of output pins are compared.
    #[error("{register} should hold 0x{wrote:02X}, but holds 0x{read:02X}")]
    Verify {
        register: Register,
        wrote: u8,
        read: u8,
    },
    /// ID4 of the ID register is set: an ADS1158 (16 bit), or nothing that drives DOUT low.
    #[error("ID is 0x{read:02X}: not an ADS1258")]
    Id { read: u8 },
    /// The configuration cannot work. Nothing was written.
    #[error("configuration: {0}")]
    Config(#[from] ConfigError),
    /// `count` registers from `first` on leave the map, or include the read-only ID in a write.
    /// Nothing was transferred.
    #[error("no such range: {count} registers from {first} on")]
    RegisterRange { first: Register, count: usize },
}
