//! Scenes that are played repeatedly.

use crate::input::{Input, Opened, first_scene};
use anyhow::{Context, Result};
use hal_mock::{Scene, Sliding, SlidingScene};

/// Time between two touches, seconds.
const PAUSE_S: f64 = 1.0;

/// Spatial periods in millimetres of the gratings under the first scene's finger, one per touch:
/// those of Oddo et al. 2009, table 2, beginning with the scene's own.
pub const PERIODS_MM: [f64; 4] = [3.6, 4.1, 3.1, 2.6];

/// Repeats a scene every `every_s` seconds until `end_s`.
pub struct Again<S> {
    pub scene: S,
    pub every_s: f64,
    pub end_s: f64,
}

impl<S: Scene> Scene for Again<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        self.scene
            .volts(input, t_s.clamp(0.0, self.end_s) % self.every_s)
    }

    fn end_s(&self) -> f64 {
        self.end_s
    }
}

/// Touches of one finger, each over a different grating.
struct Gratings {
    scenes: Vec<SlidingScene>,
    touch: usize,
    every_s: f64,
}

impl Scene for Gratings {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let touch = (t_s.max(0.0) / self.every_s) as usize;
        let (at, before) = (touch % self.scenes.len(), self.touch % self.scenes.len());
        if touch != self.touch {
            let skin = self.scenes[before].skin();
            self.scenes[at].set_skin(skin);
            self.touch = touch;
        }
        self.scenes[at].volts(input, t_s.max(0.0) % self.every_s)
    }

    fn end_s(&self) -> f64 {
        f64::INFINITY
    }
}

impl Opened {
    /// Repeats the input for ever, with a pause of one second.
    #[must_use]
    pub fn repeated(self) -> Self {
        let every_s = self.end_s + PAUSE_S;
        Self {
            scene: Box::new(Again {
                scene: self.scene,
                every_s,
                end_s: f64::INFINITY,
            }),
            end_s: f64::INFINITY,
            ..self
        }
    }
}

pub fn of_scene(scene: Sliding) -> Result<Opened> {
    Input::of(scene).open()
}

/// Repeats the first scene for ever, over the gratings of [`PERIODS_MM`] in turn.
pub fn first_touches() -> Result<Opened> {
    let first = first_scene()?;
    let scenes = PERIODS_MM
        .map(|period_mm| {
            SlidingScene::new(Sliding {
                period_mm,
                ..first.clone()
            })
        })
        .into_iter()
        .collect::<Result<_, _>>()
        .context("the first scene")?;
    let opened = of_scene(first)?;
    Ok(Opened {
        scene: Box::new(Gratings {
            scenes,
            touch: 0,
            every_s: opened.end_s + PAUSE_S,
        }),
        end_s: f64::INFINITY,
        // Omit the truth, which differs for every touch.
        truth: None,
        ..opened
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{Event, Span, TravelStatus};

    /// Returns the times of contacts and releases, and the period of each whole slide, in the first
    /// 30 s.
    fn felt(mut input: Opened) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        input.end_s = 30.0;
        input.scene = Box::new(Again {
            scene: input.scene,
            every_s: f64::INFINITY,
            end_s: input.end_s,
        });
        let (mut contacts_s, mut releases_s, mut periods_mm) = (vec![], vec![], vec![]);
        let mut sink = |packet: &ridgetone_proto::telemetry::Packet| {
            match &packet.event {
                Event::Contact(contact) => contacts_s.push(contact.t_us as f64 * 1e-6),
                Event::Release(release) => releases_s.push(release.t_us as f64 * 1e-6),
                Event::Estimate(estimate)
                    if estimate.span == Span::Slide
                        && estimate.travel.status == TravelStatus::Uncalibrated =>
                {
                    periods_mm.push(f64::from(estimate.travel.spatial_period_mm));
                }
                _ => {}
            }
            Ok(())
        };
        replay::run(input, Settings::DEFAULT, &mut sink, &mut |_, _| {}).expect("a run");
        (contacts_s, releases_s, periods_mm)
    }

    #[test]
    fn every_touch_of_the_first_scene_has_its_own_period() {
        let (contacts_s, releases_s, periods_mm) = felt(first_touches().expect("a scene"));
        assert!(contacts_s.len() >= 3, "{contacts_s:?}");
        assert!(releases_s.len() >= 3, "{releases_s:?}");
        assert!(periods_mm.len() >= 3, "{periods_mm:?}");
        for (found_mm, true_mm) in periods_mm.iter().zip(PERIODS_MM.iter().cycle()) {
            assert!((found_mm - true_mm).abs() < 0.02, "{periods_mm:?}");
        }
    }

    #[test]
    fn a_scene_repeats_as_it_is() {
        for scene in [first_scene().expect("a scene"), Sliding::default()] {
            let opened = of_scene(scene).expect("a scene");
            let truth = opened.truth.expect("of a scene");
            let touches = ((30.0 - truth.contact_s) / (truth.end_s + PAUSE_S)).ceil() as usize;
            let (contacts_s, releases_s, _) = felt(opened.repeated());
            assert_eq!(contacts_s.len(), touches, "{contacts_s:?}");
            for (touch, contact_s) in contacts_s.iter().enumerate() {
                let due_s = truth.contact_s + touch as f64 * (truth.end_s + PAUSE_S);
                assert!((contact_s - due_s).abs() < 0.05, "{contacts_s:?}");
            }
            assert!(releases_s.len() >= touches - 1, "{releases_s:?}");
        }
    }
}
