//! The system control space: interrupt controller, exceptions, processor control (DDI 0403E, B3.2
//! to B3.4).

mod registers;
mod state;

pub use state::Served;
pub(crate) use state::{FIRST_IRQ, HARD_FAULT, Masks, Scs};
