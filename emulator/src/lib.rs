#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod board;
mod bus;
mod cpu;
mod emulator;
mod findings;
mod image;
mod peripherals;
mod processor_fault;
mod scs;
mod session;
mod stop;
mod time;
mod width;

pub use board::{Board, Pin};
pub use emulator::{Emulator, FunctionCounts, OwnAdcFault, Reset, Start, Until};
pub use findings::{Finding, Rule};
pub use image::{Image, ImageError};
pub use peripherals::adc::Reading;
pub use peripherals::dac::Output;
pub use peripherals::rcc::ResetCause;
pub use processor_fault::ProcessorFault;
pub use scs::Served;
pub use session::{Session, Summary};
pub use stop::Failure;
