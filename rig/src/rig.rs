//! The board under test: the processor with all that hangs on it, and the ends of its cables.

mod ends;
mod run;
mod start;

pub use run::{Reset, Rig};
pub use start::Start;
