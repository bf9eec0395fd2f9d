#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Nothing here may panic: the driver runs in interrupts of unattended machines.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

#[cfg(feature = "async")]
mod asynchronous;
mod blocking;
mod channel;
mod codec;
mod config;
mod conversion;
mod driver;
mod error;
mod fields;
mod rate;
pub mod reading;
mod register;
mod settled_cs;

pub use channel::Channel;
pub use config::{CLOCK_MAX_HZ, CLOCK_MIN_HZ, CRYSTAL_CLOCK_HZ, Config, Mux};
pub use conversion::{Conversion, Status};
pub use driver::{Ads1258, MODE, Model, POWER_UP_TICKS, RESET_LOW_US};
#[cfg(feature = "async")]
pub use error::NextError;
pub use error::{ConfigError, Error};
pub use fields::{DataRate, Delay, IdleMode, SensorBias, Sysred};
pub use register::Register;
pub use settled_cs::SettledCs;
