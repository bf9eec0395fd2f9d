//! Fewer frames than rows: a low-pass filter and every n-th value of it.

use super::scaled::Scaled;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::{FRAC_PI_2, PI};

/// Zeros of the filter's sinc on either side: it passes up to 0.44 of the lower rate, and stops
/// from 0.56 on.
const ZEROS: usize = 8;

/// The fraction of the lower rate that it passes.
pub const PASSED: f64 = 0.44;

/// Fraction of the filter's weights that have to be on readings.
const WEIGHT_MIN: f64 = 0.5;

impl Scaled {
    /// One frame for each `slots`, about the same centre.
    pub fn thinned(&self, slots: usize) -> Self {
        let count = self.values.len() / slots;
        // Twice the position of the first frame, which is a whole number.
        let first_twice = (self.values.len() - 1) - (count - 1) * slots;
        let half = ZEROS * slots;
        let weights: Vec<f64> = (0..=2 * half + 1)
            .map(|tap| {
                weight(
                    tap as f64 - half as f64 - 0.5 * (first_twice % 2) as f64,
                    slots,
                )
            })
            .collect();
        let whole: f64 = weights.iter().sum();
        let mut thinned = Self {
            values: vec![[0.0; TAXELS]; count],
            valid: vec![0; count],
            ..self.clone_head()
        };
        for frame in 0..count {
            let centre = first_twice / 2 + frame * slots;
            let (mut sums, mut known) = ([0.0; TAXELS], [0.0; TAXELS]);
            for (tap, weight) in weights.iter().enumerate() {
                let Some(slot) = (centre + tap).checked_sub(half) else {
                    continue;
                };
                let Some(valid) = self.valid.get(slot) else {
                    break;
                };
                for c in (0..self.units.len()).filter(|c| valid & 1 << c != 0) {
                    sums[c] += weight * f64::from(self.values[slot][c]);
                    known[c] += weight;
                }
            }
            for c in (0..self.units.len()).filter(|c| known[*c] > WEIGHT_MIN * whole) {
                thinned.values[frame][c] = (sums[c] / known[c]) as f32;
                thinned.valid[frame] |= 1 << c;
            }
        }
        thinned
    }
}

/// The filter's weight at a distance in slots.
fn weight(off: f64, slots: usize) -> f64 {
    let off = off / slots as f64;
    if off == 0.0 {
        return 1.0;
    }
    let window = (FRAC_PI_2 * (off / ZEROS as f64).clamp(-1.0, 1.0))
        .cos()
        .powi(2);
    window * (PI * off).sin() / (PI * off)
}
