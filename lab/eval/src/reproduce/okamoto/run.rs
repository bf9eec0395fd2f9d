//! A scale slid over the finger, and the firmware's answers to it.

use super::motion::Motion;
#[cfg(test)]
use super::motion::SETTLES_S;
use super::paper::SCAN_MM;
use super::skin::Skin;
use anyhow::{Context, Result};
use hal_mock::{Sliding, SlidingScene, sliding::Hand};
use ridgetone_finger::TimedConversion;
use ridgetone_host::input::{Input, Opened};
use ridgetone_host::odometry::{self, Stream};
use ridgetone_host::replay::{self, START_US};
use ridgetone_proto::odometry::{FRAME_BYTES, WIRE_BYTES};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Estimate, Event, Packet};
#[cfg(test)]
use ridgetone_proto::telemetry::{Span, Status};

/// Messages of the robot, in a second: the paper's rate (section III-C).
const MESSAGES_HZ: f64 = 250.0;
/// How long a message is on the line, seconds: ten bits a byte at 921,600 baud. The board knows
/// this.
const ON_THE_LINE_S: f64 = WIRE_BYTES as f64 * 10.0 / 921_600.0;
/// Delay of the bridges' low-pass, seconds: 820 ohm beside 820 ohm, and 1 uF.
pub const FILTER_S: f64 = 0.5 * 820.0 * 1e-6;
/// From the middle of the converter's aperture to DRDY, seconds: half of its filter's 128 (N + 4)
/// clocks of 1 / 15.72864 MHz, N = 1 at the plan's DRATE 3 (SBAS297G, "Digital Filter").
const APERTURE_S: f64 = 64.0 * 5.0 / 15_728_640.0;
/// How late a frame has the place that the finger felt, seconds.
pub const FELT_LATE_S: f64 = FILTER_S + APERTURE_S;

/// A scale under a motion, with the conversions of its scan.
pub struct Slid {
    pub scene: Sliding,
    pub motion: Motion,
    /// Where the scale is: it brakes at the slide's end.
    moves: SlidingScene,
    #[cfg(test)]
    pub skin: Skin,
    /// Frames in volts, with the times of their first taxels, seconds from the slide's begin.
    pub frames: Vec<(f64, [f64; TAXELS])>,
    /// How long the slide lasts, seconds.
    pub lasts_s: f64,
    /// The slide's begin, seconds of the device and of the scene.
    begins_s: f64,
    scene_begins_s: f64,
    scene_ends_s: f64,
}

fn scene(wavelength_mm: f64, motion: Motion, skin: Skin) -> Sliding {
    let (speed_mm_s, hand) = match motion {
        Motion::Steady(speed_mm_s) => (speed_mm_s, None),
        Motion::Hand => (Hand::default().peak_mm_s, Some(Hand::default())),
    };
    let ridge_mm = 0.5 * wavelength_mm;
    let (hold_before_s, hold_after_s) = (0.6, 0.5);
    Sliding {
        speed_mm_s,
        period_mm: wavelength_mm,
        ridge_mm,
        slide_mm: SCAN_MM,
        hold_before_s,
        hold_after_s,
        hand,
        finger: Some(skin.finger()),
        ..Sliding::physical()
    }
}

/// From one taxel to the next, seconds.
pub fn conversion_s() -> f64 {
    1e-9 * f64::from(Plan::HAND.conversion_ns())
}

fn open(scene: &Sliding) -> Result<Opened> {
    Input {
        scene: scene.clone(),
        seed: scene.seed,
    }
    .open_in(&Plan::HAND)
}

/// Settings of a window for a skin, and of the accuracy that it is to have; zero for a window of
/// this length.
pub fn settings(skin: Skin, window_s: f64, accuracy: f32) -> Settings {
    let (window_s, harmonics) = (window_s as f32, skin.harmonics());
    Settings {
        window_s,
        stride_s: 0.05,
        harmonics,
        accuracy,
        ..Settings::DEFAULT.with_plan(Plan::HAND)
    }
}

impl Slid {
    /// Slides.
    pub fn new(wavelength_mm: f64, motion: Motion, skin: Skin) -> Result<Self> {
        let scene = scene(wavelength_mm, motion, skin);
        let input = open(&scene)?;
        let truth = input.truth.context("a scene has its truth")?;
        let (mut frames, mut first_us) = (Vec::<(f64, [f64; TAXELS])>::new(), None);
        replay::conversions_of(input, &Plan::HAND, &mut |timed: TimedConversion| {
            let t_s = f64::from(timed.t_us - *first_us.get_or_insert(timed.t_us)) * 1e-6;
            // AIN0 to AIN15 have the ids 8 to 23 (SBAS297G).
            let Some(taxel) = usize::from(timed.status().chid())
                .checked_sub(8)
                .filter(|taxel| *taxel < TAXELS)
            else {
                return Ok(());
            };
            if taxel == 0 {
                frames.push((t_s, [0.0; TAXELS]));
            }
            if let Some((_, values)) = frames.last_mut() {
                values[taxel] =
                    ads1258::reading::volts(timed.code(), Settings::DEFAULT.vref_v).into();
            }
            Ok(())
        })?;
        // Time of the device is zero at the first conversion, time of the scene when START rises.
        let zero_s = f64::from(first_us.context("no conversion")? - START_US) * 1e-6;
        let begins_s = truth.slide_start_s - zero_s;
        frames.iter_mut().for_each(|(t_s, _)| *t_s -= begins_s);
        Ok(Self {
            moves: SlidingScene::new(scene.clone())?,
            scene,
            motion,
            #[cfg(test)]
            skin,
            frames,
            lasts_s: truth.slide_end_s - truth.slide_start_s,
            begins_s,
            scene_begins_s: truth.slide_start_s,
            scene_ends_s: truth.end_s,
        })
    }

    /// The firmware's estimates; a hand's places are streamed to it, those of so long before the
    /// stamps.
    pub fn estimates(&self, settings: Settings, late_s: f64) -> Result<Vec<Estimate>> {
        let mut estimates = Vec::new();
        let mut sink = |packet: &Packet| {
            if let Event::Estimate(estimate) = &packet.event {
                estimates.push(estimate.clone());
            }
            Ok(())
        };
        let robot = replay::Motion::Robot(self.stream(late_s));
        let motion = Some(robot).filter(|_| self.scene.hand.is_some());
        let input = open(&self.scene)?;
        replay::run(input, settings, motion, &mut sink, &mut |_, _| {})?;
        Ok(estimates)
    }

    /// The robot's messages.
    fn stream(&self, late_s: f64) -> Stream {
        let count = (self.scene_ends_s * MESSAGES_HZ) as usize;
        let message = |number: usize| {
            let t_s = number as f64 / MESSAGES_HZ;
            let since_s = (t_s - late_s - self.scene_begins_s).clamp(0.0, self.lasts_s);
            let message = odometry::message(number, t_s, self.motion.place_mm(since_s), true);
            (
                ((t_s + ON_THE_LINE_S) * 1e6).round() as u64,
                message.encode()[..FRAME_BYTES].to_vec(),
            )
        };
        (0..count).map(message).collect()
    }

    /// Mean speed over a window, mm/s: a tone at a known speed has this one's frequency.
    pub fn mean_speed_mm_s(&self, from_s: f64, until_s: f64) -> f64 {
        let place_mm = |t_s: f64| self.moves.position_mm(self.scene_begins_s + t_s);
        (place_mm(until_s) - place_mm(from_s)) / (until_s - from_s)
    }

    /// An estimate's window, seconds from the slide's begin.
    pub fn window_s(&self, estimate: &Estimate) -> (f64, f64) {
        let until_s = estimate.t_us as f64 * 1e-6 - self.begins_s;
        (until_s - f64::from(estimate.window_s), until_s)
    }

    /// Errors of a hand's good windows in which it goes one way, as shares of the wavelength, and
    /// when they begin and end.
    #[cfg(test)]
    pub fn one_way(&self, estimates: &[Estimate]) -> Vec<(f64, f64, f64)> {
        let is_good =
            |estimate: &&Estimate| estimate.span == Span::Window && estimate.status == Status::Good;
        let all = estimates.iter().filter(is_good).map(|estimate| {
            let (from_s, until_s) = self.window_s(estimate);
            (
                1.0 / (f64::from(estimate.frequency) * self.scene.period_mm) - 1.0,
                from_s,
                until_s,
            )
        });
        all.filter(|(_, from_s, until_s)| !self.motion.turns(from_s - SETTLES_S, *until_s))
            .collect()
    }
}
