//! From the sensor's unit to displacement, by a surface whose roughness is known.

use crate::spectrum::{amplitude_at, amplitude_spectrum};
use crate::windows::{LINE_OVER_NOISE, Windows};
use core::f32::consts::{FRAC_1_SQRT_2, LN_10};
use core::ops::Range;

/// Number of windows from which on their scatter is a better uncertainty than the closed form.
pub(crate) const SCATTER_FROM: f32 = 8.0;

/// Distance from the reference's line of the bins that show its noise: the nearest ones outside
/// Hamming's main lobe.
const BESIDE: Range<f32> = 2.5..6.5;

/// Leakage of a line through Hamming's window, relative to its amplitude over the distance in bins:
/// the window's step of 0.08 at its ends over pi and over its mean.
const LEAKAGE: f32 = 0.08 / (core::f32::consts::PI * 0.54);

/// A surface whose roughness is known, and how fast the finger runs over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Arithmetic average roughness Ra, um.
    pub ra_um: f32,
    /// Its standard deviation, um.
    pub ra_sigma_um: f32,
    /// Mean length of the roughness curve's elements RSm, mm.
    pub rsm_mm: f32,
    /// Speed, mm/s.
    pub speed_mm_s: f32,
}

/// The amplitude at a frequency in one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// In the samples' unit.
    pub amplitude: f32,
    /// Its standard deviation, by what is beside it in the spectrum: noise as strong as there turns
    /// the amplitude by that much, and for a surface without a period it is a little more than the
    /// amplitude's own scatter.
    pub sigma: f32,
    /// Leakage from lines further away, because a window is finite.
    pub leaked: f32,
}

/// The recording of the reference has no amplitude at the reference's frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoAmplitude;

/// How much of the sensor's unit a displacement gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Logarithm to the base of ten of D: amplitude in the sensor's unit per um from peak to peak.
    pub log_per_um: f32,
    /// Its standard deviation, decades.
    pub log_sigma: f32,
}

impl Reference {
    /// The frequency of its elements (equation 5).
    pub fn frequency_hz(&self) -> f32 {
        self.speed_mm_s / self.rsm_mm
    }

    /// D (equation 6) by the amplitude at that frequency and its standard deviation.
    pub fn conversion(&self, amplitude: f32, sigma: f32) -> Result<Conversion, NoAmplitude> {
        let log_per_um = libm::log10f(amplitude / (2.0 * self.ra_um));
        let share = libm::hypotf(sigma / amplitude, self.ra_sigma_um / self.ra_um);
        if log_per_um.is_finite() {
            Ok(Conversion {
                log_per_um,
                log_sigma: share / LN_10,
            })
        } else {
            Err(NoAmplitude)
        }
    }
}

impl SpectralLine {
    /// Measures the amplitude at `cycles` cycles in a window of [`amplitude_spectrum`]'s lengths,
    /// whose memory is used; none for another length.
    pub fn measure(samples: &mut [f32], cycles: f32) -> Option<Self> {
        let amplitude = amplitude_at(samples, cycles);
        Some(Self::new(amplitude, amplitude_spectrum(samples)?, cycles))
    }

    /// The amplitude at `cycles` cycles with what is beside it in the spectrum.
    pub fn new(amplitude: f32, spectrum: &[f32], cycles: f32) -> Self {
        let (mut beside, mut count, mut leaked) = (0.0, 0.0, 0.0);
        for (bin, other) in spectrum.iter().enumerate().skip(1) {
            let distance = libm::fabsf(bin as f32 - cycles);
            let power = other * other;
            if BESIDE.contains(&distance) {
                beside += power;
                count += 1.0;
            } else if distance >= BESIDE.end {
                leaked += power * (LEAKAGE / distance) * (LEAKAGE / distance);
            }
        }
        let sigma = FRAC_1_SQRT_2 * libm::sqrtf(beside / f32::max(count, 1.0));
        Self {
            amplitude,
            sigma,
            leaked: libm::sqrtf(leaked),
        }
    }

    /// The mean of several windows of the measured length, converted to the wanted length, with its
    /// standard deviation: from eight windows on by their scatter, with fewer by the noise beside the
    /// line. None without a window, and where the amplitude is not more than twice what leaks.
    pub fn mean(lines: impl Iterator<Item = Self> + Clone, windows: Windows) -> Option<(f32, f32)> {
        let count = lines.clone().count() as f32;
        let mean_of =
            |value: fn(&Self) -> f32| lines.clone().map(|line| value(&line)).sum::<f32>() / count;
        let mean = mean_of(|line| line.amplitude);
        let variance = match count >= SCATTER_FROM {
            true => {
                lines
                    .clone()
                    .map(|line| (line.amplitude - mean) * (line.amplitude - mean))
                    .sum::<f32>()
                    / (count - 1.0)
            }
            false => mean_of(|line| line.sigma * line.sigma),
        };
        let noise = 2.0 * mean_of(|line| line.sigma * line.sigma);
        let sigma = libm::sqrtf(variance / count);
        (mean > 2.0 * mean_of(|line| line.leaked))
            .then(|| in_wanted_window(mean, sigma, noise, windows.bins()))
    }
}

/// An amplitude in a window of `bins` times the length, with its standard deviation. A line that
/// stands out of the noise keeps its power; noise keeps its power a hertz. If no line stands out, all
/// of it is taken as noise; what a weak line would change counts as a standard deviation.
fn in_wanted_window(amplitude: f32, sigma: f32, noise: f32, bins: f32) -> (f32, f32) {
    let power = amplitude * amplitude;
    let tone = f32::max(power - noise, 0.0);
    if power > LINE_OVER_NOISE * noise {
        return (libm::sqrtf(tone + noise / bins), sigma);
    }
    let as_noise = amplitude / libm::sqrtf(bins);
    // Noise is subtracted and added again, so that both agree if the window keeps its length.
    let as_tone = libm::sqrtf(tone + (power - tone) / bins);
    let sigma = libm::hypotf(sigma / libm::sqrtf(bins), as_tone - as_noise);
    (as_noise, sigma)
}

impl Conversion {
    /// D: amplitude in the sensor's unit per um from peak to peak.
    pub fn per_um(&self) -> f32 {
        libm::exp10f(self.log_per_um)
    }

    /// Its standard deviation.
    pub fn per_um_sigma(&self) -> f32 {
        self.per_um() * self.log_sigma * LN_10
    }
}
