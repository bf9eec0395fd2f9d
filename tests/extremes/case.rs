//! A window, its fit, and the comparison with an f64 reference.

use crate::reference::{Baseline, Likelihood};
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status, Table};
use std::ops::Range;

/// Maximum error of a fit, in standard deviations of the f64 reference.
pub const OFF_MAX: f64 = 4.5;
/// Accepted ratio of a fit's sigma to that of the f64 reference. The reference knows the noise; the
/// fit estimates it from a few bins next to the lines.
const SURE: Range<f64> = 0.5..2.2;
/// Accepted ratio averaged over many windows: allowing for a varying speed costs up to a fifth in
/// white noise.
const SURE_MEAN: Range<f64> = 0.9..1.35;

#[derive(Clone)]
pub struct Case {
    pub values: Vec<[f32; 16]>,
    pub valid: Vec<u16>,
    /// Maximum number of harmonics of the fit.
    pub harmonics: u8,
    /// Cycles per frame of a known interferer.
    pub interferer: Option<f32>,
    /// Step of the values' rounding.
    pub step: f32,
}

impl Case {
    /// Creates a case with all frames valid and up to four harmonics.
    pub fn new(values: Vec<[f32; 16]>) -> Self {
        Self {
            valid: vec![u16::MAX; values.len()],
            values,
            harmonics: 4,
            interferer: None,
            step: 1.0,
        }
    }

    pub fn fit(&self) -> Fit {
        let mut table = Table {
            values: &self.values,
            valid: &self.valid,
        };
        let mut span =
            FrameSpan::new(&mut table, 0, self.values.len() as u32).with_quantization(self.step);
        if let Some(cycles) = self.interferer {
            span = span.with_interferer(cycles);
        }
        let fit = Fitter::new()
            .fit(&mut span, &Scene::with_harmonics(self.harmonics))
            .unwrap();
        assert_finite(&fit);
        fit
    }

    /// Returns the error of a fit in standard deviations of the f64 reference, and the ratio of
    /// their sigmas. A fit does not report its baseline, so the nearest of four references counts.
    pub fn off(&self, fit: &Fit, truth: f64) -> (f64, f64) {
        self.off_at_least(fit, truth, 0.0)
    }

    /// Like [`off`](Self::off), but uses a standard deviation of at least `min`.
    pub fn off_at_least(&self, fit: &Fit, truth: f64, min: f64) -> (f64, f64) {
        // Taxels that are invalid in more than a tenth of the frames do not exclude frames.
        let some = self.valid.iter().filter(|valid| **valid != 0);
        let fraction = |c: usize| {
            some.clone().filter(|valid| **valid & 1 << c == 0).count() * 10 <= some.clone().count()
        };
        let taxels = (0..16)
            .filter(|c| fraction(*c))
            .fold(0, |mask, c| mask | 1 << c);
        let mut nearest = (f64::MAX, 0.0);
        for baseline in [
            Baseline::Line,
            Baseline::Polynomial(2),
            Baseline::Polynomial(3),
            Baseline::Polynomial(4),
        ] {
            let mut likelihood = Likelihood::new(&self.values, fit.harmonics as usize, baseline);
            likelihood.interferer = self.interferer.map(f64::from);
            let likelihood = likelihood.only(fit.usable, &self.valid, taxels);
            let sigma = likelihood.sigma(truth).max(min);
            let off = (fit.frequency as f64 - truth).abs() / sigma;
            let sure = fit.sigma as f64 / sigma;
            // Both values agree, so this is the baseline that was fitted.
            if off < OFF_MAX && SURE.contains(&sure) {
                return (off, sure);
            }
            if off < nearest.0 {
                nearest = (off, sure);
            }
        }
        nearest
    }

    /// Fits the window and asserts that the fit is good and right, and that its sigma agrees with
    /// the f64 reference.
    #[track_caller]
    pub fn assert_good(&self, what: &str, truth: f64) -> Fit {
        let fit = self.fit();
        assert_eq!(fit.status, Status::Good, "{what}: {fit:?}");
        self.assert_right_and_sure(what, &fit, truth);
        fit
    }

    /// Asserts that a fit's frequency is right. Does not check sigma, which means nothing where the
    /// model is wrong.
    #[track_caller]
    pub fn assert_right(&self, what: &str, fit: &Fit, truth: f64) {
        let (off, _) = self.off(fit, truth);
        assert!(
            off < OFF_MAX,
            "{what}: {off:.3} sigma from the truth, {truth}: {fit:?}"
        );
    }

    /// Asserts that a fit is right and that its sigma agrees with the f64 reference.
    #[track_caller]
    pub fn assert_right_and_sure(&self, what: &str, fit: &Fit, truth: f64) {
        self.assert_right(what, fit, truth);
        let (_, sure) = self.off(fit, truth);
        assert!(
            SURE.contains(&sure),
            "{what}: sigma is {sure:.3} of f64's: {fit:?}"
        );
    }
}

/// Good fits of many windows, whose sigmas are judged together.
#[derive(Default)]
pub struct GoodFits(Vec<f64>);

impl GoodFits {
    /// Asserts that another window's fit is good and right, and adds it.
    #[track_caller]
    pub fn add(&mut self, case: &Case, what: &str, truth: f64) -> Fit {
        let fit = case.assert_good(what, truth);
        self.0.push(case.off(&fit, truth).1);
        fit
    }

    /// Asserts that the sigmas agree with the f64 reference on average.
    #[track_caller]
    pub fn assert_sure(&self) {
        let mean = self.0.iter().sum::<f64>() / self.0.len() as f64;
        assert!(
            SURE_MEAN.contains(&mean),
            "sigma is {mean:.3} of f64's in the mean over {} windows",
            self.0.len()
        );
    }
}

/// Asserts that all numbers in a fit are finite, and that its frequencies make sense.
#[track_caller]
pub fn assert_finite(fit: &Fit) {
    let channels = fit
        .channels
        .iter()
        .flat_map(|c| [c.offset, c.amplitude, c.phase_rad, c.residual]);
    assert!(
        [fit.frequency, fit.sigma]
            .into_iter()
            .chain(channels)
            .all(f32::is_finite),
        "{fit:?}"
    );
    if fit.status.has_tone() {
        assert!(
            fit.frequency > 0.0 && fit.frequency < 0.5 && fit.sigma > 0.0,
            "{fit:?}"
        );
    } else {
        assert_eq!((fit.frequency, fit.sigma), (0.0, 0.0), "{fit:?}");
    }
}
