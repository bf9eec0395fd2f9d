//! The board under test: the processor, everything connected to it, and the far ends of its cables.

mod counts;
mod ends;
mod event;
mod functions;
mod run;
mod start;

pub use ends::OwnAdcFault;
pub use event::Until;
pub use functions::FunctionCounts;
pub use run::{Emulator, Reset};
pub use start::Start;
