//! Textures under a finger, from its estimates: a new one when it has changed by more than its standard deviation.

use crate::live::time_s;
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Status, TravelStatus};
use ridgetone_stimulus::Texture;

/// The texture under a finger.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    latest: Option<Texture>,
}

impl Found {
    /// Takes a packet; gives a texture if it is a new one.
    pub fn take(&mut self, packet: &Packet) -> Option<Texture> {
        let Event::Estimate(estimate) = &packet.event else { return None };
        let texture = texture(estimate, time_s(&packet.event).unwrap_or(0.0))?;
        let is_new = self.latest.is_none_or(|latest| texture.differs(&latest));
        is_new.then(|| *self.latest.insert(texture))
    }
}

/// The texture that an estimate has found: a tone that can be trusted, and a period that the phases do not contradict. Power is half of
/// the squared amplitude, the mean of the channels, in square volts.
fn texture(estimate: &Estimate, t_s: f64) -> Option<Texture> {
    let travel = &estimate.travel;
    let is_sure = matches!(estimate.status, Status::Good | Status::Unsteady)
        && matches!(travel.status, TravelStatus::Unique | TravelStatus::Given);
    if !is_sure {
        return None;
    }
    let powers = estimate.channels.iter().map(|channel| 0.5 * channel.amplitude_v * channel.amplitude_v);
    let texture = Texture {
        period_sigma_mm: travel.spatial_period_sigma_mm,
        power: powers.sum::<f32>() / estimate.channels.len().max(1) as f32,
        t_s: t_s as f32,
        ..Texture::new(travel.spatial_period_mm)
    };
    texture.check().ok().map(|()| texture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Input;
    use crate::replay;
    use ridgetone_proto::settings::Settings;

    fn packets() -> Vec<Packet> {
        let mut packets = Vec::new();
        let mut keep = |packet: &Packet| {
            packets.push(packet.clone());
            Ok(())
        };
        replay::run(Input::default().open().expect("a scene"), Settings::DEFAULT, None, &mut keep, &mut |_, _| {})
            .expect("a run");
        packets
    }

    /// The default scene has 3.6 mm, and the array finds it by lags.
    #[test]
    fn a_texture_comes_once_and_again_when_it_has_changed() {
        let packets = packets();
        let mut found = Found::default();
        let textures: Vec<Texture> = packets.iter().filter_map(|packet| found.take(packet)).collect();
        let estimates = packets.iter().filter(|packet| matches!(packet.event, Event::Estimate(_))).count();
        assert!(!textures.is_empty() && textures.len() < estimates, "{} of {estimates}", textures.len());
        for texture in &textures {
            assert!((texture.period_mm - 3.6).abs() < 5.0 * texture.period_sigma_mm, "{texture:?}");
            assert!(texture.period_sigma_mm > 0.0 && texture.power > 0.0 && texture.t_s > 0.0, "{texture:?}");
        }
        for pair in textures.windows(2) {
            assert!(pair[1].differs(&pair[0]), "{pair:?}");
        }
        let mut coarse = packets.iter().rev().find(|p| Found::default().take(p).is_some()).expect("a texture").clone();
        let Event::Estimate(estimate) = &mut coarse.event else { panic!("an estimate") };
        estimate.travel.spatial_period_mm = 2.0;
        assert_eq!(found.take(&coarse).map(|texture| texture.period_mm), Some(2.0));
        assert_eq!(found.take(&coarse), None);
    }

    #[test]
    fn what_is_not_sure_or_no_number_is_no_texture() {
        let packet = packets().into_iter().rev().find(|p| Found::default().take(p).is_some()).expect("a texture");
        let changed = |change: &dyn Fn(&mut Estimate)| {
            let mut packet = packet.clone();
            let Event::Estimate(estimate) = &mut packet.event else { panic!("an estimate") };
            change(estimate);
            Found::default().take(&packet)
        };
        assert!(changed(&|_| ()).is_some());
        for status in [Status::NoTone, Status::Doubtful, Status::Ambiguous, Status::TooShort] {
            assert_eq!(changed(&|estimate| estimate.status = status), None);
        }
        assert_eq!(changed(&|estimate| estimate.travel.status = TravelStatus::Contradicted), None);
        for period_mm in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e9] {
            assert_eq!(changed(&|estimate| estimate.travel.spatial_period_mm = period_mm), None);
        }
        assert_eq!(changed(&|estimate| estimate.channels[0].amplitude_v = f32::NAN), None);
    }
}
