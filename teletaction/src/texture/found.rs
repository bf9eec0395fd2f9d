//! A texture that a finger reports, turned into the texture that a hand feels.

use crate::stimulus::{HARMONICS_MAX, Harmonic, Texture};
use ridgetone_host::overtones::{Overtone, overtones};
use ridgetone_proto::telemetry::{Event, Overtones, Packet};

/// Overtones as a hand feels them.
fn harmonics(reported: &Overtones) -> [Harmonic; HARMONICS_MAX - 1] {
    overtones(reported).map(
        |Overtone {
             amplitude,
             phase_cycles,
         }| Harmonic {
            amplitude,
            phase_cycles,
        },
    )
}

/// The texture that a packet reports, if a hand can feel it.
pub fn found(packet: &Packet) -> Option<Texture> {
    let Event::Texture(found) = &packet.event else {
        return None;
    };
    let texture = Texture {
        period_sigma_mm: found.period_sigma_mm,
        power: found.power_v2,
        overtones: harmonics(&found.overtones),
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
            overtones: harmonics(&OVERTONES),
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
