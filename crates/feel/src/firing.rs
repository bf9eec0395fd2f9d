//! The intensity with which each kind of receptor fires in a window.

use crate::receptor::{RECEPTORS, Receptor};
use crate::reference::Conversion;

/// Why a receptor has no intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The spectrum ends below the receptor's range; at this rate it would not, hertz.
    RateTooLow(f32),
    /// No bin of the spectrum is in the receptor's range.
    WindowTooShort,
}

/// How the receptors fire in a window, in the order of [`Receptor::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Firing {
    /// Sum over the bins of the receptor's range of the decades by which the spectrum is above the
    /// threshold (equations 8 and 9); none where [`absent`](Self::absent).
    pub intensity: [Option<f32>; RECEPTORS],
    /// Bins above both of two thresholds; in the diagonal, above one.
    pub above: [[f32; RECEPTORS]; RECEPTORS],
}

impl Firing {
    /// From an amplitude spectrum and the distance of its bins, hertz.
    pub fn new(amplitudes: &[f32], bin_hz: f32, conversion: &Conversion) -> Self {
        let mut firing = Self::default();
        let last_hz = Receptor::ALL.iter().fold(0.0, |last: f32, receptor| {
            last.max(receptor.corners_hz()[2])
        });
        for (receptor, intensity) in Receptor::ALL.into_iter().zip(&mut firing.intensity) {
            *intensity = Self::absent(receptor, amplitudes.len(), bin_hz)
                .is_none()
                .then_some(0.0);
        }
        for (k, amplitude) in amplitudes.iter().enumerate().skip(1) {
            let hz = k as f32 * bin_hz;
            if hz > last_hz {
                break;
            }
            let (log_hz, log_um) = (
                libm::log10f(hz),
                libm::log10f(*amplitude) - conversion.log_per_um,
            );
            let mut is_above = [false; RECEPTORS];
            for (m, receptor) in Receptor::ALL.into_iter().enumerate() {
                let (Some(threshold), Some(intensity)) =
                    (receptor.log_threshold(hz, log_hz), &mut firing.intensity[m])
                else {
                    continue;
                };
                if log_um >= threshold {
                    *intensity += log_um - threshold;
                    is_above[m] = true;
                }
            }
            for a in 0..RECEPTORS {
                for b in 0..RECEPTORS {
                    firing.above[a][b] += f32::from(u8::from(is_above[a] && is_above[b]));
                }
            }
        }
        firing
    }

    /// Why a receptor has no intensity in a spectrum of `bins` bins, `bin_hz` apart.
    pub fn absent(receptor: Receptor, bins: usize, bin_hz: f32) -> Option<Absent> {
        let [from, _, to] = receptor.corners_hz();
        let first = libm::floorf(from / bin_hz) + 1.0;
        if bins as f32 * bin_hz <= to {
            Some(Absent::RateTooLow(2.0 * to))
        } else if first * bin_hz > to {
            Some(Absent::WindowTooShort)
        } else {
            None
        }
    }

    /// Mean firing over several windows, such as those of all channels at one time. Their scatter is
    /// taken as common to all: it is not divided by their number.
    pub fn mean<'f>(firings: impl Iterator<Item = &'f Self>) -> Self {
        let mut mean = Self::default();
        for (before, firing) in firings.enumerate() {
            mean.average(firing, before);
        }
        mean
    }

    /// Turns the mean of `before` windows into that of one more.
    pub fn average(&mut self, firing: &Self, before: usize) {
        let count = before as f32 + 1.0;
        for a in 0..RECEPTORS {
            let so_far = self.intensity[a].unwrap_or(0.0);
            self.intensity[a] = firing.intensity[a].map(|value| so_far + (value - so_far) / count);
            for b in 0..RECEPTORS {
                self.above[a][b] += (firing.above[a][b] - self.above[a][b]) / count;
            }
        }
    }
}
