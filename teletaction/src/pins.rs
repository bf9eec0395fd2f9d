//! `pins`: strains under a sensor's skin as forces of a display whose pins only press.
//!
//! | step | file |
//! |---|---|
//! | raw frames to strains | `skin.rs` |
//! | strain at a sensor under a pin | `grid.rs` |
//! | nearest strains: least squares without negative forces | `matching.rs` |
//! | force, stroke, levels, slew and updates of a real display | `limits.rs` |
//! | a board's packets to updates | `player.rs` |
//! | updates, line by line | `run.rs` |
//!
//! The method is that of Moy et al., *Human Psychophysics for Teletaction System Design*.

mod error;
mod grid;
mod limits;
mod matching;
mod player;
mod run;
mod skin;
#[cfg(test)]
mod tests;

pub use error::Error;
pub use grid::{Grid, Layer, Quantity};
pub use limits::{Limits, Pins};
pub use matching::{Matching, PINS_MAX, Solution};
pub use player::{Player, Setup, Update};
pub use run::run;
pub use skin::volts_per_strain;
