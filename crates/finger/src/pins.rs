//! Forces for a display of pins: what this finger feels, pressed into another one.

mod driver;
mod sampler;
pub mod strains;

pub use driver::{Driver, MEMORY, MULTIPLY_ADDS_MAX, PIVOTS_MAX};
pub use sampler::{Due, Sampler};
