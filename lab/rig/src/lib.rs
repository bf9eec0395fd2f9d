#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod board;
mod bus;
mod cpu;
mod findings;
mod image;
mod peripherals;
mod processor_fault;
mod rig;
mod scs;
mod stop;
mod time;
mod width;

pub use board::Board;
pub use findings::{Finding, Rule};
pub use image::{Image, ImageError};
pub use peripherals::adc::Reading;
pub use peripherals::dac::Output;
pub use peripherals::rcc::ResetCause;
pub use processor_fault::ProcessorFault;
pub use rig::{OwnAdcFault, Reset, Rig, Start};
pub use scs::Served;
pub use stop::Failure;
