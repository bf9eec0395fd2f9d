//! The processor: a Cortex-M4F, instruction by instruction.
//!
//! Only the main stack and privileged code are modelled, because the firmware uses nothing else.

mod decode16;
mod decode32;
mod decode_branch;
mod decode_float;
mod exception;
mod execute;
mod float;
mod integer;
mod op;
mod operands;
mod special;
mod state;
mod step;
mod transfer;

pub(crate) use state::{Cpu, FLASH};
