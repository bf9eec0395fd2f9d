//! `skin`: the relaxation of a person's skin, by their own finger.
//!
//! Equations 15 and 16 of Moy et al.: under a deformation that stays, the force is
//! A + B exp(-c t). A, B and c follow by least squares (the paper searches with a simplex): A and B
//! are linear, so the sum of squares is searched over c alone.

use anyhow::{Context, Result, ensure};
use ridgetone_host::part::Part;
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::{Selection, columns};
use serde::Serialize;

/// Fewest rows of a fit of three unknowns.
const ROWS_MIN: usize = 16;

/// Values of c that are tried before the best one is refined.
const GUESSES: i32 = 200;

/// Halvings of the refinement's step: to 1e-9 of c.
const REFINEMENTS: u32 = 30;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimated {
    pub value: f64,
    pub sigma: f64,
}

/// A row of the paper's Table 5. Standard deviations are those of white noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "skin")]
pub struct Relaxation {
    /// The force that stays, in the recording's unit: A.
    pub a: Estimated,
    /// The force that fades: B.
    pub b: Estimated,
    /// By how much it fades: c.
    pub c_per_s: Estimated,
    /// Relaxation time for constant strain, 1 / c.
    pub relaxation_s: Estimated,
    /// Relaxation time for constant stress, (1 + B / A) / c.
    pub creep_s: Estimated,
    /// What the fit leaves, root mean square, in the recording's unit.
    pub residual: f64,
    pub rows: usize,
}

/// Times since the step, seconds, and forces.
#[derive(Clone, Copy, Debug)]
struct Forces<'a> {
    times_s: &'a [f64],
    values: &'a [f64],
}

/// The best A and B for a value of c, and the sum of squares that they leave.
#[derive(Clone, Copy, Debug)]
struct Guess {
    c_per_s: f64,
    a: f64,
    b: f64,
    squares: f64,
}

/// Fits one column of a recording of the force after a step of deformation, which is at the
/// selection's first time.
pub fn fit(recording: &Samples, selection: &Selection) -> Result<Relaxation> {
    let rows = &mut *recording.open()?;
    let file = rows.file().to_owned();
    let columns = columns(rows, selection)?;
    let [column] = columns[..] else {
        anyhow::bail!(
            "{file}: {} columns could be the force: name it with --column",
            columns.len()
        )
    };
    let part = Part::read(rows, selection, usize::MAX, &mut |_| ())?;
    let values = part.column(column);
    let start_s = selection.from_s.or(part.times_s.first().copied());
    let known = part.times_s.iter().zip(values.iter());
    let (times_s, values): (Vec<f64>, Vec<f64>) = known
        .filter(|(_, value)| !value.is_nan())
        .map(|(t_s, value)| (t_s - start_s.unwrap_or(0.0), *value))
        .unzip();
    let (times_s, values) = (&times_s[..], &values[..]);
    Forces { times_s, values }.fit().context(file)
}

impl Forces<'_> {
    fn fit(self) -> Result<Relaxation> {
        let rows = self.values.len();
        ensure!(
            rows >= ROWS_MIN,
            "{rows} forces: at least {ROWS_MIN} are needed"
        );
        let lasts_s = self.times_s[rows - 1] - self.times_s[0];
        ensure!(lasts_s > 0.0, "the rows have no time: give --rate");
        // From a time constant of ten times the recording, which a straight line resembles, to one
        // of two rows.
        let (least, most) = (0.1 / lasts_s, 0.5 * rows as f64 / lasts_s);
        let at = |n: i32| least * (most / least).powf(f64::from(n) / f64::from(GUESSES));
        let best = |guesses: &mut dyn Iterator<Item = f64>| {
            guesses
                .filter_map(|c_per_s| self.guess(c_per_s))
                .min_by(|x, y| x.squares.total_cmp(&y.squares))
        };
        let failed = "no exponential fits these forces";
        let mut found = best(&mut (0..=GUESSES).map(at)).context(failed)?;
        ensure!(
            found.c_per_s > at(1) && found.c_per_s < at(GUESSES - 1),
            "the force does not relax within the {lasts_s:.3} s of the recording"
        );
        let mut step = (most / least).ln() / f64::from(GUESSES);
        for _ in 0..REFINEMENTS {
            let c = found.c_per_s;
            let near = [-step, 0.0, step].map(|step| c * step.exp());
            found = best(&mut near.into_iter()).context(failed)?;
            if found.c_per_s == c {
                step *= 0.5;
            }
        }
        ensure!(
            found.a > 0.0 && found.b > 0.0,
            "the force does not fade towards a level above zero: A = {:.4}, B = {:.4}",
            found.a,
            found.b
        );
        self.relaxation(found).context(failed)
    }

    /// Solves for A and B.
    fn guess(self, c_per_s: f64) -> Option<Guess> {
        let count = self.values.len() as f64;
        let fading: Vec<f64> = self
            .times_s
            .iter()
            .map(|t_s| (-c_per_s * t_s).exp())
            .collect();
        let pairs = || fading.iter().zip(self.values);
        let (mean_fading, mean) = pairs().fold((0.0, 0.0), |(x, y), (fading, value)| {
            (x + fading / count, y + value / count)
        });
        let along: f64 = pairs().map(|(x, y)| (x - mean_fading) * (y - mean)).sum();
        let square: f64 = fading.iter().map(|x| (x - mean_fading).powi(2)).sum();
        let b = along / square;
        let a = mean - b * mean_fading;
        let squares: f64 = pairs().map(|(x, y)| (y - a - b * x).powi(2)).sum();
        squares.is_finite().then_some(Guess {
            c_per_s,
            a,
            b,
            squares,
        })
    }

    /// Standard deviations by the inverse of the products of the derivatives.
    fn relaxation(self, found: Guess) -> Option<Relaxation> {
        let (a, b, c, squares) = (found.a, found.b, found.c_per_s, found.squares);
        let mut products = [[0.0; 3]; 3];
        for t_s in self.times_s {
            let fading = (-c * t_s).exp();
            let slopes = [1.0, fading, -b * t_s * fading];
            (0..9).for_each(|n| products[n / 3][n % 3] += slopes[n / 3] * slopes[n % 3]);
        }
        let variance = squares / (self.values.len() - 3) as f64;
        let inverse = inverse(&products)?;
        // What changes so much with A, B and c.
        let estimated = |value: f64, slopes: [f64; 3]| {
            let of_row = |row: &[f64; 3]| (0..3).map(|n| row[n] * slopes[n]).sum::<f64>();
            let sum: f64 = (0..3).map(|n| slopes[n] * of_row(&inverse[n])).sum();
            let sigma = (variance * sum).max(0.0).sqrt();
            Estimated { value, sigma }
        };
        let ratio = 1.0 + b / a;
        Some(Relaxation {
            a: estimated(a, [1.0, 0.0, 0.0]),
            b: estimated(b, [0.0, 1.0, 0.0]),
            c_per_s: estimated(c, [0.0, 0.0, 1.0]),
            relaxation_s: estimated(1.0 / c, [0.0, 0.0, -1.0 / (c * c)]),
            creep_s: estimated(
                ratio / c,
                [-b / (a * a * c), 1.0 / (a * c), -ratio / (c * c)],
            ),
            residual: (squares / self.values.len() as f64).sqrt(),
            rows: self.values.len(),
        })
    }
}

/// Inverse of a symmetric matrix by its cofactors.
fn inverse(matrix: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactor = |row: usize, column: usize| {
        let at = |down: usize, right: usize| matrix[(row + down) % 3][(column + right) % 3];
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    };
    let determinant: f64 = (0..3).map(|n| matrix[0][n] * cofactor(0, n)).sum();
    (determinant > 0.0)
        .then(|| std::array::from_fn(|row| std::array::from_fn(|n| cofactor(row, n) / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_relax_is_refused() {
        for (truth, word) in [
            ([2.0, 1.0, 1e-4], "does not relax"),
            ([2.0, -1.0, 0.5], "does not fade"),
            ([-2.0, 1.0, 0.5], "does not fade"),
            ([2.0, 0.0, 0.5], ""),
        ] {
            let [a, b, c] = truth;
            let times_s: Vec<f64> = (0..1500).map(|row| 0.01 * f64::from(row)).collect();
            let values: Vec<f64> = times_s.iter().map(|t_s| a + b * (-c * t_s).exp()).collect();
            let (times_s, values) = (&times_s[..], &values[..]);
            let error = Forces { times_s, values }.fit().expect_err("refused");
            assert!(error.to_string().contains(word), "{error:#}");
        }
    }
}
