//! The intensity with which each kind of receptor fires in a window.

use crate::receptor::{RECEPTORS, Receptor};
use crate::reference::Conversion;
use crate::windows::{Law, Windows, noise_of_line};

/// Why a receptor has no intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The spectrum ends below the receptor's range; at this rate it would not, hertz.
    RateTooLow(f32),
    /// No bin of the spectrum is in the receptor's range.
    WindowTooShort,
}

/// Square matrix over the receptors.
pub(crate) type Matrix = [[f32; RECEPTORS]; RECEPTORS];

/// Mean logarithm of the amplitude of noise over that of the root of its mean power, decades: half of
/// Euler's constant, which is the mean logarithm of an exponential variable.
const NOISE_LOG_MEAN: f32 = -0.125_34;

/// How the receptors fire in a window, in the order of [`Receptor::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Firing {
    /// Sum over the bins of the receptor's range of the decades by which the spectrum is above the
    /// threshold (equations 8 and 9); none where [`absent`](Self::absent).
    pub intensity: [Option<f32>; RECEPTORS],
    /// Bins above the threshold, in the wanted window.
    pub above: [f32; RECEPTORS],
    /// For two receptors the product of their wanted bins above the threshold, summed over the
    /// measured bins: each of these stands for several wanted ones.
    pub products: Matrix,
    /// Change of the intensity if all lines were noise: in the measured window a tone and noise
    /// narrower than a bin look the same.
    pub lines_as_noise: [f32; RECEPTORS],
}

impl Firing {
    /// Estimates how the receptors fire in a window of the wanted length, from the amplitude spectrum
    /// of one of the measured length. A bin in which a line stands out and its two neighbours count
    /// as a tone over noise, all others as noise.
    pub fn new(amplitudes: &[f32], windows: Windows, conversion: &Conversion) -> Self {
        let mut firing = Self::default();
        let bin_hz = windows.bin_hz();
        let last_hz = Receptor::ALL.iter().fold(0.0, |last: f32, receptor| {
            last.max(receptor.corners_hz()[2])
        });
        for (receptor, intensity) in Receptor::ALL.into_iter().zip(&mut firing.intensity) {
            *intensity = Self::absent(receptor, amplitudes.len(), bin_hz)
                .is_none()
                .then_some(0.0);
        }
        let noise_law = windows.noise();
        // In windows of one length tones and noise change alike: not at all.
        let is_converted = windows.bins() != 1.0;
        let noise_at = |bin| {
            is_converted
                .then(|| noise_of_line(amplitudes, bin))
                .flatten()
        };
        let (mut before, mut here) = (None, noise_at(1));
        for (k, amplitude) in amplitudes.iter().enumerate().skip(1) {
            let hz = k as f32 * bin_hz;
            if hz > last_hz {
                break;
            }
            let after = noise_at(k + 1);
            let log_um = libm::log10f(*amplitude) - conversion.log_per_um;
            let bin = Bin {
                log_um,
                log_noise_um: here.or(before).or(after).map(|power| {
                    0.5 * libm::log10f(power) + NOISE_LOG_MEAN - conversion.log_per_um
                }),
            };
            firing.add(&bin, noise_law, hz);
            (before, here) = (here, after);
        }
        firing
    }

    /// Adds a measured bin.
    fn add(&mut self, bin: &Bin, noise_law: Law, hz: f32) {
        let log_hz = libm::log10f(hz);
        let mut wanted_bins = [0.0; RECEPTORS];
        for (m, receptor) in Receptor::ALL.into_iter().enumerate() {
            let (Some(threshold), Some(intensity)) =
                (receptor.log_threshold(hz, log_hz), &mut self.intensity[m])
            else {
                continue;
            };
            let as_noise = Decades::above(threshold, bin.log_um, noise_law);
            let found = match bin.log_noise_um {
                None => as_noise,
                Some(log_noise_um) => {
                    let tone = Decades::above(threshold, bin.log_um, Law::TONE);
                    // A tone hides the noise in one wanted bin for each measured one.
                    let beside = Law {
                        bins: noise_law.bins - 1.0,
                        ..noise_law
                    };
                    let noise = Decades::above(threshold, log_noise_um, beside);
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

/// A measured bin, logarithms of um from peak to peak.
struct Bin {
    log_um: f32,
    /// The noise under a line; none if the bin is noise alone.
    log_noise_um: Option<f32>,
}

/// The contribution of a measured bin to the wanted window.
#[derive(Clone, Copy, Default)]
struct Decades {
    /// Decades above the threshold, over all bins.
    sum: f32,
    /// Bins above the threshold.
    bins: f32,
}

impl Decades {
    /// The share of a part of the measured bin that changes by `law`.
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
