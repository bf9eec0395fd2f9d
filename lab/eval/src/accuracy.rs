//! Many estimates against the truth and against the bound.
//!
//! The mean square error of a few hundred windows has an error of its own, 1 / sqrt(2 n) of the
//! root for Gaussian errors, mostly because some draws of the noise are unluckier than others. The
//! error of an estimator on the bound in the same draw is known, and its mean square is exactly the
//! bound's. It serves as a control variate: the part of the squares that is correlated with it is
//! subtracted. For an estimator near the bound little noise remains.

use serde::{Deserialize, Serialize};

/// Normal deviate that is exceeded in 5 % of all cases, either sign.
pub const NINETY_FIVE: f64 = 1.959_964;
/// An estimate this near a multiple or a fraction of the truth is taken for it.
const OCTAVE_WITHIN: f64 = 0.1;
/// Greatest multiple that is looked for.
const OCTAVE_MAX: u32 = 5;
/// Share of windows that must have been answered for the control variate's mean to be what theory
/// says.
const ANSWERED: f64 = 0.99;
/// Fewest windows from which a regression is worth anything.
const REGRESSED: usize = 10;
/// Share of good windows below which the error is that of all that are answered: few cycles are
/// ambiguous, and right.
const GOOD: f64 = 0.5;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    pub hz: f64,
    /// The estimator's own standard deviation, hertz.
    pub sigma_hz: Option<f64>,
    /// The estimator reports that another line may be the fundamental, or that the tone moves.
    pub ambiguous: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub true_hz: f64,
    pub bound_hz: f64,
    /// The error of an estimator on the bound in this very window, hertz.
    pub luck_hz: f64,
    pub answer: Option<Answer>,
}

/// The accuracy over many windows of one setting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    pub windows: u32,
    /// Those with a single frequency.
    pub good: u32,
    /// Those that are reported as ambiguous or unsteady.
    pub ambiguous: u32,
    /// Good ones at a multiple or a fraction of the truth.
    pub octaves: u32,
    /// Good ones whose 95 % interval holds the truth.
    pub covered: u32,
    /// The good ones' error, that of all answers if less than half of the windows are good. None
    /// without any.
    pub error: Option<Error>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Error {
    pub rms_hz: f64,
    /// RMS, percent of the true frequency.
    pub rms_percent: f64,
    pub bound_percent: f64,
    pub ratio: f64,
    pub ratio_sigma: f64,
}

impl Accuracy {
    pub fn new(samples: &[Sample]) -> Self {
        let answered = || {
            samples
                .iter()
                .filter_map(|sample| Some((sample, sample.answer?)))
        };
        let good: Vec<(&Sample, Answer)> =
            answered().filter(|(_, answer)| !answer.ambiguous).collect();
        let count = |what: &dyn Fn(&Sample, &Answer) -> bool| {
            good.iter()
                .filter(|(sample, answer)| what(sample, answer))
                .count() as u32
        };
        let all: Vec<(&Sample, Answer)> = answered().collect();
        let judged = if good.len() as f64 >= GOOD * samples.len() as f64 {
            &good
        } else {
            &all
        };
        Self {
            windows: samples.len() as u32,
            good: good.len() as u32,
            ambiguous: (all.len() - good.len()) as u32,
            octaves: count(&|sample, answer| is_octave(answer.hz / sample.true_hz)),
            covered: count(&|sample, answer| {
                answer.sigma_hz.is_some_and(|sigma_hz| {
                    (answer.hz - sample.true_hz).abs() <= NINETY_FIVE * sigma_hz
                })
            }),
            error: error(
                judged,
                judged.len() as f64 >= ANSWERED * samples.len() as f64,
            ),
        }
    }
}

fn error(good: &[(&Sample, Answer)], control: bool) -> Option<Error> {
    if good.is_empty() {
        return None;
    }
    // In units of `unit`: squares of the errors, and how much the luck's square is above its mean.
    let mean_square = |unit: &dyn Fn(&Sample) -> f64| {
        let pairs = good.iter().map(|(sample, answer)| {
            let share = |hz: f64| (hz / unit(sample)).powi(2);
            (
                share(answer.hz - sample.true_hz),
                share(sample.luck_hz) - share(sample.bound_hz),
            )
        });
        mean(&pairs.collect::<Vec<_>>(), control)
    };
    let (square, sigma) = mean_square(&|sample| sample.bound_hz);
    let bound = good
        .iter()
        .map(|(sample, _)| (sample.bound_hz / sample.true_hz).powi(2))
        .sum::<f64>();
    let ratio = square.sqrt();
    Some(Error {
        rms_hz: rounded(mean_square(&|_| 1.0).0.sqrt()),
        rms_percent: rounded(100.0 * mean_square(&|sample| sample.true_hz).0.sqrt()),
        bound_percent: rounded(100.0 * (bound / good.len() as f64).sqrt()),
        ratio: rounded(ratio),
        ratio_sigma: rounded(0.5 * sigma / ratio),
    })
}

/// Mean and its standard error of the first of each pair, less what it has in common with the
/// second, whose true mean is zero.
fn mean(pairs: &[(f64, f64)], control: bool) -> (f64, f64) {
    let n = pairs.len() as f64;
    let (mean, mean_control) = pairs
        .iter()
        .fold((0.0, 0.0), |(a, b), pair| (a + pair.0 / n, b + pair.1 / n));
    let sum = |product: &dyn Fn(f64, f64) -> f64| -> f64 {
        pairs
            .iter()
            .map(|(value, control)| product(value - mean, control - mean_control))
            .sum()
    };
    let (common, own) = (sum(&|a, b| a * b), sum(&|_, b| b * b));
    // A control that is always the same, but for rounding, says nothing.
    let varies = own > 1e-9 * n * mean_control.powi(2);
    let slope = if control && varies && pairs.len() >= REGRESSED {
        common / own
    } else {
        0.0
    };
    let controlled = mean - slope * mean_control;
    // A few wild values can turn the regression about.
    let (value, slope) = if controlled > 0.0 {
        (controlled, slope)
    } else {
        (mean, 0.0)
    };
    let residual = sum(&|a, b| (a - slope * b).powi(2));
    (value, (residual / (n * (n - 2.0).max(1.0))).sqrt())
}

/// Whether an estimate of `times` times the truth is a multiple or a fraction of it.
fn is_octave(times: f64) -> bool {
    (2..=OCTAVE_MAX).map(f64::from).any(|multiple| {
        let near = |times: f64| (times / multiple - 1.0).abs() <= OCTAVE_WITHIN;
        near(times) || near(1.0 / times)
    })
}

/// Four significant digits; the noise hides the others.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(error_hz: f64, luck_hz: f64) -> Sample {
        let answer = Some(Answer {
            hz: 10.0 + error_hz,
            sigma_hz: Some(0.1),
            ambiguous: false,
        });
        Sample {
            true_hz: 10.0,
            bound_hz: 0.1,
            luck_hz,
            answer,
        }
    }

    #[test]
    fn an_error_twice_the_luck_is_twice_the_bound_however_few_windows() {
        let samples: Vec<Sample> = (0..20)
            .map(|n| 0.02 * f64::from(n - 7))
            .map(|luck| sample(2.0 * luck, luck))
            .collect();
        let error = Accuracy::new(&samples).error.expect("an error");
        assert!(
            (error.ratio - 2.0).abs() < 1e-9 && error.ratio_sigma < 1e-6,
            "{error:?}"
        );
        assert!(
            (error.rms_percent - 2.0).abs() < 1e-9 && (error.rms_hz - 0.2).abs() < 1e-9,
            "{error:?}"
        );
        assert_eq!(error.bound_percent, 1.0);
    }

    #[test]
    fn an_error_that_has_nothing_to_do_with_luck_is_its_plain_mean() {
        let samples: Vec<Sample> = (0..400)
            .map(|n| {
                sample(
                    if n % 2 == 0 { 0.3 } else { 0.1 },
                    0.1 * f64::from(n / 2 % 2),
                )
            })
            .collect();
        let error = Accuracy::new(&samples).error.expect("an error");
        assert!((error.rms_hz - 0.05f64.sqrt()).abs() < 1e-4, "{error:?}");
        // Squares of 9 and 1 bounds: standard deviation 4 of the mean 5.
        assert!(
            (error.ratio_sigma / (0.5 * 4.0 / 20.0 / 5f64.sqrt()) - 1.0).abs() < 0.01,
            "{error:?}"
        );
    }

    #[test]
    fn octaves_ambiguity_and_silence_are_counted() {
        let mut samples = vec![
            sample(0.0, 0.0),
            sample(10.2, 0.0),
            sample(-6.7, 0.0),
            sample(0.15, 0.0),
            sample(3.0, 0.0),
        ];
        samples.push(Sample {
            answer: None,
            ..samples[0]
        });
        let mut open = samples[1];
        open.answer = open.answer.map(|answer| Answer {
            ambiguous: true,
            ..answer
        });
        samples.push(open);
        let accuracy = Accuracy::new(&samples);
        let Accuracy {
            windows,
            good,
            ambiguous,
            octaves,
            covered,
            ..
        } = accuracy;
        assert_eq!(
            (windows, good, ambiguous, octaves, covered),
            (7, 5, 1, 2, 2)
        );
        assert_eq!(Accuracy::new(&[]).error, None);
        // Where most are ambiguous their error counts too.
        let few = Accuracy::new(&[samples[0], open, open]);
        assert!(
            few.good == 1 && few.octaves == 0 && few.error.is_some_and(|error| error.rms_hz > 5.0),
            "{few:?}"
        );
    }
}
