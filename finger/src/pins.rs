//! Forces for a display of pins: what this finger feels, pressed into another one.

mod driver;
mod sampler;
pub mod strains;

pub use driver::{Driver, MEMORY};
pub use sampler::{Due, Sampler};
