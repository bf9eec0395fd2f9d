//! Errors of wavelengths: the firmware's, those of the paper's method, and the bound.

use super::motion::{Motion, SETTLES_S};
use super::paper::{CYCLES, WINDOW_S};
use super::run::{Answer, FELT_LATE_S, Slid, conversion_s};
use crate::bound::{Clue, orthonormal};
use crate::simulated::converter_noise_v;
use anyhow::{Context, Result};
use nalgebra::{DMatrix, DVector};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Span, Status};
use std::f64::consts::TAU;

/// Normal deviate that is exceeded in 5 % of all cases, either sign.
const NINETY_FIVE: f64 = 1.959_964;
/// What amplitudes are taken from: away from the slide's ends and from turns, where friction builds
/// up by millivolts.
const SETTLED_S: f64 = 0.03;
const SLIDING_MM_S: f64 = 20.0;
/// Errors of wavelengths, as shares of the true one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Windows of at least [`CYCLES`] cycles, and those of them that are `good`.
    pub windows: usize,
    pub good: usize,
    /// Sums of squares over the good ones: of the errors, of the errors over their own standard
    /// deviations, and of the bounds.
    squares: f64,
    over_sigma: f64,
    bounds: f64,
    /// Good ones whose interval of 95 % holds the truth.
    held: usize,
    /// Good windows, of any number of cycles, that are off by more than 5 % and five standard
    /// deviations.
    pub wrong: usize,
}

impl Errors {
    fn root_mean(&self, sum: f64) -> Option<f64> {
        (self.good > 0).then(|| (sum / self.good as f64).sqrt())
    }

    pub fn rms(&self) -> Option<f64> {
        self.root_mean(self.squares)
    }

    pub fn rms_over_sigma(&self) -> Option<f64> {
        self.root_mean(self.over_sigma)
    }

    pub fn bound(&self) -> Option<f64> {
        self.root_mean(self.bounds)
    }

    /// Share of the good ones whose interval of 95 % holds the truth.
    pub fn held_share(&self) -> Option<f64> {
        (self.good > 0).then(|| self.held as f64 / self.good as f64)
    }

    /// Counts the windows of these answers in which the finger turns, or of those in which it does
    /// not.
    pub fn new(slid: &Slid, answers: &[Answer], bound: &Bound, is_turning: bool) -> Self {
        let (motion, wavelength_mm) = (slid.motion, slid.scene.period_mm);
        let mut errors = Self::default();
        for answer in answers.iter().filter(|answer| answer.span == Span::Window) {
            let Answer {
                from_s,
                until_s,
                frequency,
                sigma,
                ..
            } = *answer;
            if motion.turns(from_s - SETTLES_S, until_s) != is_turning {
                continue;
            }
            // Cycles a millimetre, or a second at a speed that is known.
            let wavelength = match motion {
                Motion::Steady(_) => slid.mean_speed_mm_s(from_s, until_s) / frequency,
                Motion::Hand => 1.0 / frequency,
            };
            let (off, own) = (wavelength / wavelength_mm - 1.0, sigma / frequency);
            let is_good = answer.status == Status::Good;
            errors.wrong += usize::from(is_good && off.abs() > 0.05 && off.abs() > 5.0 * own);
            if from_s < 0.0 || motion.range_mm(from_s, until_s) < CYCLES * wavelength_mm {
                continue;
            }
            errors.windows += 1;
            if is_good {
                errors.good += 1;
                errors.squares += off * off;
                errors.over_sigma += (off / own).powi(2);
                errors.bounds += bound.share(motion, from_s, until_s).powi(2);
                errors.held += usize::from(off.abs() <= NINETY_FIVE * own);
            }
        }
        errors
    }
}

/// The Cramer-Rao bound of a scale's wavelength, in white noise of the converter, with offset,
/// slope and both amplitudes of each channel unknown and the places known.
pub struct Bound {
    wavelength_mm: f64,
    /// Cosine and sine of each channel's fundamental forward and backward, volts: friction turns
    /// with the motion.
    waves: Vec<[(f64, f64); 2]>,
}

impl Bound {
    /// With the amplitudes of least squares over the whole slide.
    pub fn new(slid: &Slid) -> Result<Self> {
        let (motion, wavelength_mm) = (slid.motion, slid.scene.period_mm);
        let is_sliding = |t_s: f64| {
            t_s > SETTLED_S
                && t_s < slid.lasts_s - SETTLED_S
                && motion.speed_mm_s(t_s).abs() > SLIDING_MM_S
        };
        let own: Vec<_> = slid
            .frames
            .iter()
            .filter(|(t_s, _)| is_sliding(*t_s))
            .collect();
        let wave = |taxel: usize| {
            // Each taxel has its time in the scan, and the delays of bridge and converter.
            let later_s = taxel as f64 * conversion_s() - FELT_LATE_S;
            let way = |backward: bool| {
                let own = own
                    .iter()
                    .map(|(t_s, values)| (t_s + later_s, values[taxel]));
                let own: Vec<_> = own
                    .filter(|(t_s, _)| motion.is_backward(*t_s) == backward)
                    .collect();
                let turns = |row: usize| TAU * motion.place_mm(own[row].0) / wavelength_mm;
                let columns = DMatrix::from_fn(own.len(), 3, |row, column| match column {
                    0 => 1.0,
                    1 => turns(row).cos(),
                    _ => turns(row).sin(),
                });
                let values = DVector::from_iterator(own.len(), own.iter().map(|(_, value)| *value));
                let factors = (columns.transpose() * &columns)
                    .cholesky()?
                    .solve(&(columns.transpose() * values));
                Some((factors[1], factors[2]))
            };
            let forward = way(false)?;
            Some([forward, way(true).unwrap_or(forward)])
        };
        let waves: Option<Vec<_>> = (0..TAXELS).map(wave).collect();
        Ok(Self {
            wavelength_mm,
            waves: waves.context("a scan too short for three unknowns")?,
        })
    }

    /// The bound of a window, as a share of the wavelength.
    pub fn share(&self, motion: Motion, from_s: f64, until_s: f64) -> f64 {
        1.0 / self.information(motion, from_s, until_s, |_| 0.0).0.sqrt()
    }

    /// By how much the low-pass's dispersion makes a window's wavelength too long, as a share of
    /// it: places count as late by the delay t of slow tones; of one of the frequency w / (2 pi) it
    /// is atan(w t) / w.
    #[cfg(test)]
    pub fn dispersion_share(&self, motion: Motion, from_s: f64, until_s: f64) -> f64 {
        let ahead = |t_s: f64| {
            let angle = TAU * motion.speed_mm_s(t_s) / self.wavelength_mm * super::run::FILTER_S;
            (angle - angle.atan()) / TAU
        };
        let (information, along) = self.information(motion, from_s, until_s, ahead);
        -along / information
    }

    /// The information about the logarithm of the wavenumber, and what a wave that is `ahead` turns
    /// ahead at a time adds to its score.
    fn information(
        &self,
        motion: Motion,
        from_s: f64,
        until_s: f64,
        ahead: impl Fn(f64) -> f64,
    ) -> (f64, f64) {
        let frames = ((until_s - from_s) * f64::from(Plan::HAND.frame_rate_hz())).round() as usize;
        let at_s =
            |frame: usize| from_s + (frame as f64 + 0.5) / frames as f64 * (until_s - from_s);
        let places: Vec<f64> = (0..frames)
            .map(|frame| motion.place_mm(at_s(frame)) / self.wavelength_mm)
            .collect();
        let cos: Vec<f64> = places.iter().map(|turns| (TAU * turns).cos()).collect();
        let sin: Vec<f64> = places.iter().map(|turns| (TAU * turns).sin()).collect();
        let middle = places.iter().sum::<f64>() / frames as f64;
        let nuisance = orthonormal(vec![
            vec![1.0; frames],
            places.clone(),
            cos.clone(),
            sin.clone(),
        ]);
        let backward: Vec<bool> = (0..frames)
            .map(|frame| motion.is_backward(at_s(frame)))
            .collect();
        let (mut information, mut along) = (0.0, 0.0);
        for ways in &self.waves {
            // By a turn.
            let slope = |frame: usize| {
                let (a, b) = ways[usize::from(backward[frame])];
                TAU * (b * cos[frame] - a * sin[frame]) / converter_noise_v(&Plan::HAND)
            };
            let derivative = (0..frames).map(|frame| (places[frame] - middle) * slope(frame));
            let met: Vec<f64> = (0..frames)
                .map(|frame| ahead(at_s(frame)) * slope(frame))
                .collect();
            let clue = Clue::of(derivative.collect(), &met, &nuisance);
            information += clue.information;
            along += clue.score;
        }
        (information, along)
    }
}

/// The paper's method: in windows of 32 ms the speed over the frequency of maximal power, of all
/// channels together. The root mean square of its errors over the windows of at least [`CYCLES`]
/// cycles; over all of them if none has so many, as at a steady speed.
pub fn fft(slid: &Slid) -> Option<f64> {
    let (motion, wavelength_mm) = (slid.motion, slid.scene.period_mm);
    let frames = (WINDOW_S * f64::from(Plan::HAND.frame_rate_hz())).round() as usize;
    // Sums and numbers, of windows of fewer cycles and of the others.
    let mut sums = [(0.0, 0); 2];
    for window in slid.frames.windows(frames).step_by(frames / 2) {
        let [from_s, until_s] = [window[0].0, window[frames - 1].0];
        // Where the finger turns, the speed in the middle says nothing.
        let is_slide = from_s >= 0.0 && until_s <= slid.lasts_s && !motion.turns(from_s, until_s);
        if !is_slide {
            continue;
        }
        let has_cycles = motion.range_mm(from_s, until_s) >= CYCLES * wavelength_mm;
        let power = |bin: usize| -> f64 {
            let of = |taxel: usize| {
                let turned = window.iter().enumerate().map(|(at, (_, values))| {
                    let (sin, cos) = (TAU * (bin * at) as f64 / frames as f64).sin_cos();
                    (values[taxel] * cos, values[taxel] * sin)
                });
                let (re, im) =
                    turned.fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
                re * re + im * im
            };
            (0..TAXELS).map(of).sum()
        };
        let bin = (1..=frames / 2).max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
        let frequency_hz = bin as f64 * f64::from(Plan::HAND.frame_rate_hz()) / frames as f64;
        let found_mm = motion.speed_mm_s(0.5 * (from_s + until_s)).abs() / frequency_hz;
        let (squares, count) = &mut sums[usize::from(has_cycles)];
        *squares += (found_mm / wavelength_mm - 1.0).powi(2);
        *count += 1;
    }
    let (squares, count) = sums.into_iter().rfind(|(_, count)| *count > 0)?;
    Some((squares / f64::from(count)).sqrt())
}
