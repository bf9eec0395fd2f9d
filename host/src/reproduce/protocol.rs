//! The scenes: the paper's ten combinations on the physical finger, and a stimulator as imperfect as the paper's figures
//! say that its was.
//!
//! The paper tells of "precise position control" and gives no figure. What its results give away is used here, and no
//! more than three numbers of it:
//! - **Speed.** The least-squares errors of Table 3 grow with the speed, more than with the grating: a straight line in
//!   the speed through the ten figures of piezoresistors 1 of units 1 and 2 is the speed's error ([`Line::of_table_3`]).
//!   Its sign is not in them; that the tone is too fast comes from the table's FFT row, see the document.
//! - **Scatter from run to run**: twice what the ten figures stray from that line, for each is of four runs.
//! - **What differs from run to run otherwise**, as noise on every reading, such that piezoresistor 1 of unit 1 repeats
//!   as well as the paper's ([`NOISE_UV`]).
//!
//! Ripple and jitter are plausible figures, the same for all.

use super::paper::{RUNS, TABLE_3};
use hal_mock::{Finger, Sliding, Stimulator, TABLE_2};

/// Noise of every reading, uV RMS, in place of all that is not the same in two runs: with it piezoresistor 1 of unit 1
/// repeats about as well as in the paper (0.92, the middle of its range). Much more than the electronics makes.
pub const NOISE_UV: f64 = 900.0;

/// Ripple of the speed, percent of it, at the scene's 5 Hz; plausible.
pub const RIPPLE_PERCENT: f64 = 2.0;

/// The slide begins up to so much early or late, seconds; plausible. The paper takes 55 of 60 mm because of "inherent
/// timing variations", which bounds it to 50 ms at 48 mm/s.
pub const JITTER_S: f64 = 0.02;

/// What is imperfect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Imperfect {
    /// The speed: its mean, and from run to run.
    pub speed: bool,
    /// It ripples.
    pub ripple: bool,
    /// The slide's beginning.
    pub onset: bool,
    /// The readings.
    pub noise: bool,
}

impl Imperfect {
    /// All of it, as in the paper.
    pub const ALL: Self = Self { speed: true, ripple: true, onset: true, noise: true };
    /// Nothing: ramps of 20 ms, and the noise of bridge and converter.
    pub const NOTHING: Self = Self { speed: false, ripple: false, onset: false, noise: false };
}

/// Relative error of the speed by speed, percent: a straight line, and how far the figures that it was drawn through are
/// from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// At rest.
    pub at_zero_percent: f64,
    /// By speed, percent per mm/s.
    pub slope_percent_s_mm: f64,
    /// Root of the mean square of what the line leaves, percent.
    pub rest_percent: f64,
}

impl Line {
    /// Through Table 3's least-squares errors of its first pair, by least squares.
    pub fn of_table_3() -> Self {
        let errors = TABLE_3[0].least_squares.percent;
        let points = || TABLE_2.into_iter().map(|(speed_mm_s, _)| speed_mm_s).zip(errors);
        let count = errors.len() as f64;
        let (x, y) = (points().map(|p| p.0).sum::<f64>() / count, points().map(|p| p.1).sum::<f64>() / count);
        let slope =
            points().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / points().map(|p| (p.0 - x) * (p.0 - x)).sum::<f64>();
        let mut line = Self { at_zero_percent: y - slope * x, slope_percent_s_mm: slope, rest_percent: 0.0 };
        line.rest_percent = (points().map(|p| (p.1 - line.at(p.0)).powi(2)).sum::<f64>() / count).sqrt();
        line
    }

    /// The error at a speed, percent.
    pub fn at(&self, speed_mm_s: f64) -> f64 {
        self.at_zero_percent + self.slope_percent_s_mm * speed_mm_s
    }

    /// From run to run, RMS, percent.
    pub fn scatter_percent(&self) -> f64 {
        f64::from(RUNS).sqrt() * self.rest_percent
    }
}

/// The scene of a run. `run` counts from 0; runs have different noise, ripple and onset, and speeds around the mean one.
pub fn scene((speed_mm_s, period_mm): (f64, f64), run: u32, imperfect: Imperfect) -> Sliding {
    let line = Line::of_table_3();
    let ideal = Sliding::physical();
    let percent = line.at(speed_mm_s) + line.scatter_percent() * deviate(run);
    Sliding {
        speed_mm_s,
        period_mm,
        // Unit 1 is at the grating's leading edge, as in the paper.
        reverse: true,
        seed: (1000.0 * period_mm) as u64 * 1000 + 10 * speed_mm_s as u64 + u64::from(run) + 1,
        stimulator: Stimulator {
            speed_error_percent: if imperfect.speed { percent } else { 0.0 },
            ripple_percent: if imperfect.ripple { RIPPLE_PERCENT } else { 0.0 },
            onset_jitter_s: if imperfect.onset { JITTER_S } else { 0.0 },
            ..ideal.stimulator
        },
        finger: ideal.finger.map(|finger| match imperfect.noise {
            true => Finger { noise_uv: NOISE_UV, ..finger },
            false => finger,
        }),
        ..ideal
    }
}

/// Where a run is around the mean: evenly spaced, and over every four runs with a mean of 0 and a mean square of 1.
fn deviate(run: u32) -> f64 {
    // Not in order, so that two runs are as good as four for a look.
    let place = [-1.0, 1.0, 3.0, -3.0][(run % RUNS) as usize];
    place / 5f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_the_one_of_least_squares() {
        let line = Line::of_table_3();
        // By the normal equations, with sums of v, v^2, e and v e taken by hand: 276, 9108, 11.17, 336.69.
        assert!((line.slope_percent_s_mm - (336.69 - 27.6 * 11.17) / (9108.0 - 27.6 * 276.0)).abs() < 1e-9);
        assert!((line.at(27.6) - 1.117).abs() < 1e-9);
        assert!(line.rest_percent > 0.0 && line.rest_percent < 0.3);
    }

    #[test]
    fn four_runs_are_off_by_the_scatter_and_not_on_the_average() {
        let of_four = |power: i32| (0..RUNS).map(|run| deviate(run).powi(power)).sum::<f64>() / 4.0;
        assert!(of_four(1).abs() < 1e-12 && (of_four(2) - 1.0).abs() < 1e-12);
    }
}
