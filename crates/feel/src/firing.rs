//! Firing intensity of each kind of receptor in a window (equations 8 and 9).

use crate::receptor::{RECEPTORS, Receptor};
use crate::windows::{Law, Windows, noise_of_line};

/// Reason why a receptor has no intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The spectrum ends below the upper end of the receptor's range. Contains the sampling rate in
    /// hertz that must be exceeded.
    RateTooLow(f32),
    /// No bin of the spectrum is in the receptor's range.
    WindowTooShort,
}

/// Square matrix over the receptors.
pub(crate) type Matrix = [[f32; RECEPTORS]; RECEPTORS];

/// Mean logarithm of a noise amplitude relative to the root of its mean power, decades: half of the
/// mean logarithm of an exponential variable, which is minus Euler's constant.
const NOISE_LOG_MEAN: f32 = -0.125_34;

/// Firing of the receptors in a window, in the order of [`Receptor::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Firing {
    /// Sum over the bins of the receptor's range of the decades by which the spectrum exceeds the
    /// threshold; `None` if [`absent`](Self::absent).
    pub intensity: [Option<f32>; RECEPTORS],
    /// Number of bins above the threshold, in a window of the wanted length.
    pub above: [f32; RECEPTORS],
    /// For each pair of receptors, the sum over the measured bins of the product of their two
    /// counts of wanted-window bins above the threshold.
    pub products: Matrix,
    /// Change of the intensity if all lines were noise: in the measured window a tone and noise
    /// narrower than a bin look the same.
    pub lines_as_noise: [f32; RECEPTORS],
}

impl Firing {
    /// Estimates the firing in a window of the wanted length from the amplitude spectrum (um peak
    /// to peak, from bin 0) of a window of the measured length under a Hamming window. A bin with a
    /// line that stands out and its two neighbours count as a tone over noise, all other bins as
    /// noise.
    pub fn new(amplitudes_um: &[f32], windows: Windows) -> Self {
        let bin_hz = windows.bin_hz();
        let has = |receptor| Self::absent(receptor, amplitudes_um.len(), bin_hz).is_none();
        let mut firing = Self {
            intensity: Receptor::ALL.map(|receptor| has(receptor).then_some(0.0)),
            ..Self::default()
        };
        // A window that already has the wanted length needs no conversion.
        let is_converted = windows.bins() != 1.0;
        let noise_at = |bin| {
            is_converted
                .then(|| noise_of_line(amplitudes_um, bin))
                .flatten()
        };
        let (mut before, mut here) = (None, noise_at(1));
        for (bin, amplitude) in amplitudes_um.iter().enumerate().skip(1) {
            let after = noise_at(bin + 1);
            let noise = here.or(before).or(after);
            firing.add(
                bin as f32 * bin_hz,
                libm::log10f(*amplitude),
                noise.map(|power| 0.5 * libm::log10f(power) + NOISE_LOG_MEAN),
                windows.noise(),
            );
            (before, here) = (here, after);
        }
        firing
    }

    /// Adds a measured bin, from the logarithm of its amplitude and of the noise under its line, if
    /// any.
    fn add(&mut self, hz: f32, log_um: f32, log_noise_um: Option<f32>, noise_law: Law) {
        let mut wanted_bins = [0.0; RECEPTORS];
        for (m, receptor) in Receptor::ALL.into_iter().enumerate() {
            let (Some(threshold), Some(intensity)) =
                (receptor.log_threshold(hz), &mut self.intensity[m])
            else {
                continue;
            };
            let as_noise = Decades::above(threshold, log_um, noise_law);
            let found = match log_noise_um {
                None => as_noise,
                Some(log_noise_um) => {
                    let tone = Decades::above(threshold, log_um, Law::TONE);
                    // A tone hides the noise in one wanted bin for each measured bin.
                    let uncovered = Law {
                        bins: noise_law.bins - 1.0,
                        ..noise_law
                    };
                    let noise = Decades::above(threshold, log_noise_um, uncovered);
                    self.lines_as_noise[m] += as_noise.sum - tone.sum - noise.sum;
                    Decades {
                        sum: tone.sum + noise.sum,
                        bins: tone.bins + noise.bins,
                    }
                }
            };
            *intensity += found.sum;
            self.above[m] += found.bins;
            wanted_bins[m] = found.bins;
        }
        for a in 0..RECEPTORS {
            for b in 0..RECEPTORS {
                self.products[a][b] += wanted_bins[a] * wanted_bins[b];
            }
        }
    }

    /// Returns the reason why a receptor has no intensity in a spectrum of `bins` bins, `bin_hz`
    /// apart.
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

    /// Mean firing over several windows, such as those of all channels at one time. Their scatter
    /// is assumed to be common to all, so it is not divided by their number.
    pub fn mean<'f>(firings: impl Iterator<Item = &'f Self>) -> Self {
        let mut mean = Self::default();
        for (before, firing) in firings.enumerate() {
            mean.average(firing, before);
        }
        mean
    }

    /// Adds a window to the mean of `before` windows.
    pub(crate) fn average(&mut self, firing: &Self, before: usize) {
        let count = before as f32 + 1.0;
        let average = |mean: &mut f32, value: f32| *mean += (value - *mean) / count;
        for a in 0..RECEPTORS {
            let so_far = self.intensity[a].unwrap_or(0.0);
            self.intensity[a] = firing.intensity[a].map(|value| so_far + (value - so_far) / count);
            average(&mut self.above[a], firing.above[a]);
            average(&mut self.lines_as_noise[a], firing.lines_as_noise[a]);
            for b in 0..RECEPTORS {
                average(&mut self.products[a][b], firing.products[a][b]);
            }
        }
    }
}

/// Contribution of a part of a measured bin to the wanted window.
#[derive(Clone, Copy, Default)]
struct Decades {
    /// Decades above the threshold, summed over the wanted bins.
    sum: f32,
    /// Wanted bins above the threshold.
    bins: f32,
}

impl Decades {
    fn above(threshold: f32, log_um: f32, law: Law) -> Self {
        let decades = log_um + law.log_gain - threshold;
        if decades >= 0.0 {
            Self {
                sum: law.bins * decades,
                bins: law.bins,
            }
        } else {
            Self::default()
        }
    }
}
