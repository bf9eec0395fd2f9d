//! Textures from files, and from a finger's reports.

mod follower;

pub use follower::{Follower, News};

use crate::stimulus::{AmplitudeLaw, Harmonic, Texture};
use anyhow::{Context, Result};
use hal_mock::short_text;
use ridgetone_host::overtones::{Overtone, overtones};
use ridgetone_proto::telemetry::{Event, Packet};
use std::path::Path;

pub fn load(path: &Path) -> Result<Texture> {
    let named = || path.display().to_string();
    let text = short_text(path)?;
    let texture: Texture = toml::from_str(&text).with_context(named)?;
    texture.check().with_context(named)?;
    Ok(texture)
}

pub fn load_law(path: &Path) -> Result<AmplitudeLaw> {
    let named = || path.display().to_string();
    let law: AmplitudeLaw = toml::from_str(&short_text(path)?).with_context(named)?;
    law.check().with_context(named)?;
    Ok(law)
}

/// Returns the texture that a packet reports, if it can be played.
pub fn found(packet: &Packet) -> Option<Texture> {
    let Event::Texture(found) = &packet.event else {
        return None;
    };
    let harmonic = |Overtone {
                        amplitude,
                        phase_cycles,
                    }| Harmonic {
        amplitude,
        phase_cycles,
    };
    let texture = Texture {
        period_sigma_mm: found.period_sigma_mm,
        power: found.power_v2,
        overtones: overtones(&found.overtones).map(harmonic),
        ..Texture::new(found.period_mm)
    };
    texture.check().ok().map(|()| texture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::telemetry::Texture as Reported;

    #[test]
    fn a_texture_keeps_its_values_and_what_cannot_be_felt_is_none() {
        let reported = |period_mm, power_v2, overtone| {
            found(&Packet {
                sequence: 1,
                event: Event::Texture(Reported {
                    t_us: 2_500_000,
                    plan: Plan::PAPER,
                    period_mm,
                    period_sigma_mm: 0.01,
                    power_v2,
                    power_sigma_v2: 1e-8,
                    overtones: [[0.0, 0.25], [-0.5, overtone], [0.0; 2]],
                    level_v: None,
                }),
            })
        };
        let felt = reported(3.6, 1e-6, 0.0).expect("felt");
        let values = (felt.period_mm, felt.period_sigma_mm, felt.power);
        assert_eq!(values, (3.6, 0.01, 1e-6));
        // The event's cosine and sine parts become amplitudes and phases.
        assert_eq!(felt.overtones.map(|of| of.amplitude), [0.25, 0.5, 0.0]);
        assert_eq!(felt.overtones[0].phase_cycles, 0.0);
        for (period_mm, power_v2, overtone) in [
            (f32::NAN, 1e-6, 0.0),
            (f32::INFINITY, 1e-6, 0.0),
            (0.0, 1e-6, 0.0),
            (-1.0, 1e-6, 0.0),
            (1e9, 1e-6, 0.0),
            (3.6, f32::NAN, 0.0),
            (3.6, 1e-6, f32::NAN),
            (3.6, 1e-6, f32::INFINITY),
        ] {
            assert_eq!(reported(period_mm, power_v2, overtone), None);
        }
    }
}
