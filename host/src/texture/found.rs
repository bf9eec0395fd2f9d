//! A texture that a finger reports, turned into the texture that a hand feels.

use crate::digits::seconds;
use ridgetone_proto::telemetry::{Event, Overtones, Packet};
use ridgetone_stimulus::{HARMONICS_MAX, Harmonic, Texture};
use std::f64::consts::TAU;

/// Overtones as a texture has them: amplitudes over the fundamental's, not above 1, and phases as
/// sines.
pub fn overtones(reported: &Overtones) -> [Harmonic; HARMONICS_MAX - 1] {
    let mut turn = 1;
    reported.map(|[re, im]| {
        // As in `learn`: against the fundamental as a sine each number more takes a quarter of a
        // turn, a product with -i. Zero less a zero is zero, and has no phase; minus zero would
        // have one.
        let (sine_re, sine_im) = match turn % 4 {
            1 => (im, 0.0 - re),
            2 => (0.0 - re, 0.0 - im),
            3 => (0.0 - im, re),
            _ => (re, im),
        };
        turn += 1;
        let (re, im) = (f64::from(sine_re), f64::from(sine_im));
        // NaN stays NaN, and is refused.
        let amplitude = re.hypot(im);
        let amplitude = if amplitude.is_finite() {
            amplitude.min(1.0)
        } else {
            amplitude
        };
        Harmonic {
            amplitude: amplitude as f32,
            phase_cycles: (im.atan2(re) / TAU) as f32,
        }
    })
}

/// The texture that a packet reports, if a hand can feel it. Its force in newtons is unknown.
pub fn found(packet: &Packet) -> Option<Texture> {
    let Event::Texture(found) = &packet.event else {
        return None;
    };
    let texture = Texture {
        period_sigma_mm: found.period_sigma_mm,
        power: found.power_v2,
        t_s: seconds(found.t_us) as f32,
        overtones: overtones(&found.overtones),
        ..Texture::new(found.period_mm)
    };
    texture.check().ok().map(|()| texture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::telemetry::{Release, Texture as Reported};

    const OVERTONES: Overtones = [[0.0, 0.25], [-0.5, 0.0], [0.0; 2]];

    /// sin v + a sin(k v + p) is, with v = u + turn / 4, a wave whose cosines have the
    /// fundamental's phase 0.
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
        // Noise may make an overtone of a faint fundamental too large.
        assert_eq!(
            overtones(&[[3.0, 4.0]; 3]).map(|overtone| overtone.amplitude),
            [1.0; 3]
        );
        assert_eq!(overtones(&[[0.0; 2]; 3]), Texture::new(1.0).overtones);
    }

    #[test]
    fn a_texture_keeps_its_values_and_what_cannot_be_felt_is_none() {
        let reported = Reported {
            t_us: 2_500_000,
            plan: Plan::PAPER,
            period_mm: 3.6,
            period_sigma_mm: 0.01,
            power_v2: 1e-6,
            power_sigma_v2: 1e-8,
            overtones: OVERTONES,
            level_v: None,
        };
        let felt = |reported| {
            found(&Packet {
                sequence: 1,
                event: Event::Texture(reported),
            })
        };
        let wanted = Texture {
            period_sigma_mm: 0.01,
            power: 1e-6,
            t_s: 2.5,
            overtones: overtones(&OVERTONES),
            ..Texture::new(3.6)
        };
        assert_eq!(felt(reported), Some(wanted));
        for period_mm in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e9] {
            assert_eq!(
                felt(Reported {
                    period_mm,
                    ..reported
                }),
                None
            );
        }
        assert_eq!(
            felt(Reported {
                power_v2: f32::NAN,
                ..reported
            }),
            None
        );
        for no_number in [f32::NAN, f32::INFINITY] {
            let overtones = [[0.0; 2], [0.25, no_number], [0.0; 2]];
            assert_eq!(
                felt(Reported {
                    overtones,
                    ..reported
                }),
                None
            );
        }
        assert_eq!(
            found(&Packet {
                sequence: 1,
                event: Event::Release(Release { t_us: 5 })
            }),
            None
        );
    }
}
