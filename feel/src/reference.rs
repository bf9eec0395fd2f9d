//! From the sensor's unit to displacement, by a surface whose roughness is known.

use core::f32::consts::{FRAC_1_SQRT_2, LN_10};

/// Bins on each side of the reference's line that show its noise: the nearest ones outside Hamming's main lobe.
const FLOOR_FROM: usize = 3;
const FLOOR_BINS: usize = 4;

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
        if log_per_um.is_finite() { Ok(Conversion { log_per_um, log_sigma: share / LN_10 }) } else { Err(NoAmplitude) }
    }

    /// Standard deviation of an amplitude at so many cycles in a window, by what is beside it in the window's spectrum: noise
    /// as strong as there turns the amplitude by that much, and of a surface without a period it is a little more than the
    /// amplitude's own scatter.
    pub fn sigma(amplitudes: &[f32], cycles: f32) -> f32 {
        let centre = libm::roundf(cycles) as usize;
        let bins = FLOOR_FROM..FLOOR_FROM + FLOOR_BINS;
        let beside = bins.flat_map(|off| [centre.checked_sub(off).filter(|bin| *bin > 0), Some(centre + off)]);
        let (mut sum, mut count) = (0.0, 0.0);
        for amplitude in beside.flatten().filter_map(|bin| amplitudes.get(bin)) {
            sum += amplitude * amplitude;
            count += 1.0;
        }
        FRAC_1_SQRT_2 * libm::sqrtf(sum / f32::max(count, 1.0))
    }
}

impl Conversion {
    /// D: amplitude in the sensor's unit per um from peak to peak.
    pub fn per_um(&self) -> f32 {
        libm::exp10f(self.log_per_um)
    }
}
