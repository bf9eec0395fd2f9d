//! The periodogram's peak with parabolic correction: the apex of a parabola through the logarithms
//! of the highest line and its neighbours.
//!
//! Smith and Serra, "PARSHL: an analysis/synthesis program for non-harmonic sounds based on a
//! sinusoidal representation", ICMC 1987; Abe and Smith, "Design criteria for simple sinusoidal
//! parameter estimation based on quadratic interpolation of FFT magnitude peaks", 117th AES
//! Convention, 2004. Through the powers themselves the parabola is further off at every length of
//! window that was tried: without a window function a line is narrow, and its logarithm is nearer
//! to a parabola.

use super::periodogram::Peak;
use super::samples::{Frame, Scratch};

/// The apex, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let peak = Peak::find(values, channels, scratch)?;
    let [below, highest, above] = peak.power;
    // A neighbour without power has no logarithm; the highest line alone is then all there is.
    if !(below > 0.0 && above > 0.0) {
        return Some(peak.frequency(0.0));
    }
    let (below, above) = (libm::logf(below / highest), libm::logf(above / highest));
    let bend = below + above;
    Some(peak.frequency(if bend < 0.0 {
        0.5 * (above - below) / -bend
    } else {
        0.0
    }))
}
