//! A scale slid over the finger, and the answers to it: the firmware's at a steady speed, those of
//! the fit by position of a hand.

use super::motion::Motion;
#[cfg(test)]
use super::motion::SETTLES_S;
use super::paper::SCAN_MM;
use super::skin::Skin;
use anyhow::{Context, Result};
use hal_mock::{Sliding, SlidingScene, sliding::Hand};
use ridgetone_finger::TimedConversion;
use ridgetone_host::alignment::Alignment;
use ridgetone_host::input::{Input, Opened};
use ridgetone_host::part::Selection;
use ridgetone_host::replay::{self, START_US};
use ridgetone_host::samples::Samples;
use ridgetone_host::speed::Column;
use ridgetone_host::table_fit;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Span, Status};
use std::ops::Range;
use std::sync::Arc;

/// Frames that a window which grows begins with.
const GROWING_FRAMES_MIN: f64 = 24.0;
/// Delay of the bridges' low-pass, seconds: 820 ohm beside 820 ohm, and 1 uF.
pub const FILTER_S: f64 = 0.5 * 820.0 * 1e-6;
/// From the middle of the converter's aperture to DRDY, seconds: half of its filter's 128 (N + 4)
/// clocks of 1 / 15.72864 MHz, N = 1 at the plan's DRATE 3 (SBAS297G, "Digital Filter").
const APERTURE_S: f64 = 64.0 * 5.0 / 15_728_640.0;
/// How late a frame has the place that the finger felt, seconds.
pub const FELT_LATE_S: f64 = FILTER_S + APERTURE_S;

/// The answer to a window.
#[derive(Clone, Debug)]
pub struct Answer {
    pub span: Span,
    pub status: Status,
    /// Begin and end of the window, seconds from the slide's begin.
    pub from_s: f64,
    pub until_s: f64,
    /// Hertz at a steady speed, cycles per millimetre of a hand.
    pub frequency: f64,
    pub sigma: f64,
    /// Mean square of the fundamental's amplitude over the channels, square volts.
    pub square_v2: f64,
}

/// Column of the positions.
const POSITION: &str = "position_mm";

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
        })
    }

    /// The answers to the windows of these settings; the positions of a hand are those of so long
    /// before the frames.
    pub fn answers(&self, settings: Settings, late_s: f64) -> Result<Vec<Answer>> {
        match self.motion {
            Motion::Steady(_) => self.firmware(settings),
            Motion::Hand => self.by_position(settings, late_s),
        }
    }

    fn firmware(&self, settings: Settings) -> Result<Vec<Answer>> {
        let mut answers = Vec::new();
        let mut sink = |packet: &Packet| {
            if let Event::Estimate(estimate) = &packet.event {
                answers.push(self.answer(estimate));
            }
            Ok(())
        };
        replay::run(open(&self.scene)?, settings, &mut sink, &mut |_, _| {})?;
        Ok(answers)
    }

    fn answer(&self, estimate: &Estimate) -> Answer {
        let until_s = estimate.t_us as f64 * 1e-6 - self.begins_s;
        let squares = estimate
            .channels
            .iter()
            .map(|channel| f64::from(channel.amplitude_v).powi(2));
        Answer {
            span: estimate.span,
            status: estimate.status,
            from_s: until_s - f64::from(estimate.window_s),
            until_s,
            frequency: estimate.frequency.into(),
            sigma: estimate.sigma.into(),
            square_v2: squares.sum::<f64>() / estimate.channels.len().max(1) as f64,
        }
    }

    /// Fits as `fit --positions` does, in the windows of a slide that the firmware would cut.
    fn by_position(&self, settings: Settings, late_s: f64) -> Result<Vec<Answer>> {
        let samples = self.with_positions(late_s);
        let (rate_hz, window_s) = (settings.plan.frame_rate_hz(), f64::from(settings.window_s));
        let frame_s = 1.0 / f64::from(rate_hz);
        let grows = settings.accuracy > 0.0;
        let (mut answers, mut reported_s) = (Vec::new(), 0.0);
        let strides = (self.lasts_s / f64::from(settings.stride_s)) as usize;
        for until_s in (1..=strides).map(|stride| stride as f64 * f64::from(settings.stride_s)) {
            let least_s = if grows { reported_s } else { 0.0 };
            let from_s = (until_s - window_s).max(least_s);
            if until_s - from_s < GROWING_FRAMES_MIN * frame_s {
                continue;
            }
            let Some(answer) = self.fit(&samples, &settings, from_s..until_s)? else {
                continue;
            };
            let is_accurate = matches!(answer.status, Status::Good | Status::Unsteady)
                && answer.sigma <= f64::from(settings.accuracy) * answer.frequency;
            if grows && !is_accurate && until_s - from_s < window_s - 0.5 * frame_s {
                continue;
            }
            reported_s = until_s;
            answers.push(answer);
        }
        Ok(answers)
    }

    fn fit(
        &self,
        samples: &Samples,
        settings: &Settings,
        part_s: Range<f64>,
    ) -> Result<Option<Answer>> {
        let middle = (TAXELS as f32 - 1.0) / 2.0;
        let slots = settings.plan.slots() as f32;
        let selection = Selection {
            from_s: Some(part_s.start),
            to_s: Some(part_s.end),
            harmonics: Some(settings.harmonics),
            position: Some(Column::millimetres(POSITION)),
            alignment: Some(Alignment {
                file: "the hand".into(),
                skew_frames: std::array::from_fn(|taxel| (taxel as f32 - middle) / slots),
                low_pass_s: FILTER_S,
                sigma_s: 0.0,
            }),
            ..Selection::default()
        };
        let fit = table_fit::fit(&mut *samples.open()?, &selection, &mut |_| {})?;
        let found = fit.tone.frequency();
        Ok(found.map(|found| Answer {
            span: Span::Window,
            status: fit.status,
            from_s: part_s.start,
            until_s: part_s.end,
            frequency: found.value,
            sigma: found.sigma,
            square_v2: 0.0,
        }))
    }

    /// The frames, with the positions that the finger felt.
    fn with_positions(&self, late_s: f64) -> Samples {
        let mut names: Vec<String> = (0..TAXELS).map(|taxel| format!("ain{taxel}")).collect();
        names.push(POSITION.into());
        let frames = Arc::new(self.frames.clone());
        let middle_s = 0.5 * (TAXELS - 1) as f64 * conversion_s();
        let (motion, lasts_s, values) = (self.motion, self.lasts_s, Arc::clone(&frames));
        let value_at = move |row: usize, column: usize| {
            let (t_s, volts): &(f64, [f64; TAXELS]) = &values[row];
            let at_s = (t_s + middle_s - late_s).clamp(0.0, lasts_s);
            volts
                .get(column)
                .copied()
                .unwrap_or_else(|| motion.place_mm(at_s))
        };
        let count = frames.len();
        let time_at = move |row: usize| frames[row].0;
        Samples::array(
            "the hand",
            names,
            count,
            Arc::new(value_at),
            Some(Arc::new(time_at)),
        )
    }

    /// Mean speed over a window, mm/s: a tone at a known speed has this one's frequency.
    pub fn mean_speed_mm_s(&self, from_s: f64, until_s: f64) -> f64 {
        let place_mm = |t_s: f64| self.moves.position_mm(self.scene_begins_s + t_s);
        (place_mm(until_s) - place_mm(from_s)) / (until_s - from_s)
    }

    /// Errors of a hand's good windows in which it goes one way, as shares of the wavelength, and
    /// when they begin and end.
    #[cfg(test)]
    pub fn one_way(&self, answers: &[Answer]) -> Vec<(f64, f64, f64)> {
        let is_good =
            |answer: &&Answer| answer.span == Span::Window && answer.status == Status::Good;
        let all = answers.iter().filter(is_good).map(|answer| {
            let off = 1.0 / (answer.frequency * self.scene.period_mm) - 1.0;
            (off, answer.from_s, answer.until_s)
        });
        all.filter(|(_, from_s, until_s)| !self.motion.turns(from_s - SETTLES_S, *until_s))
            .collect()
    }
}
