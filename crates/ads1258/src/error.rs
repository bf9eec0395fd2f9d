//! Errors of a configuration and of the bus. The messages are written by hand, because a derive
//! would add macros to the dependencies of a small driver.

use crate::Register;
use core::error;
use core::fmt::{self, Debug, Display, Formatter};

/// Reason why a [`Config`](crate::Config) cannot work; found before anything is written.
///
/// The chip also has no internal readings in fixed mode, but [`Mux`](crate::Mux) cannot express
/// that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the sentence of each variant names its fields")]
#[non_exhaustive]
pub enum ConfigError {
    /// `clock_hz` is outside 0.1 to 16 MHz.
    Clock { clock_hz: u32 },
    /// CHOP together with REF, GAIN, TEMP or VCC.
    ChopWithInternalReadings,
    /// An auto-scan without any channel.
    EmptyScan,
    /// A fixed channel with the `number` of an input above AIN15.
    ChannelNumber { number: u8 },
}

/// Reason why an operation on the chip failed. `E` is the error of the SPI device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the sentence of each variant names its fields")]
#[non_exhaustive]
pub enum Error<E> {
    /// The SPI device failed.
    Spi(E),
    /// A `register` reads as `read`, not as the driver `wrote` it. If several differ, this is the
    /// one with the lowest address. In GPIOD only the bits of output pins are compared.
    Verify {
        register: Register,
        wrote: u8,
        read: u8,
    },
    /// ID4 of the ID register does not match the model: an ADS1158 (16 bit) instead of an ADS1258
    /// or vice versa, or nothing drives DOUT low.
    Id { read: u8 },
    /// The configuration cannot work. Nothing was written.
    Config(ConfigError),
    /// `count` registers from `first` exceed the register map, or include the read-only ID in a
    /// write. Nothing was transferred.
    RegisterRange { first: Register, count: usize },
}

/// Reason why [`read_next_async`](crate::Ads1258::read_next_async) failed. `E` is the error of the
/// SPI device, `P` the error of the DRDY pin.
#[cfg(feature = "async")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NextError<E, P> {
    /// The pin failed.
    Drdy(P),
    /// The read failed.
    Adc(Error<E>),
}

impl Display for ConfigError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock { clock_hz } => {
                write!(f, "clock of {clock_hz} Hz is outside 0.1 to 16 MHz")
            }
            Self::ChopWithInternalReadings => {
                f.write_str("CHOP excludes the readings REF, GAIN, TEMP and VCC")
            }
            Self::EmptyScan => f.write_str("no channel selected for the scan"),
            Self::ChannelNumber { number } => {
                write!(f, "no input AIN{number}: the last is AIN15")
            }
        }
    }
}

impl error::Error for ConfigError {}

impl<E: Debug> Display for Error<E> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            // embedded-hal requires its errors to implement Debug, not Display.
            Self::Spi(error) => write!(f, "SPI: {error:?}"),
            Self::Verify {
                register,
                wrote,
                read,
            } => write!(
                f,
                "{register} should hold 0x{wrote:02X}, but holds 0x{read:02X}"
            ),
            Self::Id { read } if read & 0x10 == 0 => {
                write!(f, "ID is 0x{read:02X}: not an ADS1158")
            }
            Self::Id { read } => write!(f, "ID is 0x{read:02X}: not an ADS1258"),
            Self::Config(error) => write!(f, "configuration: {error}"),
            Self::RegisterRange { first, count } => {
                write!(f, "no such range: {count} registers from {first} on")
            }
        }
    }
}

impl<E: Debug> error::Error for Error<E> {
    fn source(&self) -> Option<&(dyn error::Error + 'static)> {
        match self {
            Self::Config(error) => Some(error),
            _ => None,
        }
    }
}

impl<E> From<ConfigError> for Error<E> {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

#[cfg(feature = "async")]
impl<E: Debug, P: Debug> Display for NextError<E, P> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drdy(error) => write!(f, "DRDY: {error:?}"),
            Self::Adc(error) => Display::fmt(error, f),
        }
    }
}

#[cfg(feature = "async")]
impl<E: Debug, P: Debug> error::Error for NextError<E, P> {}
