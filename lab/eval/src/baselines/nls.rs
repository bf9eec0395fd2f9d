//! Harmonic nonlinear least squares over all channels, in f64, with a sandwich sigma: what somebody
//! who knows statistics and has a PC would write. It is the honest opponent, and it is not for the
//! chip.
//!
//! Each channel has a level, a slope and its own amplitudes of the harmonics of one frequency. The
//! likelihood is Gaussian with an unknown variance in each channel. Its maximum: candidates from
//! the periodogram summed over channels and harmonics, and from an even grid where there are few
//! cycles; then Gauss-Newton steps on the frequency with all other unknowns solved for, each
//! channel weighted by its residuals' variance. Sources: Quinn and Thomson, "Estimating the
//! frequency of a periodic function", Biometrika 78 (1991); Nielsen et al., "Fast fundamental
//! frequency estimation: making a statistically efficient estimator computationally efficient",
//! Signal Processing 135 (2017).
//!
//! The number of harmonics is that of the least Bayesian information criterion (Stoica and Selen,
//! "Model-order selection", IEEE Signal Process. Mag. 21(4), 2004); none of them is no tone. The
//! sigma takes each channel as a cluster (Liang and Zeger, Biometrika 73, 1986): it holds whatever
//! the noise's colour in a channel is, as long as channels are independent.

use super::samples::{CHANNELS, Frame};
use crate::bound::{orthonormal, remove};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Points of the periodogram for each Fourier line.
const PADDING: usize = 4;
/// Fewest cycles in the window, and up to where the sum of the periodogram's lines says little, for
/// they overlap.
const FEW_CYCLES: (f64, f64) = (0.5, 2.0);
/// Step of the grid between these, cycles.
const FEW_STEP: f64 = 0.125;
/// The highest places of a number of harmonics whose likelihood is computed, and those of them that
/// are refined.
const CANDIDATES: usize = 4;
const REFINED: usize = 4;
/// Most steps, most halvings of a step, and the last step's length, cycles per window.
const STEPS: usize = 20;
const HALVINGS: usize = 8;
const ENOUGH: f64 = 1e-8;

/// Student's t that is exceeded in 5 % of all cases, either sign, by degrees of freedom from 1 on.
const STUDENT_95: [f64; CHANNELS - 1] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131,
];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Cycles per frame.
    pub frequency: f64,
    /// Its standard deviation, by the scatter of the channels; of a single channel, by its
    /// residuals.
    pub sigma: f64,
    /// Standard deviation if the noise is white.
    pub sigma_white: f64,
    /// Half of the 95 % interval.
    pub half_width: f64,
    pub harmonics: usize,
}

/// The tone of the first `channels` channels with up to `harmonics` harmonics; none if the
/// criterion prefers no tone. A known interferer, cycles per frame, is in all channels.
pub fn estimate(
    values: &[Frame],
    channels: usize,
    harmonics: usize,
    interferer: Option<f64>,
) -> Option<Estimate> {
    let window = Window::new(values, channels.min(CHANNELS), interferer)?;
    let power = window.periodogram();
    let best = (1..=harmonics).filter_map(|harmonics| window.best(harmonics, &power));
    let best = best.min_by(|a, b| a.criterion.total_cmp(&b.criterion))?;
    (best.criterion < window.criterion).then(|| best.estimate())
}

struct Window {
    frames: usize,
    /// Frames from the window's middle.
    places: Vec<f64>,
    /// What is no tone in each channel: level, slope, an interferer. Of unit length, at right
    /// angles to each other.
    base: Vec<Vec<f64>>,
    /// The channels less their part in it, of mean square one.
    signals: Vec<Vec<f64>>,
    /// The criterion without a tone.
    criterion: f64,
}

/// The tone of a frequency, all other unknowns solved for.
struct Solution {
    frequency: f64,
    frames: usize,
    harmonics: usize,
    criterion: f64,
    /// By channel, in units of its variance: slope of the log-likelihood over the frequency,
    /// and information.
    slopes: Vec<f64>,
    information: f64,
}

impl Window {
    /// None without a channel that varies.
    fn new(values: &[Frame], channels: usize, interferer: Option<f64>) -> Option<Self> {
        let frames = values.len();
        let places: Vec<f64> = (0..frames)
            .map(|n| n as f64 - 0.5 * (frames as f64 - 1.0))
            .collect();
        let mut base = vec![vec![1.0; frames], places.clone()];
        base.extend(
            interferer
                .into_iter()
                .flat_map(|frequency| waves(&places, frequency)),
        );
        let base = orthonormal(base);
        let signal = |c: usize| {
            // Values less the first: the differences of codes are exact.
            let mut signal: Vec<f64> = values
                .iter()
                .map(|frame| f64::from(frame[c]) - f64::from(values[0][c]))
                .collect();
            let whole = dot(&signal, &signal);
            remove(&mut signal, &base);
            let scale = (dot(&signal, &signal) / frames as f64).sqrt();
            signal.iter_mut().for_each(|value| *value /= scale);
            (scale.powi(2) * frames as f64 > 1e-20 * whole && scale.is_finite()).then_some(signal)
        };
        let signals: Vec<Vec<f64>> = (0..channels).filter_map(signal).collect();
        let criterion = (frames * signals.len()) as f64 * (frames as f64).ln();
        (!signals.is_empty()).then_some(Self {
            frames,
            places,
            base,
            signals,
            criterion,
        })
    }

    /// The power of all channels, by frequency from zero on.
    fn periodogram(&self) -> Vec<f64> {
        // Channels side by side: what is summed for all of them at once takes a tenth of the time.
        let column =
            |n: usize| std::array::from_fn(|c| self.signals.get(c).map_or(0.0, |signal| signal[n]));
        let frames: Vec<[f64; CHANNELS]> = (0..self.frames).map(column).collect();
        let power = |bin: usize| {
            let (turn_sin, turn_cos) =
                (TAU * bin as f64 / (PADDING * self.frames) as f64).sin_cos();
            let (mut cos, mut sin) = (1.0, 0.0);
            let (mut along_cos, mut along_sin) = ([0.0; CHANNELS], [0.0; CHANNELS]);
            for frame in &frames {
                for c in 0..CHANNELS {
                    along_cos[c] += cos * frame[c];
                    along_sin[c] += sin * frame[c];
                }
                (cos, sin) = (
                    cos * turn_cos - sin * turn_sin,
                    sin * turn_cos + cos * turn_sin,
                );
            }
            along_cos
                .iter()
                .chain(&along_sin)
                .map(|along| along * along)
                .sum()
        };
        (0..PADDING * self.frames / 2).map(power).collect()
    }

    /// The best tone of `harmonics` harmonics.
    fn best(&self, harmonics: usize, power: &[f64]) -> Option<Solution> {
        let cycles = |cycles: f64| cycles / self.frames as f64;
        let sum = |bin: usize| {
            (1..=harmonics)
                .filter_map(|h| power.get(h * bin))
                .sum::<f64>()
        };
        let last = (power.len() - 1) / harmonics;
        let first = (FEW_CYCLES.0 * PADDING as f64) as usize;
        let mut peaks: Vec<(f64, usize)> = (first..last)
            .filter(|bin| sum(*bin) >= sum(bin - 1) && sum(*bin) > sum(bin + 1))
            .map(|bin| (sum(bin), bin))
            .collect();
        peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
        let peaks = peaks
            .iter()
            .take(CANDIDATES)
            .map(|(_, bin)| cycles(*bin as f64 / PADDING as f64));
        let few = (0..=((FEW_CYCLES.1 - FEW_CYCLES.0) / FEW_STEP) as usize)
            .map(|n| FEW_CYCLES.0 + FEW_STEP * n as f64);
        let places = peaks
            .chain(few.map(cycles))
            .filter(|frequency| harmonics as f64 * frequency < 0.5);
        let mut solutions: Vec<Solution> = places
            .filter_map(|place| self.solve(place, harmonics))
            .collect();
        solutions.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        let mut starts: Vec<Solution> = Vec::new();
        for solution in solutions {
            // One start on each summit.
            let is_new =
                |start: &Solution| (start.frequency - solution.frequency).abs() > cycles(0.3);
            if starts.len() < REFINED && starts.iter().all(is_new) {
                starts.push(solution);
            }
        }
        let refined = starts.into_iter().map(|start| self.refine(start));
        refined.min_by(|a, b| a.criterion.total_cmp(&b.criterion))
    }

    /// Gauss-Newton steps, each halved until the criterion falls.
    fn refine(&self, mut at: Solution) -> Solution {
        let (least, enough) = (
            FEW_CYCLES.0 / self.frames as f64,
            ENOUGH / self.frames as f64,
        );
        for _ in 0..STEPS {
            // Farther than a quarter of a line is on another summit.
            let most = 0.25 / self.frames as f64;
            let step = (at.slopes.iter().sum::<f64>() / at.information).clamp(-most, most);
            let places =
                (0..HALVINGS).map(|halving| at.frequency + step * 0.5f64.powi(halving as i32));
            let inside =
                places.filter(|place| *place >= least && *place * (at.harmonics as f64) < 0.5);
            let mut solutions = inside.filter_map(|place| self.solve(place, at.harmonics));
            let Some(better) = solutions.find(|next| next.criterion < at.criterion) else {
                return at;
            };
            at = better;
            if step.abs() < enough {
                return at;
            }
        }
        at
    }

    /// None where the waves cannot be separated.
    fn solve(&self, frequency: f64, harmonics: usize) -> Option<Solution> {
        // Waves, and behind them the waves times place: the derivative by the frequency is a sum of
        // the latter.
        let mut columns: Vec<Vec<f64>> = (1..=harmonics)
            .flat_map(|h| waves(&self.places, h as f64 * frequency))
            .collect();
        for wave in 0..2 * harmonics {
            columns.push(
                columns[wave]
                    .iter()
                    .zip(&self.places)
                    .map(|(value, place)| value * place)
                    .collect(),
            );
        }
        columns
            .iter_mut()
            .for_each(|column| remove(column, &self.base));
        let count = 2 * harmonics;
        let products = DMatrix::from_fn(2 * count, count, |i, j| dot(&columns[i], &columns[j]));
        let [own, cross] = [products.rows(0, count), products.rows(count, count)];
        let factors = own.into_owned().cholesky()?;
        // What the waves leave of the second half.
        let squares = DMatrix::from_fn(count, count, |i, j| {
            dot(&columns[count + i], &columns[count + j])
        });
        let left = squares - cross * factors.solve(&cross.transpose());
        let freedom = (self.frames - self.base.len())
            .checked_sub(count + 1)
            .filter(|freedom| *freedom > 0)? as f64;
        let frames = self.frames as f64;
        let (mut logarithms, mut slopes, mut information) = (0.0, Vec::new(), 0.0);
        for signal in &self.signals {
            let along = DVector::from_fn(2 * count, |i, _| dot(&columns[i], signal));
            let amplitudes = factors.solve(&along.rows(0, count).into_owned());
            // Rounding is left of a tone without noise.
            let residual = (frames - amplitudes.dot(&along.rows(0, count))).max(1e-13 * frames);
            // The derivative turns cos into -sin and sin into cos, h times as fast.
            let turned = DVector::from_fn(count, |i, _| {
                let turn = TAU * (i / 2 + 1) as f64;
                if i % 2 == 0 {
                    turn * amplitudes[i + 1]
                } else {
                    -turn * amplitudes[i - 1]
                }
            });
            let weight = freedom / residual;
            slopes.push(weight * turned.dot(&(along.rows(count, count) - cross * &amplitudes)));
            information += weight * turned.dot(&(&left * &turned));
            logarithms += frames * residual.ln();
        }
        let unknowns = (count * self.signals.len() + 3) as f64;
        let criterion = logarithms + unknowns * frames.ln();
        let solution = Solution {
            frequency,
            frames: self.frames,
            harmonics,
            criterion,
            slopes,
            information,
        };
        (information > 0.0 && criterion.is_finite()).then_some(solution)
    }
}

impl Solution {
    fn estimate(&self) -> Estimate {
        let Self {
            frequency,
            harmonics,
            information,
            ref slopes,
            ..
        } = *self;
        let (count, sigma_white) = (slopes.len(), 1.0 / information.sqrt());
        let scatter: f64 = slopes.iter().map(|slope| slope.powi(2)).sum();
        let (sigma, times) = match STUDENT_95.get(count.wrapping_sub(2)) {
            Some(student) => (
                (scatter * count as f64 / (count as f64 - 1.0)).sqrt() / information,
                *student,
            ),
            None => (sigma_white, 1.96),
        };
        // No sandwich is thinner than the last digit of its frequency.
        let sigma = sigma.max(1e-12 / self.frames as f64);
        Estimate {
            frequency,
            sigma,
            sigma_white,
            half_width: times * sigma,
            harmonics,
        }
    }
}

/// Cosine and sine, of `frequency` cycles per frame.
fn waves(places: &[f64], frequency: f64) -> [Vec<f64>; 2] {
    let (sin, cos) = places
        .iter()
        .map(|place| (TAU * frequency * place).sin_cos())
        .unzip();
    [cos, sin]
}

/// Eight sums at a time: a single one waits for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((eights_a, rest_a), (eights_b, rest_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in eights_a.iter().zip(eights_b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f64>()
}
