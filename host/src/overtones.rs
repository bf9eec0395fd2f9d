//! Overtones of a texture, with their phases as sines.

pub use crate::events::view::Overtone;
use ridgetone_proto::telemetry::Overtones;
use std::f64::consts::TAU;

/// Returns the overtones of a reported texture: amplitudes up to 1, and phases as sines.
pub fn overtones(reported: &Overtones) -> [Overtone; 3] {
    let mut turn = 1;
    reported.map(|[re, im]| {
        // Phases are relative to the fundamental as a sine, so each further order turns the phase
        // by a quarter turn: a factor of -i. Subtract from zero instead of negating, because minus
        // zero would have a phase.
        let (sine_re, sine_im) = match turn % 4 {
            1 => (im, 0.0 - re),
            2 => (0.0 - re, 0.0 - im),
            3 => (0.0 - im, re),
            _ => (re, im),
        };
        turn += 1;
        let (re, im) = (f64::from(sine_re), f64::from(sine_im));
        // Keep NaN and infinity, so that a reader can reject them.
        let amplitude = re.hypot(im);
        let amplitude = if amplitude.is_finite() {
            amplitude.min(1.0)
        } else {
            amplitude
        };
        Overtone {
            amplitude: amplitude as f32,
            phase_cycles: (im.atan2(re) / TAU) as f32,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With v = u + turn / 4, sin v + a sin(k v + p) is a wave whose fundamental is a cosine of u
    /// with phase 0.
    #[test]
    fn phases_are_those_of_sines() {
        for (n, k) in (2..=4).enumerate() {
            for eighth in -3..=4 {
                let (amplitude, cycles) = (0.1 * f64::from(k), 0.125 * f64::from(eighth));
                // sin(k v + p) = cos(k u + k pi / 2 + p - pi / 2).
                let cosine = TAU * (cycles + 0.25 * f64::from(k) - 0.25);
                let mut reported = [[0.0; 2]; 3];
                reported[n] = [
                    (amplitude * cosine.cos()) as f32,
                    (amplitude * cosine.sin()) as f32,
                ];
                let found = overtones(&reported)[n];
                let off = f64::from(found.phase_cycles) - cycles;
                assert!(
                    (f64::from(found.amplitude) - amplitude).abs() < 1e-6,
                    "{k} {eighth}: {found:?}"
                );
                assert!((off - off.round()).abs() < 1e-6, "{k} {eighth}: {found:?}");
            }
        }
        // Noise can make an overtone larger than a weak fundamental; its amplitude is limited to 1.
        assert_eq!(
            overtones(&[[3.0, 4.0]; 3]).map(|overtone| overtone.amplitude),
            [1.0; 3]
        );
        let none = Overtone {
            amplitude: 0.0,
            phase_cycles: 0.0,
        };
        assert_eq!(overtones(&[[0.0; 2]; 3]), [none; 3]);
    }
}
