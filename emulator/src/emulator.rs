//! The board under test: the processor with everything connected to it, and the ends of its cables.

mod ends;
mod run;
mod start;
#[cfg(test)]
pub(crate) mod tests;

pub use ends::OwnAdcFault;
pub use run::{Emulator, Reset};
pub use start::Start;
