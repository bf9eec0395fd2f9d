//! What each choice costs and brings: accuracy on this PC, with the code of the chip, beside instructions counted on
//! the emulated chip.

mod accuracy;
mod bars;
mod contender;
pub mod grid;
mod parallel;

pub use accuracy::{Accuracy, Answer, Error, Sample};
pub use bars::{Bars, Cell, Found, Windows};
pub use contender::Contender;
pub use grid::Row;

use serde::{Deserialize, Serialize};

/// A bar, and whether it is met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// Of what.
    pub bar: String,
    /// What is allowed.
    pub limit: String,
    /// What it is.
    pub measured: String,
    /// Whether it is met.
    pub met: bool,
}
