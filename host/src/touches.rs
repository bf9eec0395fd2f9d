//! Inputs that are played again and again.

use crate::input::{Input, Opened, Source, first_scene};
use anyhow::{Context, Result};
use hal_mock::{Scene, Sliding, SlidingScene};

/// From the end of a touch to the beginning of the next, seconds.
const PAUSE_S: f64 = 1.0;

/// Spatial periods of the gratings under the first scene's finger, one a touch, millimetres: those
/// of Oddo et al. 2009, table 2, beginning with the scene's own.
pub const PERIODS_MM: [f64; 4] = [3.6, 4.1, 3.1, 2.6];

/// Repeats a scene every `every_s` seconds until `end_s`.
pub struct Again<S> {
    pub scene: S,
    pub every_s: f64,
    pub end_s: f64,
}

impl<S: Scene> Scene for Again<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        self.scene.volts(input, t_s.max(0.0) % self.every_s)
    }

    fn end_s(&self) -> f64 {
        self.end_s
    }
}

/// Length of a recording's begin whose noise fills the pause after its end, seconds.
const LEAD_S: f64 = 0.1;

/// A recording, and a pause in which its last values go back to its first ones under the noise that
/// it begins with. A step of the level or of the noise would be felt as a touch.
struct Bridged {
    recording: Box<dyn Scene>,
    leads: [Lead; 16],
}

/// What an input reads in the first [`LEAD_S`], volts.
#[derive(Default)]
struct Lead {
    volts: Vec<f64>,
    /// Number of the value that is played next.
    next: usize,
}

impl Lead {
    /// A value of the pause, `share` of the way back from `last_v`.
    fn play(&mut self, last_v: f64, share: f64) -> f64 {
        let Some(volts) = self.volts.get(self.next % self.volts.len().max(1)) else {
            return last_v;
        };
        self.next += 1;
        let mean_v = self.volts.iter().sum::<f64>() / self.volts.len() as f64;
        (1.0 - share) * (last_v - mean_v) + volts
    }
}

impl Scene for Bridged {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let volts = self.recording.volts(input, t_s);
        let Some(lead) = self.leads.get_mut(usize::from(input)) else {
            return volts;
        };
        let since_end_s = t_s - self.recording.end_s();
        if since_end_s > 0.0 {
            return lead.play(volts, (since_end_s / PAUSE_S).min(1.0));
        }
        // Only while it is played for the first time.
        if t_s < LEAD_S && lead.next == 0 && volts.is_finite() {
            lead.volts.push(volts);
        }
        volts
    }

    fn end_s(&self) -> f64 {
        self.recording.end_s() + PAUSE_S
    }
}

/// Touches of one finger, each over the next grating.
struct Gratings {
    scenes: Vec<SlidingScene>,
    /// Number of the touch that is played.
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
    /// Repeats the input for ever, with a second's pause.
    #[must_use]
    pub fn repeated(self) -> Self {
        let every_s = self.end_s + PAUSE_S;
        let scene: Box<dyn Scene> = if self.truth.is_some() {
            self.scene
        } else {
            Box::new(Bridged {
                recording: self.scene,
                leads: Default::default(),
            })
        };
        Self {
            scene: Box::new(Again {
                scene,
                every_s,
                end_s: f64::INFINITY,
            }),
            end_s: f64::INFINITY,
            ..self
        }
    }
}

/// A scene in front of the board.
pub fn of_scene(scene: Sliding) -> Result<Opened> {
    Input {
        seed: scene.seed,
        source: Source::Scene(scene),
        ..Input::default()
    }
    .open()
}

/// The first scene for ever, over one grating of [`PERIODS_MM`] after the other.
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
        // Every touch has its own.
        truth: None,
        ..opened
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{SLOT_S, frame_rate_hz};
    use crate::replay;
    use crate::samples::Samples;
    use hal_mock::write_csv;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{Event, Span, TravelStatus};

    /// Times of contacts and releases, and the period of each whole slide, of 30 s.
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

    /// A scene written to a table of its own, and read again.
    fn recorded(scene: Sliding, path: &std::path::Path) -> Opened {
        let mut made = SlidingScene::new(scene).expect("a scene");
        let mut file = std::fs::File::create(path).expect("a file");
        write_csv(&mut made, frame_rate_hz(), SLOT_S, &mut file).expect("written");
        Input {
            source: Source::Trace {
                samples: Samples::file(path).expect("a table"),
                rate_hz: None,
                volts_per_unit: 1.0,
            },
            ..Input::default()
        }
        .open()
        .expect("a recording")
    }

    #[test]
    fn a_scene_and_its_recording_repeat_as_they_are() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("touch.csv");
        let (first, noisy) = (first_scene().expect("a scene"), Sliding::default());
        for scene in [first, noisy] {
            let opened = of_scene(scene.clone()).expect("a scene");
            let truth = opened.truth.expect("of a scene");
            let touches = ((30.0 - truth.contact_s) / (truth.end_s + PAUSE_S)).ceil() as usize;
            for input in [opened, recorded(scene, &path)] {
                let (contacts_s, releases_s, _) = felt(input.repeated());
                assert_eq!(contacts_s.len(), touches, "{contacts_s:?}");
                for (touch, contact_s) in contacts_s.iter().enumerate() {
                    let due_s = truth.contact_s + touch as f64 * (truth.end_s + PAUSE_S);
                    assert!((contact_s - due_s).abs() < 0.05, "{contacts_s:?}");
                }
                assert!(releases_s.len() >= touches - 1, "{releases_s:?}");
            }
        }
    }
}
