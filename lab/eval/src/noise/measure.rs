//! The answers to many windows of a cell: the estimator's, and those of its opponent.

use super::bound;
use super::process::Noise;
use super::window::{Recipe, Window};
use crate::accuracy::{Accuracy, Answer, NINETY_FIVE, Sample, rounded};
use crate::baselines::nls;
use crate::draw::Draw;
use anyhow::{Context, Result};
use ridgetone_host::input::frame_rate_hz;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status, Table};
use serde::{Deserialize, Serialize};

/// Harmonics that the fit may use.
const HARMONICS: u8 = 4;
/// A good answer off by more than this share is wrong.
const WRONG: f64 = 0.05;
/// Where there are two tones, an answer that is farther from both than this many of its sigmas: tones may be nearer to
/// each other than 5 %.
const WRONG_SIGMAS: f64 = 5.0;
/// The opponent, which is a hundred times as slow, gets every tenth window.
const NLS_EVERY: u64 = 10;

/// Answers to the windows of a cell, by what they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    pub windows: u32,
    pub good: u32,
    pub ambiguous: u32,
    #[serde(default)]
    pub unsteady: u32,
    /// Good ones off by more than 5 %, or where there is no tone; of two tones, farther than five
    /// sigmas from both.
    pub wrong: u32,
    /// Good ones whose 95 % interval holds the mean frequency.
    pub covered: u32,
    /// Those that name the second tone, within 5 %.
    #[serde(default)]
    pub second: u32,
    /// Good or unsteady ones that do not name both of two tones; none where there is one.
    #[serde(default)]
    pub unnamed: Option<u32>,
    /// Mean over the good ones of sigma over the bound, where there is one.
    #[serde(default)]
    pub sigma_over_bound: Option<f64>,
    /// 95 % intervals of those that are good or unsteady.
    #[serde(default)]
    pub movement: Movement,
    /// Error over bound, where there is one.
    #[serde(default)]
    pub accuracy: Option<Accuracy>,
}

/// How many 95 % intervals of good and unsteady answers hold what they are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Movement {
    pub answers: u32,
    /// The mean of the frequency, by the sigma against it.
    pub mean: u32,
    pub wander: u32,
    /// Those in windows whose frequency is a line, and the intervals of its chirp that hold it.
    pub lines: u32,
    pub chirp: u32,
}

/// What an estimator says of a window, in cycles per frame.
#[derive(Clone, Copy, Debug)]
struct Reported {
    status: Status,
    frequency: f64,
    sigma: f64,
    half_width: f64,
    second: Option<f64>,
    movement: ridgetone_tone::Movement,
}

impl Reported {
    fn by(fit: &Fit) -> Self {
        let (frequency, sigma) = (f64::from(fit.frequency), f64::from(fit.sigma));
        let second = fit.other_tone.map(|tone| f64::from(tone.frequency));
        Self {
            status: fit.status,
            frequency,
            sigma,
            half_width: NINETY_FIVE * sigma,
            second,
            movement: fit.movement,
        }
    }

    fn by_opponent(estimate: Option<nls::Estimate>) -> Self {
        let status = if estimate.is_some() {
            Status::Good
        } else {
            Status::NoTone
        };
        let [frequency, sigma, half_width] = estimate.map_or([0.0; 3], |estimate| {
            [estimate.frequency, estimate.sigma, estimate.half_width]
        });
        Self {
            status,
            frequency,
            sigma,
            half_width,
            second: None,
            movement: Default::default(),
        }
    }

    /// The answer to a window with a bound, as the trade counts it. The rate turns cycles per frame
    /// into hertz.
    fn sample(&self, recipe: &Recipe, window: &Window, rate_hz: f64) -> Option<Sample> {
        let (clue, true_hz) = (bound::clue(window)?, rate_hz * window.mean?);
        let bound_hz = rate_hz * clue.sigma_hz();
        // Impulses are in the score, and not in the bound.
        let luck_hz = if recipe.noise == Noise::Impulses {
            bound_hz
        } else {
            rate_hz * clue.error_hz()
        };
        let (hz, sigma_hz) = (rate_hz * self.frequency, Some(rate_hz * self.sigma));
        let answer = Answer {
            hz,
            sigma_hz,
            ambiguous: self.status != Status::Good,
        };
        Some(Sample {
            true_hz,
            bound_hz,
            luck_hz,
            answer: self.status.has_tone().then_some(answer),
        })
    }
}

impl Answers {
    fn add(&mut self, reported: &Reported, window: &Window) {
        self.windows += 1;
        self.ambiguous += u32::from(reported.status == Status::Ambiguous);
        self.unsteady += u32::from(reported.status == Status::Unsteady);
        let is_near = |found: f64, truth: f64| (found / truth - 1.0).abs() <= WRONG;
        let both = reported.second.zip(window.second).zip(window.mean);
        // Either of the two may be the one that is reported first.
        let names = |((other, second), mean)| {
            is_near(other, second) && is_near(reported.frequency, mean)
                || is_near(other, mean) && is_near(reported.frequency, second)
        };
        let names_both = both.is_some_and(names);
        self.second += u32::from(names_both);
        let is_sure = matches!(reported.status, Status::Good | Status::Unsteady);
        if window.second.is_some() {
            *self.unnamed.get_or_insert(0) += u32::from(is_sure && !names_both);
        }
        if is_sure {
            self.movement.add(reported, window);
        }
        if reported.status != Status::Good {
            return;
        }
        self.good += 1;
        let Some(mean) = window.mean else {
            self.wrong += 1;
            return;
        };
        let holds =
            |truth: f64| u32::from((reported.frequency - truth).abs() <= reported.half_width);
        self.covered += holds(mean);
        let is_right = match window.second {
            Some(second) => {
                let off = (reported.frequency - mean)
                    .abs()
                    .min((reported.frequency - second).abs());
                off <= WRONG_SIGMAS * reported.sigma
            }
            None => is_near(reported.frequency, mean),
        };
        self.wrong += u32::from(!is_right);
    }

    /// RMS of the error over the bound.
    pub fn over_bound(&self) -> Option<f64> {
        Some(self.accuracy?.error?.ratio)
    }
}

impl Movement {
    fn add(&mut self, reported: &Reported, window: &Window) {
        let Some(mean) = window.mean else {
            return;
        };
        let moves = reported.movement;
        let holds = |found: f64, truth: f64, sigma: f64| {
            u32::from((found - truth).abs() <= NINETY_FIVE * sigma)
        };
        self.answers += 1;
        self.mean += holds(reported.frequency, mean, reported.sigma);
        self.wander += holds(
            moves.wander.into(),
            window.wander,
            moves.wander_sigma.into(),
        );
        self.lines += u32::from(window.chirp.is_some());
        self.chirp += window.chirp.map_or(0, |chirp| {
            holds(moves.chirp.into(), chirp, moves.chirp_sigma.into())
        });
    }
}

/// What the estimator says of a window.
fn fit(fitter: &mut Fitter, window: &Window, scene: &Scene) -> Result<Reported> {
    let (values, frames) = (&window.values, window.values.len() as u32);
    let valid = &vec![u16::MAX; values.len()];
    let mut table = Table { values, valid };
    let mut span = FrameSpan::new(&mut table, 0, frames).with_quantization(window.step);
    if let Some(cycles) = window.interferer {
        span = span.with_interferer(cycles as f32);
    }
    let fit = fitter.fit(&mut span, scene);
    Ok(Reported::by(&fit.context("a table loses no frames")?))
}

/// The answers to `windows` windows of `window_s` seconds, and those of the opponent to some of
/// them. Equal seeds give equal windows.
pub fn measure(
    recipe: &Recipe,
    window_s: f64,
    windows: u32,
    seed: u64,
    scene: &Scene,
) -> Result<[Answers; 2]> {
    let (mut answers, mut samples) = ([Answers::default(); 2], [Vec::new(), Vec::new()]);
    let rate_hz = frame_rate_hz();
    let frames = (window_s * rate_hz).round() as usize;
    let mut fitter = Box::new(Fitter::new());
    for number in 0..u64::from(windows) {
        let window = recipe.make(
            frames,
            rate_hz,
            &mut Draw::new(seed.wrapping_mul(1_000_003).wrapping_add(number)),
        );
        let reported = fit(&mut fitter, &window, scene)?;
        let opponent = number.is_multiple_of(NLS_EVERY).then(|| {
            let estimate =
                nls::estimate(&window.values, TAXELS, HARMONICS.into(), window.interferer);
            Reported::by_opponent(estimate)
        });
        for (who, reported) in [Some(reported), opponent].into_iter().enumerate() {
            let Some(reported) = reported else { continue };
            answers[who].add(&reported, &window);
            samples[who].extend(reported.sample(recipe, &window, rate_hz));
        }
    }
    for (answers, samples) in answers.iter_mut().zip(&samples) {
        answers.accuracy = (!samples.is_empty()).then(|| Accuracy::new(samples));
        let good = samples.iter().filter_map(|sample| {
            Some((
                sample.bound_hz,
                sample.answer.filter(|answer| !answer.ambiguous)?.sigma_hz?,
            ))
        });
        let (sum, count) = good.fold((0.0, 0.0), |(sum, count), (bound_hz, sigma_hz)| {
            (sum + sigma_hz / bound_hz, count + 1.0)
        });
        answers.sigma_over_bound = (count > 0.0).then(|| rounded(sum / count));
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use super::super::parts::{Extra, Speed, Tone};
    use super::*;

    /// In white noise the estimator is on its bound: what this counts is known from the trade.
    #[test]
    fn answers_in_white_noise_are_good_and_their_intervals_hold() {
        let tone = Tone {
            cycles: (4.0, 12.0),
            harmonics: [1.0, 0.4, 0.2, 0.1, 0.0],
            snr_db: 20.0,
            speed: Speed::Steady,
        };
        let recipe = Recipe {
            noise: Noise::White,
            tone: Some(tone),
            extra: Extra::Nothing,
        };
        let [answers, opponent] = measure(&recipe, 1.0, 40, 7, &Scene::DEFAULT).expect("answers");
        assert_eq!(
            (answers.windows, answers.good, answers.wrong),
            (40, 40, 0),
            "{answers:?}"
        );
        assert!(answers.covered >= 34, "{answers:?}");
        assert!(
            (0.9..1.1).contains(&answers.over_bound().expect("a bound")),
            "{answers:?}"
        );
        assert!(
            (0.98..1.08).contains(&answers.sigma_over_bound.expect("a bound")),
            "{answers:?}"
        );
        assert_eq!(
            (opponent.windows, opponent.good, opponent.wrong),
            (4, 4, 0),
            "{opponent:?}"
        );
        assert_eq!(
            measure(&recipe, 1.0, 40, 7, &Scene::DEFAULT).expect("answers")[0],
            answers,
            "equal seeds"
        );
        assert_ne!(
            measure(&recipe, 1.0, 40, 8, &Scene::DEFAULT).expect("answers")[0].accuracy,
            answers.accuracy,
            "other seeds"
        );
        let [none, opponent] = measure(
            &Recipe {
                tone: None,
                ..recipe
            },
            1.0,
            40,
            7,
            &Scene::DEFAULT,
        )
        .expect("answers");
        assert_eq!(
            (none.good, none.wrong, opponent.good),
            (0, 0, 0),
            "{none:?}"
        );
    }

    #[test]
    fn two_tones_are_named_in_either_order() {
        let window = Window {
            mean: Some(0.03),
            second: Some(0.05),
            ..Window::default()
        };
        let reported = |frequency, second| {
            let mut answers = Answers::default();
            let movement = Default::default();
            answers.add(
                &Reported {
                    status: Status::Good,
                    frequency,
                    sigma: 1e-3,
                    half_width: 2e-3,
                    second,
                    movement,
                },
                &window,
            );
            (
                answers.second,
                answers.unnamed.expect("two tones"),
                answers.wrong,
            )
        };
        assert_eq!(reported(0.03, Some(0.0505)), (1, 0, 0));
        assert_eq!(reported(0.05, Some(0.03)), (1, 0, 0));
        assert_eq!(reported(0.03, Some(0.04)), (0, 1, 0));
        assert_eq!(reported(0.0301, None), (0, 1, 0));
        // Between both.
        assert_eq!(reported(0.04, None), (0, 1, 1));
    }
}
