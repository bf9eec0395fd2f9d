//! Errors of a configuration and of the bus.

use core::fmt;

use crate::Register;

/// Why a [`Config`](crate::Config) cannot work; found before anything is written.
///
/// The chip also has no internal readings in fixed mode, but [`Mux`](crate::Mux) cannot express that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// `clock_hz` is outside 0.1 to 16 MHz.
    Clock {
        /// The clock of the configuration in Hz.
        clock_hz: u32,
    },
    /// CHOP together with REF, GAIN, TEMP or VCC.
    ChopWithInternalReadings,
    /// An auto-scan without any channel.
    EmptyScan,
    /// A fixed channel with an input above AIN15.
    ChannelNumber {
        /// The number of the input.
        number: u8,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock { clock_hz } => write!(f, "clock of {clock_hz} Hz is outside 0.1 to 16 MHz"),
            Self::ChopWithInternalReadings => f.write_str("CHOP excludes the readings REF, GAIN, TEMP and VCC"),
            Self::EmptyScan => f.write_str("no channel selected for the scan"),
            Self::ChannelNumber { number } => write!(f, "no input AIN{number}: the last is AIN15"),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Why an operation on the chip failed. `E` is the error of the SPI device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error<E> {
    /// The SPI device failed.
    Spi(E),
    /// A register does not hold what it should. Several may be wrong; this is the one with the lowest address.
    Verify {
        /// The register.
        register: Register,
        /// What the driver wrote to it.
        wrote: u8,
        /// What it holds. For GPIOD only the bits of output pins were compared.
        read: u8,
    },
    /// ID4 is set: an ADS1158 (16 bit), or nothing that drives DOUT low.
    Id {
        /// The ID register as read.
        read: u8,
    },
    /// The configuration cannot work. Nothing was written.
    Config(ConfigError),
    /// The range of registers leaves the map, or includes the read-only ID in a write. Nothing was transferred.
    RegisterRange {
        /// The first register of the range.
        first: Register,
        /// The length of the range.
        count: usize,
    },
}

impl<E> From<ConfigError> for Error<E> {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // embedded-hal promises Debug for bus errors, not Display.
            Self::Spi(error) => write!(f, "SPI: {error:?}"),
            Self::Verify { register, wrote, read } => {
                write!(f, "{register} should hold 0x{wrote:02X}, but holds 0x{read:02X}")
            }
            Self::Id { read } => write!(f, "ID is 0x{read:02X}: not an ADS1258"),
            Self::Config(error) => write!(f, "configuration: {error}"),
            Self::RegisterRange { first, count } => write!(f, "no such range: {count} registers from {first} on"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Config(error) => Some(error),
            _ => None,
        }
    }
}
