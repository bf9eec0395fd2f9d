//! Likelihood of a window in f64, its maximum, and its curvature there.

use std::f64::consts::TAU;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Baseline {
    /// A level and a slope.
    Line,
    /// A polynomial of this degree.
    Polynomial(i32),
}

/// Likelihood of a frequency, with the noise of each channel unknown and all other unknowns fitted.
#[derive(Clone, Debug)]
pub struct Likelihood<'a> {
    values: &'a [[f32; 16]],
    /// Times of the frames, in frames from the centre.
    positions: Vec<f64>,
    rows: Vec<usize>,
    /// Bit c: channel c is used.
    channels: u16,
    pub harmonics: usize,
    pub baseline: Baseline,
    /// Cycles per frame of a known interferer.
    pub interferer: Option<f64>,
}

impl<'a> Likelihood<'a> {
    pub fn new(values: &'a [[f32; 16]], harmonics: usize, baseline: Baseline) -> Self {
        let centre = 0.5 * (values.len() as f64 - 1.0);
        let positions = (0..values.len()).map(|n| n as f64 - centre).collect();
        let rows = (0..values.len()).collect();
        Self {
            values,
            positions,
            rows,
            channels: u16::MAX,
            harmonics,
            baseline,
            interferer: None,
        }
    }

    /// Restricts the likelihood to `channels`, and to the frames in which all of `taxels` are
    /// valid.
    pub fn only(self, channels: u16, valid: &[u16], taxels: u16) -> Self {
        let rows = (0..self.values.len())
            .filter(|n| valid[*n] & taxels == taxels)
            .collect();
        Self {
            rows,
            channels,
            ..self
        }
    }

    /// Returns the frequency of the maximum within `reach` of `near`, cycles per frame, by grid
    /// search and then golden section.
    pub fn peak(&self, near: f64, reach: f64) -> f64 {
        let sides = 8;
        let at = |i: i32| near + reach * i as f64 / sides as f64;
        let cost = |f: f64| {
            if f > 0.0 && f < 0.5 {
                self.cost(f)
            } else {
                f64::INFINITY
            }
        };
        let costs = (-sides..=sides).map(|i| (cost(at(i)), i));
        let (_, best) = costs.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let (mut a, mut b) = (at(best - 1), at(best + 1));
        let ratio = (5f64.sqrt() - 1.0) / 2.0;
        let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
        let (mut at_x, mut at_y) = (cost(x), cost(y));
        while b - a > 1e-11 {
            if at_x < at_y {
                (b, y, at_y) = (y, x, at_x);
                x = b - ratio * (b - a);
                at_x = cost(x);
            } else {
                (a, x, at_x) = (x, y, at_y);
                y = a + ratio * (b - a);
                at_y = cost(y);
            }
        }
        0.5 * (a + b)
    }

    /// Returns the standard deviation of the frequency in cycles per frame, from the curvature at
    /// `peak`: the Cramer-Rao bound with the noise estimated from the residuals.
    pub fn sigma(&self, peak: f64) -> f64 {
        let mut step = 1e-4 / self.values.len() as f64;
        for _ in 0..4 {
            let bend = self.cost(peak + step) + self.cost(peak - step) - 2.0 * self.cost(peak);
            step *= 0.3 / bend.max(1e-9).sqrt();
        }
        step / 0.3
    }

    /// Negative log-likelihood, up to a constant.
    fn cost(&self, f: f64) -> f64 {
        let basis = orthonormal(self.columns(f));
        let mut sum = 0.0;
        for c in (0..16).filter(|c| self.channels & 1 << c != 0) {
            let first = self.values[self.rows[0]][c] as f64;
            let mut rest: Vec<f64> = self
                .rows
                .iter()
                .map(|n| self.values[*n][c] as f64 - first)
                .collect();
            for unit in &basis {
                take_off(&mut rest, unit);
            }
            sum += dot(&rest, &rest).ln();
        }
        0.5 * (self.rows.len() - basis.len()) as f64 * sum
    }

    fn columns(&self, f: f64) -> Vec<Vec<f64>> {
        let half = self
            .positions
            .iter()
            .fold(0.0, |max: f64, position| max.max(position.abs()));
        let column =
            |of: &dyn Fn(f64) -> f64| self.rows.iter().map(|n| of(self.positions[*n])).collect();
        let degree = match self.baseline {
            Baseline::Line => 1,
            Baseline::Polynomial(degree) => degree,
        };
        let mut columns: Vec<Vec<f64>> = (0..=degree)
            .map(|d| column(&|t| (t / half).powi(d)))
            .collect();
        let harmonics = (1..=self.harmonics).map(|h| h as f64 * f);
        for f in self.interferer.into_iter().chain(harmonics) {
            columns.push(column(&|t| (TAU * f * t).cos()));
            columns.push(column(&|t| (TAU * f * t).sin()));
        }
        columns
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn take_off(from: &mut [f64], unit: &[f64]) {
    let along = dot(from, unit);
    from.iter_mut().zip(unit).for_each(|(x, u)| *x -= along * u);
}

/// Orthonormalizes by modified Gram-Schmidt, twice. Drops columns (of elements near one) that
/// depend on the others or consist of rounding errors.
fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        for _ in 0..2 {
            basis.iter().for_each(|unit| take_off(&mut column, unit));
        }
        let length = dot(&column, &column);
        if length > 1e-15 * column.len() as f64 {
            column.iter_mut().for_each(|x| *x /= length.sqrt());
            basis.push(column);
        }
    }
    basis
}
