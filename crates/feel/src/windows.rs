//! How a spectrum changes with the length of the window.

use core::ops::RangeInclusive;

/// Distances from a line at which the spectrum is noise alone, bins: just outside the main lobe of
/// Hamming's window.
const BESIDE: RangeInclusive<usize> = 3..=6;

/// A line's power over the mean power beside it. Noise alone exceeds it in one bin of ten thousand:
/// over the mean of eight bins, (1 + 17.3 / 8)^-8.
pub(crate) const LINE_OVER_NOISE: f32 = 17.3;

/// Lengths of windows, seconds. A longer window has more bins; in each of them noise has a smaller
/// amplitude, and a tone keeps its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windows {
    /// The windows that were measured.
    pub measured_s: f32,
    /// The windows for which amplitudes and intensities are wanted.
    pub wanted_s: f32,
}

/// How a part of a spectrum changes from the measured window to the wanted one.
#[derive(Clone, Copy)]
pub(crate) struct Law {
    /// Change of the amplitude in a bin, decades.
    pub(crate) log_gain: f32,
    /// Bins for each measured one.
    pub(crate) bins: f32,
}

impl Law {
    /// A tone fills the main lobe in any window: as many bins, with the same amplitudes.
    pub(crate) const TONE: Self = Self {
        log_gain: 0.0,
        bins: 1.0,
    };
}

impl Windows {
    /// Windows that need no conversion: the length that is measured is the one that is wanted.
    pub const fn same(seconds: f32) -> Self {
        Self {
            measured_s: seconds,
            wanted_s: seconds,
        }
    }

    /// Distance of the measured bins, hertz.
    pub fn bin_hz(&self) -> f32 {
        1.0 / self.measured_s
    }

    /// Bins of the wanted window for each measured one.
    pub(crate) fn bins(&self) -> f32 {
        self.wanted_s / self.measured_s
    }

    /// Noise has the same power a hertz in any window.
    pub(crate) fn noise(&self) -> Law {
        Law {
            log_gain: -0.5 * libm::log10f(self.bins()),
            bins: self.bins(),
        }
    }
}

/// The power of the noise at a bin if a line is in it; none if noise may be all that is there.
pub(crate) fn noise_of_line(amplitudes: &[f32], bin: usize) -> Option<f32> {
    let amplitude = amplitudes.get(bin)?;
    let (mut power, mut count) = (0.0, 0.0);
    for distance in BESIDE {
        let below = bin.checked_sub(distance).filter(|bin| *bin > 0);
        for beside in [below, Some(bin + distance)].into_iter().flatten() {
            if let Some(other) = amplitudes.get(beside) {
                power += other * other;
                count += 1.0;
            }
        }
    }
    let noise = power / f32::max(count, 1.0);
    (amplitude * amplitude > LINE_OVER_NOISE * noise).then_some(noise)
}
