//! The scenes: the paper's ten combinations on the physical finger, with a stimulator as imperfect
//! as the paper's figures suggest.
//!
//! The paper names "precise position control" and gives no figure. Three numbers follow from its
//! results:
//! - **Speed.** The least-squares errors of Table 3 grow with the speed, more than with the
//!   grating: a straight line in the speed through the ten figures of piezoresistors 1 of units 1
//!   and 2 is the speed's error ([`SpeedError::of_table_3`]). Its sign follows from the table's FFT
//!   row: the tone is too fast, see the page.
//! - **Scatter from run to run**: twice the residual of the ten figures after such a line with an
//!   offset for each grating, for each figure is of four runs.
//! - **All other differences from run to run**, as noise on every reading, such that piezoresistor
//!   1 of unit 1 repeats as well as the paper's ([`NOISE_UV`]).
//!
//! Ripple and jitter are plausible figures, the same for all.

use super::paper::{GRATINGS_MM, RUNS, TABLE_3};
use hal_mock::{Finger, Sliding, Stimulator, TABLE_2};

/// Noise of every reading, uV RMS. It stands for everything that differs between two runs: with it
/// piezoresistor 1 of unit 1 repeats about as well as in the paper (0.92, the middle of its range).
/// The electronics makes much less.
pub const NOISE_UV: f64 = 900.0;

/// Ripple of the speed, percent of it, at the scene's 5 Hz; plausible.
pub const RIPPLE_PERCENT: f64 = 2.0;

/// The slide begins up to so much early or late, seconds; plausible. The paper takes 55 of 60 mm
/// because of "inherent timing variations", which bounds it to 50 ms at 48 mm/s.
pub const JITTER_S: f64 = 0.02;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Imperfect {
    /// The speed: its mean, and from run to run.
    pub speed: bool,
    pub ripple: bool,
    pub onset: bool,
    pub noise: bool,
}

impl Imperfect {
    /// All, as in the paper.
    pub const ALL: Self = Self {
        speed: true,
        ripple: true,
        onset: true,
        noise: true,
    };
    /// None: ramps of 20 ms, and the noise of bridge and converter.
    pub const NOTHING: Self = Self {
        speed: false,
        ripple: false,
        onset: false,
        noise: false,
    };
}

/// Relative error of the speed, percent: a straight line in the speed, and a scatter from run to
/// run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedError {
    pub at_zero_percent: f64,
    /// By speed, percent per mm/s.
    pub slope_percent_s_mm: f64,
    /// From run to run, standard deviation, percent.
    pub scatter_percent: f64,
}

impl SpeedError {
    /// Through Table 3's least-squares errors of its first pair, by least squares. The scatter is
    /// the residual after a line with an offset for each grating, times the root of the number of
    /// runs of each figure.
    pub fn of_table_3() -> Self {
        let errors = TABLE_3[0].least_squares.percent;
        let points: Vec<(f64, f64)> = TABLE_2
            .into_iter()
            .map(|(speed_mm_s, _)| speed_mm_s)
            .zip(errors)
            .collect();
        let [x, y, xx, xy, _] = moments(&points);
        let slope = xy / xx;
        let of_grating = |period_mm: f64| {
            let own = TABLE_2
                .into_iter()
                .zip(&points)
                .filter(|(line, _)| line.1 == period_mm);
            moments(&own.map(|(_, point)| *point).collect::<Vec<_>>())
        };
        let mut within = [0.0; 5];
        for period_mm in GRATINGS_MM {
            within
                .iter_mut()
                .zip(of_grating(period_mm))
                .for_each(|(sum, own)| *sum += own);
        }
        let [_, _, xx, xy, yy] = within;
        // Ten figures less four offsets and a slope.
        let freedom = (points.len() - GRATINGS_MM.len() - 1) as f64;
        let residual_percent = ((yy - xy * xy / xx) / freedom).sqrt();
        Self {
            at_zero_percent: y - slope * x,
            slope_percent_s_mm: slope,
            scatter_percent: f64::from(RUNS).sqrt() * residual_percent,
        }
    }

    /// The mean error at a speed, percent.
    pub fn at(&self, speed_mm_s: f64) -> f64 {
        self.at_zero_percent + self.slope_percent_s_mm * speed_mm_s
    }
}

/// Means of x and y, and the sums of squares and products about them: xx, xy, yy.
fn moments(points: &[(f64, f64)]) -> [f64; 5] {
    let count = points.len() as f64;
    let (x, y) = (
        points.iter().map(|p| p.0).sum::<f64>() / count,
        points.iter().map(|p| p.1).sum::<f64>() / count,
    );
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| of(p.0 - x, p.1 - y)).sum::<f64>();
    [
        x,
        y,
        sum(&|x, _| x * x),
        sum(&|x, y| x * y),
        sum(&|_, y| y * y),
    ]
}

/// The scene of a run. `run` counts from 0; runs have different noise, ripple and onset, and speeds
/// around the mean one.
pub fn scene(speed_mm_s: f64, period_mm: f64, run: u32, imperfect: Imperfect) -> Sliding {
    let line = SpeedError::of_table_3();
    let ideal = Sliding::physical();
    let percent = line.at(speed_mm_s) + line.scatter_percent * deviate(run);
    Sliding {
        speed_mm_s,
        period_mm,
        // Unit 1 is at the grating's leading edge, as in the paper.
        reverse: true,
        seed: (1000.0 * period_mm) as u64 * 1000 + 10 * speed_mm_s as u64 + u64::from(run) + 1,
        stimulator: Stimulator {
            speed_error_percent: if imperfect.speed { percent } else { 0.0 },
            ripple_percent: if imperfect.ripple {
                RIPPLE_PERCENT
            } else {
                0.0
            },
            onset_jitter_s: if imperfect.onset { JITTER_S } else { 0.0 },
            ..ideal.stimulator
        },
        finger: ideal.finger.map(|finger| match imperfect.noise {
            true => Finger {
                noise_uv: NOISE_UV,
                ..finger
            },
            false => finger,
        }),
        ..ideal
    }
}

/// The deviation of a run: evenly spaced, with a mean of 0 and a mean square of 1 over every four
/// runs.
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
        let line = SpeedError::of_table_3();
        // By the normal equations, with sums of v, v^2, e and v e taken by hand: 276, 9108, 11.17,
        // 336.69.
        assert!(
            (line.slope_percent_s_mm - (336.69 - 27.6 * 11.17) / (9108.0 - 27.6 * 276.0)).abs()
                < 1e-9
        );
        assert!((line.at(27.6) - 1.117).abs() < 1e-9);
        // Numpy's lstsq with a column for each grating: 0.083222 over five degrees of freedom.
        assert!((line.scatter_percent - 2.0 * 0.083_221_8).abs() < 1e-6);
    }

    #[test]
    fn without_imperfections_they_are_the_scene_files() {
        for (number, line) in (1..).zip(TABLE_2) {
            let path = format!(
                "{}/../../hal-mock/scenes/c{number}.toml",
                env!("CARGO_MANIFEST_DIR")
            );
            let file = hal_mock::load_scene(path, ridgetone_host::input::frame_rate_hz())
                .expect("a scene");
            let own = scene(line.0, line.1, 0, Imperfect::NOTHING);
            assert_eq!(
                Sliding {
                    seed: own.seed,
                    ..file
                },
                own,
                "c{number}.toml"
            );
        }
    }

    #[test]
    fn four_runs_are_off_by_the_scatter_and_not_on_the_average() {
        let of_four = |power: i32| (0..RUNS).map(|run| deviate(run).powi(power)).sum::<f64>() / 4.0;
        assert!(of_four(1).abs() < 1e-12 && (of_four(2) - 1.0).abs() < 1e-12);
    }
}
