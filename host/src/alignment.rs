//! Relates positions to frames: the skew of the channels, the delay of the low-pass, and the
//! standard deviation of an unknown common delay.

use ridgetone_proto::settings::TAXELS;

/// Relation between positions from a separate file and a recording's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Name of the file with the positions.
    pub file: String,
    /// Delay of each taxel's reading after the frame's position, frames.
    pub skew_frames: [f32; TAXELS],
    /// Time constant of the low-pass in seconds; positions are taken this much earlier.
    pub low_pass_s: f64,
    /// Standard deviation of the unknown common delay of all positions, seconds.
    pub sigma_s: f64,
}

impl Alignment {
    /// Returns the relative standard deviation of a spatial frequency due to the uncertain delay.
    /// The delay shifts each position by speed times delay; the slope of this shift over position
    /// is the frequency's relative error. At a constant speed it is zero.
    pub fn sigma_fraction(&self, positions_mm: &[f32], rate_hz: f64) -> f64 {
        let speeds = positions_mm
            .windows(3)
            .map(|at| 0.5 * f64::from(at[2] - at[0]) * rate_hz);
        let inner = positions_mm.get(1..).unwrap_or_default();
        let pairs: Vec<(f64, f64)> = inner.iter().map(|mm| f64::from(*mm)).zip(speeds).collect();
        let mean_mm = pairs.iter().map(|(mm, _)| mm).sum::<f64>() / pairs.len().max(1) as f64;
        let (mut along, mut squares) = (0.0, 0.0);
        for (mm, mm_s) in pairs {
            along += (mm - mean_mm) * mm_s;
            squares += (mm - mean_mm).powi(2);
        }
        if squares > 0.0 {
            (self.sigma_s * along / squares).abs()
        } else {
            0.0
        }
    }
}
