//! The estimator's answers to many windows of a cell.

use super::window::{Recipe, Window};
use crate::draw::Draw;
use crate::trade::accuracy::NINETY_FIVE;
use anyhow::{Context, Result};
use ridgetone_host::input::frame_rate_hz;
use ridgetone_tone::{Fit, Fitter, FrameSpan, Status, Table};
use serde::{Deserialize, Serialize};

/// Harmonics that the fit may use.
const HARMONICS: u8 = 4;
/// A good answer off by more than this share is wrong.
const WRONG: f64 = 0.05;

/// Answers to the windows of a cell, by what they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    pub windows: u32,
    pub good: u32,
    pub ambiguous: u32,
    /// Good ones off by more than 5 %, or where there is no tone.
    pub wrong: u32,
    /// Good ones whose 95 % interval holds the mean frequency.
    pub covered: u32,
    /// Good ones whose 95 % interval holds the mean weighted by a parabola.
    pub covered_weighted: u32,
    /// Sum over the good ones that are not wrong of (error / sigma)^2.
    pub squares: f64,
}

impl Answers {
    fn add(&mut self, fit: &Fit, window: &Window) {
        self.windows += 1;
        self.ambiguous += u32::from(fit.status == Status::Ambiguous);
        if fit.status != Status::Good {
            return;
        }
        self.good += 1;
        let (Some(mean), Some(weighted)) = (window.mean, window.weighted) else {
            self.wrong += 1;
            return;
        };
        let (frequency, sigma) = (f64::from(fit.frequency), f64::from(fit.sigma));
        let holds = |truth: f64| u32::from((frequency - truth).abs() <= NINETY_FIVE * sigma);
        self.covered += holds(mean);
        self.covered_weighted += holds(weighted);
        if (frequency / mean - 1.0).abs() > WRONG {
            self.wrong += 1;
        } else {
            self.squares += ((frequency - mean) / sigma).powi(2);
        }
    }

    /// RMS of the error over sigma; none without a good answer that is not wrong.
    pub fn error_in_sigmas(&self) -> Option<f64> {
        let count = self.good - self.wrong;
        (count > 0).then(|| (self.squares / f64::from(count)).sqrt())
    }
}

/// A share in percent; 0 of none.
pub fn percent(count: u32, of: u32) -> f64 {
    100.0 * f64::from(count) / f64::from(of.max(1))
}

/// The answers to so many windows of `window_s` seconds. Equal seeds give equal windows.
pub fn measure(recipe: &Recipe, window_s: f64, windows: u32, seed: u64) -> Result<Answers> {
    let mut answers = Answers::default();
    let rate_hz = frame_rate_hz();
    let frames = (window_s * rate_hz).round() as usize;
    let mut fitter = Box::new(Fitter::new(HARMONICS));
    for number in 0..u64::from(windows) {
        let window = recipe.make(frames, rate_hz, &mut Draw::new(seed.wrapping_mul(1_000_003).wrapping_add(number)));
        let valid = vec![u16::MAX; frames];
        let mut table = Table { values: &window.values, valid: &valid };
        let mut span = FrameSpan::new(&mut table, 0, frames as u32).with_quantization(window.step);
        answers.add(&fitter.fit(&mut span).context("a table loses no frames")?, &window);
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use super::super::process::Noise;
    use super::super::window::{Extra, Speed, Tone};
    use super::*;

    /// In white noise the estimator is on its bound: what this counts is known from the trade.
    #[test]
    fn answers_in_white_noise_are_good_and_their_intervals_hold() {
        let tone =
            Tone { cycles: (4.0, 12.0), harmonics: [1.0, 0.4, 0.2, 0.1, 0.0], snr_db: 20.0, speed: Speed::Steady };
        let recipe = Recipe { noise: Noise::White, tone: Some(tone), extra: Extra::Nothing };
        let answers = measure(&recipe, 1.0, 40, 7).expect("answers");
        assert_eq!((answers.windows, answers.good, answers.wrong), (40, 40, 0), "{answers:?}");
        assert!(answers.covered >= 34 && answers.covered_weighted == answers.covered, "{answers:?}");
        assert!((0.7..1.3).contains(&answers.error_in_sigmas().expect("errors")), "{answers:?}");
        assert_eq!(measure(&recipe, 1.0, 40, 7).expect("answers"), answers, "equal seeds");
        assert_ne!(measure(&recipe, 1.0, 40, 8).expect("answers").squares, answers.squares, "other seeds");
        let none = measure(&Recipe { tone: None, ..recipe }, 1.0, 40, 7).expect("answers");
        assert_eq!((none.good, none.wrong), (0, 0), "{none:?}");
    }
}
