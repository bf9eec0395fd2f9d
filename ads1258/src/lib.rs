//! Driver for the TI ADS1258, a 24-bit ADC with a 16-channel multiplexer that scans by itself, on [`embedded_hal`] 1.0.
//!
//! The chip converts one channel after the other without being told to, and says with every result which channel it
//! was. So the work per sample is one 5-byte transfer on the falling edge of DRDY, and this driver is built around that:
//! configure once, check what was written, then [`Ads1258::read`] in the interrupt.
//!
//! # In the order in which a sample comes about
//!
//! | step | where |
//! |---|---|
//! | what shall be measured, and how fast | [`Config`], [`Mux`], [`rate`] |
//! | the bits that say so | [`Register`], [`Config0`], [`Config1`], [`Sysred`] |
//! | put them into the chip, and make sure | [`Ads1258::configure`], [`Ads1258::verify`] |
//! | a result | [`Ads1258::read`], [`Conversion`], [`Status`], [`Channel`] |
//! | volts and degrees | [`reading`] |
//!
//! # Example
//!
//! ```
//! use ads1258::{Ads1258, Channel, Config, Mux, Sysred, reading};
//! # use embedded_hal_mock::eh1::digital::{Mock as PinMock, State, Transaction as PinTransaction};
//! # use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as SpiTransaction};
//! # let image = [0x0A, 0x01, 0x00, 0x00, 0x03, 0x00, 0x04, 0xFF, 0x00];
//! # let mut spi = SpiMock::new(&[
//! #     SpiTransaction::transaction_start(),
//! #     SpiTransaction::write_vec(vec![0xC0]),
//! #     SpiTransaction::transaction_end(),
//! #     SpiTransaction::transaction_start(),
//! #     SpiTransaction::write_vec([&[0x70][..], &image[..]].concat()),
//! #     SpiTransaction::transaction_end(),
//! #     SpiTransaction::transaction_start(),
//! #     SpiTransaction::transfer_in_place([&[0x50][..], &[0; 9]].concat(), [&[0xEE][..], &image].concat()),
//! #     SpiTransaction::transaction_end(),
//! #     SpiTransaction::transaction_start(),
//! #     SpiTransaction::transfer_in_place(vec![0x30, 0, 0, 0, 0], vec![0xEE, 0x88, 0x3C, 0x00, 0x00]),
//! #     SpiTransaction::transaction_end(),
//! # ]);
//! # let mut start = PinMock::new(&[PinTransaction::set(State::Low), PinTransaction::set(State::High)]);
//! let config = Config {
//!     // AIN0, AIN1 and the chip's own supply voltage, one after the other.
//!     mux: Mux::AutoScan { differential: 0, single: 0b11, internal: Sysred { vcc: true, ..Sysred::NONE } },
//!     data_rate: ads1258::DataRate::Drate1,
//!     idle_mode: ads1258::IdleMode::Standby,
//!     ..Config::default()
//! };
//! assert_eq!(config.slots(), 3);
//!
//! let mut adc = Ads1258::new(spi);
//! adc.stop(&mut start).expect("a GPIO pin cannot fail here"); // registers are written with START low
//! adc.reset()?;
//! adc.configure(&config)?; // reads every register back
//! adc.start(&mut start).expect("a GPIO pin cannot fail here");
//!
//! // In the interrupt on the falling edge of DRDY:
//! let conversion = adc.read()?;
//! assert!(conversion.status.is_new());
//! assert_eq!(conversion.status.channel(), Some(Channel::Single(0)));
//! assert_eq!(reading::volts(conversion.code, 4.096), 2.048);
//! # adc.destroy().done();
//! # start.done();
//! # Ok::<(), ads1258::Error<embedded_hal::spi::ErrorKind>>(())
//! ```
//!
//! # What to know before wiring it
//!
//! - SPI [`MODE`] 0, MSB first, SCLK at most half of the chip's clock ([`Config::sclk_max_hz`]), CS low for at least
//!   2.5 tCLK before the first SCLK edge and high for at least 2 tCLK between transfers (160 ns and 125 ns at 16 MHz).
//! - DRDY: interrupt on the **falling** edge. An interrupt on the rising one sees every other channel only.
//! - START low while registers are written; RESET high. Both may be hard-wired, see [`Ads1258::pulse_convert`] and
//!   [`Ads1258::reset`].
//! - Power-up takes [`POWER_UP_TICKS`] of the chip's clock, about 16 ms, before the first command.
//! - Registers have been reported to change by themselves after minutes to hours: call [`Ads1258::verify`] about once a
//!   second; on a mismatch stop, reset, configure and start again.
//!
//! # Features
//!
//! - `defmt`: `defmt::Format` for every public type.
//!
//! # Sources
//!
//! The figures are those of the datasheet SBAS297G of Texas Instruments, which the documentation of each item refers to.
//! What the datasheet leaves open this driver does not rely on.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Nothing in here may panic: it runs in interrupts of machines that nobody watches.
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects
)]

mod bits;
mod channel;
mod config;
mod conversion;
mod driver;
mod error;
mod fields;
pub mod rate;
pub mod reading;
mod register;
mod scan;

pub use bits::{Config0, Config1, Sysred};
pub use channel::Channel;
pub use config::{CLOCK_MAX_HZ, CLOCK_MIN_HZ, CRYSTAL_CLOCK_HZ, Config, Mux};
pub use conversion::{Conversion, Status};
pub use driver::{Ads1258, MODE, POWER_UP_TICKS, RESET_LOW_US};
pub use error::{ConfigError, Error};
pub use fields::{DataRate, Delay, IdleMode, SensorBias};
pub use register::Register;
pub use scan::Scan;

/// The examples of the README, compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
