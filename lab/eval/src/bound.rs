//! The bound: how well any unbiased estimator can know the common frequency of a window.
//!
//! It is the exact Cramer-Rao bound for white Gaussian noise, with everything but the frequency
//! unknown in each channel: offset, slope if wanted, cosine and sine amplitude of every harmonic.
//! Channels share nothing but the frequency, so their information about it adds up: the squared
//! length of the model's derivative by the frequency, less what the other unknowns could explain of
//! it (its projection on their columns), over the variance of the noise. That variance may be
//! unknown as well: it has no information in common with the model's parameters, so the bound stays
//! the same.
//!
//! Weighted by the noise that it meets in a window, this derivative is the error that an estimator
//! on the bound makes there to first order ([`Clue::score`]). It separates the noise of a window
//! from the error of an estimator.
//!
//! Source: S. M. Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory" (1993),
//! sections 3.7 to 3.9 and example 3.14.

use anyhow::{Result, ensure};
use std::f64::consts::TAU;

/// A column of which the others leave less than this share of its length is one of theirs.
const DEPENDENT: f64 = 1e-9;

/// One harmonic of a channel, in the channel's unit: cos x cos(2 pi h f t) + sin x sin(2 pi h f t),
/// t = 0 at the window's centre, half way between its first and its last frame. As a complex
/// amplitude A, of the real part of A exp(2 pi i h f t), it is cos = Re A and sin = -Im A.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonic {
    pub cos: f64,
    pub sin: f64,
}

impl Harmonic {
    /// amplitude x cos(2 pi h f t + phase), phase in radians.
    pub fn polar(amplitude: f64, phase_rad: f64) -> Self {
        Self {
            cos: amplitude * phase_rad.cos(),
            sin: -amplitude * phase_rad.sin(),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Standard deviation of the noise of one frame, in the channel's unit, > 0.
    pub sigma: f64,
    /// The fundamental first. One of zero amplitude says nothing of the frequency but is still
    /// unknown.
    pub harmonics: Vec<Harmonic>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub frames: usize,
    /// Frames per second, > 0.
    pub frame_rate_hz: f64,
    /// Whether each channel has an unknown slope and not only an unknown offset.
    pub slope: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clue {
    /// Fisher information, one over hertz squared.
    pub information: f64,
    /// Derivative of the log-likelihood by the frequency at the truth, for the noise of a window;
    /// one over hertz.
    pub score: f64,
}

impl Clue {
    pub fn sum(clues: &[Self]) -> Self {
        let add = |sum: Self, clue: &Self| Self {
            information: sum.information + clue.information,
            score: sum.score + clue.score,
        };
        clues.iter().fold(Self::default(), add)
    }

    /// What values say of a frequency, if `derivative` is theirs by it and `basis` is unknown: of
    /// white noise of variance one.
    pub fn of(mut derivative: Vec<f64>, values: &[f64], basis: &[Vec<f64>]) -> Self {
        let whole = length(&derivative);
        remove(&mut derivative, basis);
        let remainder = length(&derivative);
        // A remainder of the size of rounding is no information.
        if remainder <= DEPENDENT * whole {
            return Self::default();
        }
        Self {
            information: remainder.powi(2),
            score: derivative
                .iter()
                .zip(values)
                .map(|(part, value)| part * value)
                .sum(),
        }
    }

    /// The bound, hertz; infinite where there is no information.
    pub fn sigma_hz(&self) -> f64 {
        1.0 / self.information.sqrt()
    }

    /// The error that an estimator on the bound makes in this very window, to first order, hertz.
    pub fn error_hz(&self) -> f64 {
        self.score / self.information
    }
}

/// The information of each channel about a frequency that is truly `frequency_hz`. `value(channel,
/// frame)` is what the window holds; offset, slope (where it is unknown) and waves may be in it,
/// for they have nothing in common with what is left of the derivative.
pub fn clues(
    window: &Window,
    frequency_hz: f64,
    channels: &[Channel],
    value: &dyn Fn(usize, usize) -> f64,
) -> Result<Vec<Clue>> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    ensure!(
        positive(window.frame_rate_hz),
        "frame rate {} Hz: must be greater than 0",
        window.frame_rate_hz
    );
    ensure!(
        positive(frequency_hz),
        "frequency {frequency_hz} Hz: must be greater than 0"
    );
    let mut columns: Option<Columns> = None;
    let mut clues = Vec::new();
    for (number, channel) in channels.iter().enumerate() {
        ensure!(
            positive(channel.sigma),
            "channel {number}: sigma {}: must be greater than 0",
            channel.sigma
        );
        let finite = channel
            .harmonics
            .iter()
            .all(|h| h.cos.is_finite() && h.sin.is_finite());
        ensure!(finite, "channel {number}: an amplitude is not finite");
        let harmonics = channel.harmonics.len();
        // Most channels share them with the one before.
        let columns = match &mut columns {
            Some(same) if same.waves.len() == harmonics => same,
            other => other.insert(Columns::new(window, frequency_hz, harmonics)),
        };
        clues.push(columns.clue(channel, &|frame| value(number, frame)));
    }
    Ok(clues)
}

/// The model's columns, the same for channels with the same number of harmonics.
struct Columns {
    /// Seconds from the window's centre.
    times_s: Vec<f64>,
    /// Cosine and sine of each harmonic.
    waves: Vec<[Vec<f64>; 2]>,
    /// A basis of all unknowns but the frequency.
    nuisance: Vec<Vec<f64>>,
}

impl Columns {
    fn new(window: &Window, frequency_hz: f64, harmonics: usize) -> Self {
        let centre = 0.5 * (window.frames as f64 - 1.0);
        let times_s: Vec<f64> = (0..window.frames)
            .map(|frame| (frame as f64 - centre) / window.frame_rate_hz)
            .collect();
        let wave = |h: usize| {
            let both = times_s
                .iter()
                .map(|t_s| (TAU * h as f64 * frequency_hz * t_s).sin_cos());
            let (sin, cos) = both.unzip();
            [cos, sin]
        };
        let waves: Vec<[Vec<f64>; 2]> = (1..=harmonics).map(wave).collect();
        let mut nuisance = vec![vec![1.0; times_s.len()]];
        if window.slope {
            nuisance.push(times_s.clone());
        }
        nuisance.extend(waves.iter().flatten().cloned());
        Self {
            nuisance: orthonormal(nuisance),
            times_s,
            waves,
        }
    }

    fn clue(&self, channel: &Channel, value: &dyn Fn(usize) -> f64) -> Clue {
        let mut derivative = vec![0.0; self.times_s.len()];
        for ((h, harmonic), [cos, sin]) in (1..).zip(&channel.harmonics).zip(&self.waves) {
            let turn = TAU * f64::from(h);
            for (((sum, t_s), cos), sin) in
                derivative.iter_mut().zip(&self.times_s).zip(cos).zip(sin)
            {
                *sum += turn * t_s * (harmonic.sin * cos - harmonic.cos * sin);
            }
        }
        let values: Vec<f64> = (0..derivative.len()).map(value).collect();
        let clue = Clue::of(derivative, &values, &self.nuisance);
        let variance = channel.sigma.powi(2);
        Clue {
            information: clue.information / variance,
            score: clue.score / variance,
        }
    }
}

/// Columns of unit length at right angles to each other that span what `columns` span (Gram and
/// Schmidt).
pub fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let whole = length(&column);
        remove(&mut column, &basis);
        let remainder = length(&column);
        if remainder > DEPENDENT * whole {
            column.iter_mut().for_each(|value| *value /= remainder);
            basis.push(column);
        }
    }
    basis
}

/// Takes off `column` what it has in common with `basis`. Twice: once leaves rounding of the size
/// of what was taken.
pub fn remove(column: &mut [f64], basis: &[Vec<f64>]) {
    for _ in 0..2 {
        for unit in basis {
            let common: f64 = unit.iter().zip(&*column).map(|(a, b)| a * b).sum();
            column
                .iter_mut()
                .zip(unit)
                .for_each(|(value, unit)| *value -= common * unit);
        }
    }
}

fn length(column: &[f64]) -> f64 {
    column.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
