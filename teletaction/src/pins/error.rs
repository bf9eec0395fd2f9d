//! Impossible settings of a display, and data that cannot be matched.

use crate::stimulus;

/// The reason why nothing was computed. The display keeps its last forces.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Setting(#[from] stimulus::Error),
    /// The slew limit forbids the smallest step that the display can make.
    #[error(
        "one level is {level_n} N and one update may change {step_n} N: allow a faster slew, or take more levels"
    )]
    Frozen { level_n: f32, step_n: f32 },
    #[error("{what} {index} is not a finite number: exclude that frame")]
    NotFinite { what: &'static str, index: usize },
}
