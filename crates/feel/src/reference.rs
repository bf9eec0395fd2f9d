//! Conversion from the sensor's unit to displacement, by a surface of known roughness (equations 5,
//! 6).

use crate::Measured;
use crate::windows::{LINE_OVER_NOISE, Windows};
use core::f32::consts::FRAC_1_SQRT_2;
use core::ops::Range;

/// Minimum number of windows for their scatter to be a better uncertainty than the closed form.
pub(crate) const SCATTER_FROM: f32 = 8.0;

/// Distance of the noise bins from the reference's line, bins: the nearest ones outside the main
/// lobe of the Hamming window.
const NOISE_BINS: Range<f32> = 2.5..6.5;

/// Leakage of a line through a Hamming window, relative to its amplitude over the distance in bins:
/// the window's step of 0.08 at its ends, divided by pi and by its mean.
const LEAKAGE: f32 = 0.08 / (core::f32::consts::PI * 0.54);

/// A surface of known roughness, and the finger's speed over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Arithmetic average roughness Ra, um.
    pub ra_um: Measured,
    /// Mean length of the roughness curve's elements RSm, mm.
    pub rsm_mm: f32,
    /// Speed, mm/s.
    pub speed_mm_s: f32,
}

/// Amplitude at a frequency in one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Amplitude in the samples' unit.
    pub amplitude: f32,
    /// Standard deviation of the amplitude, from its noise bins. For a surface without a period it
    /// is slightly more than the amplitude's own scatter.
    pub sigma: f32,
    /// Leakage from distant lines, because a window is finite.
    pub leaked: f32,
}

impl Reference {
    /// Frequency of the surface's elements (equation 5).
    pub fn frequency_hz(&self) -> f32 {
        self.speed_mm_s / self.rsm_mm
    }

    /// Conversion D, in the sensor's unit per um peak to peak, from the amplitude at
    /// [`frequency_hz`](Self::frequency_hz) (equation 6).
    pub fn per_um(&self, amplitude: Measured) -> Measured {
        let value = amplitude.value / (2.0 * self.ra_um.value);
        let fractions = (
            amplitude.sigma / amplitude.value,
            self.ra_um.sigma / self.ra_um.value,
        );
        Measured {
            value,
            sigma: value * libm::hypotf(fractions.0, fractions.1),
        }
    }
}

impl SpectralLine {
    /// Takes the amplitude at `cycles` cycles per window, and the noise from the window's amplitude
    /// spectrum.
    pub fn new(amplitude: f32, spectrum: &[f32], cycles: f32) -> Self {
        let (mut noise, mut count, mut leaked) = (0.0, 0.0, 0.0);
        for (bin, other) in spectrum.iter().enumerate().skip(1) {
            let distance = libm::fabsf(bin as f32 - cycles);
            let power = other * other;
            if NOISE_BINS.contains(&distance) {
                noise += power;
                count += 1.0;
            } else if distance >= NOISE_BINS.end {
                leaked += power * (LEAKAGE / distance) * (LEAKAGE / distance);
            }
        }
        Self {
            amplitude,
            sigma: FRAC_1_SQRT_2 * libm::sqrtf(noise / f32::max(count, 1.0)),
            leaked: libm::sqrtf(leaked),
        }
    }

    /// Mean amplitude over several windows of the measured length, converted to the wanted length.
    /// The uncertainty is the scatter of eight or more windows, or from the noise bins for fewer.
    /// `None` without a window, or if the amplitude is at most twice the leakage.
    pub fn mean(lines: &[Self], windows: Windows) -> Option<Measured> {
        let count = lines.len() as f32;
        let mean_of = |value: fn(&Self) -> f32| lines.iter().map(value).sum::<f32>() / count;
        let mean = mean_of(|line| line.amplitude);
        let noise = mean_of(|line| line.sigma * line.sigma);
        let off = |line: &Self| (line.amplitude - mean) * (line.amplitude - mean);
        let variance = if count >= SCATTER_FROM {
            lines.iter().map(off).sum::<f32>() / (count - 1.0)
        } else {
            noise
        };
        let amplitude = Measured {
            value: mean,
            sigma: libm::sqrtf(variance / count),
        };
        (mean > 2.0 * mean_of(|line| line.leaked))
            .then(|| in_wanted_window(amplitude, 2.0 * noise, windows.bins()))
    }
}

/// Converts an amplitude to a window of `bins` times the length. A line that stands out of the
/// noise keeps its power; noise keeps its power per hertz. If no line stands out, everything is
/// treated as noise, and the change if it were a weak line is added as a standard deviation.
fn in_wanted_window(amplitude: Measured, noise: f32, bins: f32) -> Measured {
    let power = amplitude.value * amplitude.value;
    let tone = f32::max(power - noise, 0.0);
    if power > LINE_OVER_NOISE * noise {
        return Measured {
            value: libm::sqrtf(tone + noise / bins),
            ..amplitude
        };
    }
    let as_noise = amplitude.value / libm::sqrtf(bins);
    // Noise is subtracted and added again, so that both results agree if the window keeps its
    // length.
    let as_tone = libm::sqrtf(tone + (power - tone) / bins);
    Measured {
        value: as_noise,
        sigma: libm::hypotf(amplitude.sigma / libm::sqrtf(bins), as_tone - as_noise),
    }
}
