//! Why a receptor or a score has no value, in words: for a recording and for a board's event.

use crate::digits::significant;
use ridgetone_feel::{Absent, Firing, Indices, Receptor, Score};
use std::ops::RangeInclusive;

/// The scale on which people scored the paper's plates (seven steps, section 2.2).
const SCALE: RangeInclusive<f32> = 1.0..=7.0;

/// What is said of a score that is outside of it.
pub(super) const OUTSIDE_SCALE: &str = "outside the paper's scale of 1 to 7";

/// Whether a score of the paper's coefficients is outside of its scale.
pub(super) fn is_outside_scale(score: Option<f32>) -> bool {
    score.is_some_and(|score| !SCALE.contains(&score))
}

/// Why a receptor has no intensity in a window of `window_s` seconds and `bins` bins.
pub(super) fn absent(
    receptor: Receptor,
    rate_hz: f64,
    window_s: f64,
    bins: usize,
) -> Option<String> {
    let why = Firing::absent(receptor, bins, (1.0 / window_s) as f32)?;
    Some(match why {
        Absent::RateTooLow(_) => {
            format!(
                "{} {}, here are {}",
                receptor.name(),
                in_short(why),
                significant(rate_hz, 5)
            )
        }
        Absent::WindowTooShort => {
            let seconds = significant(window_s, 2);
            format!(
                "{} listens below {} Hz: no cycle of that is in a window of {seconds} s",
                receptor.name(),
                receptor.corners_hz()[2]
            )
        }
    })
}

/// Why a score is absent, in a few words beside the receptor's name.
pub(super) fn in_short(why: Absent) -> String {
    match why {
        Absent::RateTooLow(hz) => format!("needs more than {hz} rows a second"),
        Absent::WindowTooShort => "needs a longer window".to_owned(),
    }
}

/// The first index that a score lacks.
pub(super) fn needs(score: &Score, indices: &Indices) -> Option<String> {
    score
        .missing(indices)
        .map(|index| match Receptor::ALL.get(index) {
            Some(receptor) => format!("needs the intensity of {}", receptor.name()),
            None => "needs M".to_owned(),
        })
}
