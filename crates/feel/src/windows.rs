//! Effect of the window's length on a spectrum: a line keeps its amplitude, noise its power per
//! hertz.

use core::ops::RangeInclusive;

/// Window over which the paper computes its intensities and conversion, seconds: 30 mm at 10 mm/s
/// (section 2.3). The paper does not say which part of the run is transformed.
pub const PAPER_WINDOW_S: f32 = 3.0;

/// Distances from a line at which the spectrum is only noise, bins: just outside the main lobe of
/// the Hamming window.
const NOISE_BINS: RangeInclusive<usize> = 3..=6;

/// Smallest ratio of a line's power to the mean power of its noise bins. Noise alone exceeds it in
/// one bin of ten thousand: (1 + 17.3 / 8)^-8 with the mean of eight bins.
pub(crate) const LINE_OVER_NOISE: f32 = 17.3;

/// Lengths of windows, seconds. A longer window has more bins, each with a smaller noise amplitude;
/// the amplitude of a tone does not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windows {
    /// Length of the measured windows.
    pub measured_s: f32,
    /// Window length to which amplitudes and intensities are converted.
    pub wanted_s: f32,
}

/// Conversion of a part of a spectrum from the measured window to the wanted one.
#[derive(Clone, Copy)]
pub(crate) struct Law {
    /// Change of the amplitude in a bin, decades.
    pub(crate) log_gain: f32,
    /// Wanted bins per measured bin.
    pub(crate) bins: f32,
}

impl Law {
    /// A tone fills the main lobe in any window: the number of bins and their amplitudes are
    /// unchanged.
    pub(crate) const TONE: Self = Self {
        log_gain: 0.0,
        bins: 1.0,
    };
}

impl Windows {
    /// Spacing of the measured bins, hertz.
    pub fn bin_hz(&self) -> f32 {
        1.0 / self.measured_s
    }

    /// Wanted bins per measured bin.
    pub(crate) fn bins(&self) -> f32 {
        self.wanted_s / self.measured_s
    }

    pub(crate) fn noise(&self) -> Law {
        Law {
            log_gain: -0.5 * libm::log10f(self.bins()),
            bins: self.bins(),
        }
    }
}

/// Mean power of the noise bins of a line; `None` if the bin may be only noise.
pub(crate) fn noise_of_line(amplitudes: &[f32], bin: usize) -> Option<f32> {
    let amplitude = amplitudes.get(bin)?;
    let (mut power, mut count) = (0.0, 0.0);
    for distance in NOISE_BINS {
        let below = bin.checked_sub(distance).filter(|bin| *bin > 0);
        for other in [below, Some(bin + distance)].into_iter().flatten() {
            if let Some(other) = amplitudes.get(other) {
                power += other * other;
                count += 1.0;
            }
        }
    }
    let noise = power / f32::max(count, 1.0);
    (amplitude * amplitude > LINE_OVER_NOISE * noise).then_some(noise)
}
