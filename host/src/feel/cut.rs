//! The windows that a recording is cut into.

use super::loaded::Loaded;
use super::spectrum::Spectrum;
use anyhow::{Result, ensure};
use ridgetone_feel::Windows;

/// Fewest rows of a window.
const ROWS_MIN: usize = 64;

/// The windows of a recording, and their transform.
pub struct Cut {
    /// Rows of a window.
    pub rows: usize,
    /// The length of a window, and the one that its intensities are wanted for.
    pub windows: Windows,
    /// The transform of a window.
    pub spectrum: Spectrum,
    /// First row of each window.
    pub starts: Vec<usize>,
}

impl Cut {
    /// Cuts a recording into windows of at most `longest_s`.
    pub fn new(recording: &Loaded, longest_s: f64, wanted_s: f64) -> Result<Self> {
        let wished = (longest_s * recording.rate_hz).round() as usize;
        let rows = wished.min(recording.slots());
        ensure!(
            rows >= ROWS_MIN,
            "{}: {rows} rows in a window, at least {ROWS_MIN} are needed",
            recording.file
        );
        Ok(Self {
            rows,
            windows: Windows {
                measured_s: (rows as f64 / recording.rate_hz) as f32,
                wanted_s: wanted_s as f32,
            },
            spectrum: Spectrum::new(rows),
            starts: starts(recording.slots(), rows),
        })
    }
}

/// Starts of windows that overlap by half or less, so that each counts as one of its own; two or
/// more use all rows.
fn starts(rows: usize, window: usize) -> Vec<usize> {
    let steps = (rows - window) / (window / 2);
    (0..=steps)
        .map(|step| (step * (rows - window)).checked_div(steps).unwrap_or(0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_overlap_by_half_or_less() {
        assert_eq!(starts(64, 64), [0]);
        assert_eq!(starts(95, 64), [0]);
        assert_eq!(starts(160, 64), [0, 32, 64, 96]);
        assert_eq!(starts(150, 64), [0, 43, 86]);
    }
}
