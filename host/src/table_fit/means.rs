//! Decimates rows: applies a low-pass filter, and keeps every n-th value.

use super::scaled::{Channels, Scaled};
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::{FRAC_PI_2, PI};

/// Zeros of the filter's sinc on either side. The passband ends at 0.44 of the lower rate, the
/// stopband begins at 0.56.
const ZEROS: usize = 8;

/// End of the filter's passband, as a fraction of the lower rate.
pub const PASSED: f64 = 0.44;

/// Minimum fraction of the filter's weight that falls on readings.
const WEIGHT_MIN: f64 = 0.5;

impl Channels<'_> {
    /// Returns one frame for every `slots` rows, about the same centre. `change` is applied to each
    /// row first.
    pub fn thinned(
        &self,
        slots: usize,
        change: &dyn Fn(usize, &[f32; TAXELS]) -> [f32; TAXELS],
    ) -> Scaled {
        let (all, channels) = (self.slots(), self.units.len());
        let count = all / slots;
        // Twice the position of the first frame, so that it is a whole number.
        let first_twice = (all - 1) - (count - 1) * slots;
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
        let mut sums = vec![[Sum::default(); TAXELS]; count];
        self.each(0..all, &mut |slot, values, valid| {
            let values = change(slot, values);
            // Distance in taps from the centre of frame 0.
            let last = slot + half;
            let to = last.checked_sub(first_twice / 2).map(|taps| taps / slots);
            let from = (last.saturating_sub(2 * half + 1 + first_twice / 2)).div_ceil(slots);
            for frame in from..to.map_or(0, |to| (to + 1).min(count)) {
                let weight = weights[last - (first_twice / 2 + frame * slots)];
                for c in (0..channels).filter(|c| valid & 1 << c != 0) {
                    sums[frame][c].value += weight * f64::from(values[c]);
                    sums[frame][c].weight += weight;
                }
            }
        });
        let mut thinned = Scaled::empty(count, channels);
        for (frame, sums) in sums.iter().enumerate() {
            for c in (0..channels).filter(|c| sums[*c].weight > WEIGHT_MIN * whole) {
                thinned.values[frame][c] = (sums[c].value / sums[c].weight) as f32;
                thinned.valid[frame] |= 1 << c;
            }
        }
        thinned
    }
}

/// Weighted sum of readings, and the sum of the weights.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: f64,
    weight: f64,
}

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
