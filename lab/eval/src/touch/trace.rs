//! A touch as the chip converts it, and what a detector should report of it.

use crate::draw::Draw;
use crate::noise::process::pink_frames;
use crate::simulated::CODE_V;
use anyhow::Result;
use hal_mock::{Finger, Scene, Sliding, SlidingScene, Stimulator};
use ridgetone_host::input::frame_rate_hz;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::TAU;

/// Spatial period of the grating, millimetres.
const PERIOD_MM: f64 = 3.6;
/// Noise of the converter at the scan's data rate, volts rms.
const CONVERTER_V: f64 = 4.5e-6;
/// Whoever knows the motion sees it from where its squares, in units of the noise, add up to this:
/// five standard deviations.
const VISIBLE: f64 = 25.0;

/// From where to where a number is drawn; evenly in the logarithm, so both are above zero.
pub type Range = (f64, f64);

/// How the traces of a cell are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    pub tone_hz: Range,
    /// The tone's power over that of the noise, decibels.
    pub snr_db: f64,
    /// How long the slide lasts; the speed's ramps are in it. None: the finger only holds.
    pub slide_s: Option<Range>,
    pub ramp_s: Range,
    /// In the air, before and after the touch.
    pub idle_s: Range,
    pub hold_before_s: Range,
    pub hold_after_s: Range,
    /// Pink noise in place of white.
    pub pink: bool,
    /// Square of the contact spike over that of the hold. None: about 2.
    pub spike: Option<Range>,
    /// What the skin creeps by under the load and back after it, over the tone's amplitude.
    pub creep: f64,
    /// Drift of each channel, up or down, volts a second.
    pub drift_v_s: f64,
    /// Hum of 50 Hz, as much as the tone, and whether the detector is given its frequency.
    pub hum: Option<bool>,
    /// Share of the usual load.
    pub load: f64,
    /// The finger presses by so much more and less than the load, at 1 to 3 Hz.
    pub press: f64,
    /// The finger is on the grating when the trace begins.
    pub loaded: bool,
    /// The physical finger in place of drawn channels: creep and filter are its own, and its noise
    /// too.
    pub physical: bool,
}

/// When what happens, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// None if it was before the trace.
    pub contact_s: Option<f64>,
    pub slide: Option<SlideTruth>,
    pub release_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideTruth {
    pub start_s: f64,
    pub end_s: f64,
    /// When so much of the motion has passed, or is still to come, that it shows in the noise.
    pub visible_from_s: f64,
    pub visible_to_s: f64,
}

pub struct Trace {
    scene: SlidingScene,
    extras: Extras,
    draw: Draw,
    truth: Truth,
    from_s: f64,
    frames: u32,
}

/// What is added to the scene.
struct Extras {
    recipe: Recipe,
    loads_v: [f64; TAXELS],
    tone_v: f64,
    spike: f64,
    creep_s: f64,
    signs: [f64; TAXELS],
    hum: [(f64, f64); TAXELS],
    hum_hz: f64,
    press: (f64, f64),
    pink: Vec<[f64; TAXELS]>,
    pink_v: f64,
    contact_s: f64,
    release_s: f64,
}

impl Trace {
    /// Equal seeds give equal traces.
    pub fn new(recipe: &Recipe, seed: u64) -> Result<Self> {
        let mut draw = Draw::new(seed);
        let mut of = |(least, most): Range| draw.log(least, most);
        let tone_hz = of(recipe.tone_hz);
        // A slide of a thousandth of a period is none.
        let slide_s = recipe.slide_s.map(&mut of);
        let ramp_s = of(recipe.ramp_s).min(slide_s.unwrap_or(1.0) / 2.0);
        let speed_mm_s = tone_hz * PERIOD_MM;
        let still = Sliding::default();
        let slide_mm = slide_s.map_or(1e-3 * PERIOD_MM, |slide_s| speed_mm_s * (slide_s - ramp_s));
        let stimulator = Stimulator {
            ramp_s: if slide_s.is_some() { ramp_s } else { 0.0 },
            ..Stimulator::IDEAL
        };
        let parameters = Sliding {
            speed_mm_s,
            period_mm: PERIOD_MM,
            slide_mm,
            idle_s: of(recipe.idle_s),
            hold_before_s: of(recipe.hold_before_s),
            hold_after_s: of(recipe.hold_after_s),
            release_idle_s: 1.2,
            start_mm: of((1.0, 1.0 + PERIOD_MM)),
            snr_db: (!recipe.physical && !recipe.pink).then_some(recipe.snr_db),
            seed,
            stimulator,
            finger: recipe.physical.then(|| Finger {
                finger_seed: seed,
                ..Finger::default()
            }),
            ..still
        };
        let spike = recipe.spike.map(&mut of);
        let creep_s = of((0.5, 3.0));
        let scene = SlidingScene::new(parameters)?;
        let times = scene.truth();
        let channels = &scene.channels()[..TAXELS];
        let mean_square = |of: &dyn Fn(usize) -> f64| {
            (0..TAXELS).map(|c| of(c).powi(2)).sum::<f64>() / TAXELS as f64
        };
        let tone_v = mean_square(&|c| channels[c].amplitude_v()).sqrt();
        let loads_v: [f64; TAXELS] = std::array::from_fn(|c| channels[c].sliding.mean_v);
        // A spike that is as high as the load in each channel has a square that is four times the
        // hold's.
        let spike = spike.map_or(0.0, |square| square.sqrt() - 1.0);
        let rate_hz = frame_rate_hz();
        let from_s = if recipe.loaded {
            times.contact_s + 1.0
        } else {
            0.0
        };
        let frames = ((times.end_s - from_s) * rate_hz) as u32;
        let pink = if recipe.pink {
            pink_frames(frames as usize, rate_hz, &mut draw)
        } else {
            Vec::new()
        };
        let extras = Extras {
            recipe: *recipe,
            loads_v,
            tone_v,
            spike,
            creep_s,
            signs: std::array::from_fn(|_| if draw.coin() { 1.0 } else { -1.0 }),
            hum: std::array::from_fn(|_| (tone_v * draw.even(0.5, 1.5), draw.even(0.0, TAU))),
            hum_hz: draw.even(49.75, 50.25),
            press: (draw.log(1.0, 3.0), draw.even(0.0, TAU)),
            pink,
            pink_v: tone_v / (2.0 * 10f64.powf(0.1 * recipe.snr_db)).sqrt(),
            contact_s: times.contact_s,
            release_s: times.release_s,
        };
        let sigma_v = if recipe.pink {
            extras.pink_v
        } else {
            scene.noise_v()
        }
        .hypot(CONVERTER_V);
        let slide = recipe.slide_s.map(|_| {
            let (start_s, end_s) = (times.slide_start_s, times.slide_end_s);
            let visible = |at_s: f64, step_s: f64| {
                let volts = |t_s: f64| (0..TAXELS).map(move |c| (c, t_s));
                let rest: Vec<f64> = volts(at_s)
                    .map(|(c, t_s)| scene.clean_volts(c as u8, t_s))
                    .collect();
                let (mut t_s, mut sum) = (at_s, 0.0);
                while sum < VISIBLE && (start_s..=end_s).contains(&t_s) {
                    let off = |(c, t_s): (usize, f64)| {
                        (scene.clean_volts(c as u8, t_s) - rest[c]) / sigma_v
                    };
                    sum += volts(t_s).map(off).map(|off| off * off).sum::<f64>();
                    t_s += step_s;
                }
                t_s - from_s
            };
            let (visible_from_s, visible_to_s) = (
                visible(start_s, 1.0 / rate_hz),
                visible(end_s, -1.0 / rate_hz),
            );
            SlideTruth {
                start_s: start_s - from_s,
                end_s: end_s - from_s,
                visible_from_s,
                visible_to_s,
            }
        });
        let contact_s = (!recipe.loaded).then_some(times.contact_s);
        let truth = Truth {
            contact_s,
            slide,
            release_s: times.release_s - from_s,
        };
        Ok(Self {
            scene,
            extras,
            draw,
            truth,
            from_s,
            frames,
        })
    }

    pub fn truth(&self) -> Truth {
        self.truth
    }

    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The code of a channel in a frame, which is converted at a time from the trace's start on.
    /// Times must not decrease.
    pub fn code(&mut self, channel: usize, frame: u32, t_s: f64) -> i32 {
        let t_s = self.from_s + t_s;
        let volts = self.scene.volts(channel as u8, t_s) + self.extras.volts(channel, frame, t_s);
        let pressed_v =
            self.scene.clean_volts(channel as u8, t_s) - self.scene.channels()[channel].offset_v;
        let volts = volts + self.extras.press(t_s) * pressed_v;
        let more = self
            .extras
            .load(self.scene.load(t_s), self.scene.spike(t_s));
        let volts = volts + more * self.extras.loads_v[channel] + CONVERTER_V * self.draw.normal();
        (volts / CODE_V).round() as i32
    }
}

impl Extras {
    /// What comes to the scene's load and spike, relative to the load.
    fn load(&self, load: f64, spike: f64) -> f64 {
        // The scene has a spike of its own, about half as high as the load.
        (self.spike - 0.5).max(0.0) * spike - (1.0 - self.recipe.load) * load
    }

    fn volts(&self, c: usize, frame: u32, t_s: f64) -> f64 {
        let recipe = &self.recipe;
        let (held_s, gone_s) = (t_s - self.contact_s, t_s - self.release_s);
        let mut volts = recipe.drift_v_s * self.signs[c] * t_s;
        if recipe.creep > 0.0 && held_s > 0.0 {
            let crept = |for_s: f64| 1.0 - (-for_s / self.creep_s).exp();
            let back = if gone_s > 0.0 {
                1.0 - crept(gone_s)
            } else {
                1.0
            };
            let share = crept(held_s.min(self.release_s - self.contact_s)) * back;
            volts += recipe.creep * self.tone_v * share * self.loads_v[c] / self.rms_load_v();
        }
        if recipe.hum.is_some() {
            let (amplitude_v, phase) = self.hum[c];
            volts += amplitude_v * (TAU * self.hum_hz * t_s + phase).sin();
        }
        volts
            + self
                .pink
                .get(frame as usize)
                .map_or(0.0, |noise| self.pink_v * noise[c])
    }

    /// Share by which the load is more than it should be.
    fn press(&self, t_s: f64) -> f64 {
        let (hz, phase) = self.press;
        // It begins and ends gently.
        let edge = ((t_s - self.contact_s).min(self.release_s - t_s) / 0.1).clamp(0.0, 1.0);
        edge * self.recipe.press * (TAU * hz * t_s + phase).sin()
    }

    fn rms_load_v(&self) -> f64 {
        (self.loads_v.iter().map(|volts| volts * volts).sum::<f64>() / TAXELS as f64).sqrt()
    }
}
