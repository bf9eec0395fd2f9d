//! `pins`: turns strains under a sensor's skin into forces of a display whose pins can only press.
//!
//! | step | file |
//! |---|---|
//! | raw frames to strains | `skin.rs` |
//! | strain at a sensor under a pin | `grid.rs` |
//! | nearest strains: least squares without negative forces | `matching.rs` |
//! | force, stroke, levels, slew and updates of a real display | `limits.rs` |
//! | a board's packets to updates | `player.rs` |
//!
//! The method is that of Moy et al., *Human Psychophysics for Teletaction System Design*.

mod grid;
mod limits;
mod matching;
mod player;
mod skin;
#[cfg(test)]
mod tests;

pub use grid::{Grid, Layer, Quantity};
pub use limits::{Limits, Pins};
pub use matching::{Matching, PINS_MAX, Solution};
pub use player::{Player, SILENCE_S, Setup, Update};
pub use skin::volts_per_strain;

/// Impossible display settings, or data that cannot be matched. The display keeps its last forces.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Setting(#[from] crate::stimulus::Error),
    /// The slew limit forbids the smallest step of the display.
    #[error(
        "one level is {level_n} N and one update may change {step_n} N: allow a faster slew, or take more levels"
    )]
    Frozen { level_n: f32, step_n: f32 },
    #[error("{what} {index} is not a finite number: exclude that frame")]
    NotFinite { what: &'static str, index: usize },
}
