//! The least-squares solution at one frequency, and the step towards a better one.
//!
//! For a fixed frequency every other unknown is linear, so they are solved for exactly (variable projection) and a
//! Gauss-Newton step moves the frequency alone. Channels count by the inverse of their own residual variance, which makes
//! this the maximum of the likelihood with unknown noise in each channel.

use crate::equations::{Function, Shape, fill, residual_sums_of_squares, right_sides, wave};
use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::moments::Moments;
use crate::normal::{Normal, Rows, Vector, dot_all, less_products};
use crate::nuisance::Nuisances;
use crate::source::Values;
use crate::waves::{Wave, Weight};
use core::f32::consts::PI;

/// The least-squares solution at one frequency and the step towards a better one.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Cycles per half span ([`crate::abscissa`]).
    pub nu: f32,
    /// What was fitted.
    pub shape: Shape,
    /// Each channel's unknowns: offset beyond [`Levels::offset`], slope, nuisances, cosine and sine of each harmonic.
    pub unknowns: Rows,
    /// Residual sums of squares; 0 for a channel that is not used.
    pub residual_sum_of_squares: Values,
    /// Gauss-Newton step in `nu`.
    pub step: f32,
    /// Information about `nu`: the inverse of its variance.
    pub information: f32,
    /// Weighted power of each harmonic.
    pub power: [f32; HARMONICS_MAX],
    /// Offset in `nu` of each harmonic, fitted alone, from its place in the series.
    pub offset: [f32; HARMONICS_MAX],
    /// Standard deviation of that.
    pub offset_sigma: [f32; HARMONICS_MAX],
    workspace: Workspace,
}

/// Waves of the harmonics: a cosine and a sine each.
const WAVES: usize = 2 * HARMONICS_MAX;

/// Where [`Solution::solve`] works; kept, so that it need not be emptied every time: it is written before it is read.
#[derive(Clone, Debug)]
struct Workspace {
    normal: Normal,
    /// Products of the derivative's functions with the model's own, after forward substitution.
    projections: [Vector; WAVES],
    /// Their products with the residuals of each channel.
    gradients: [Values; WAVES],
    /// Their factors in the derivative of each channel, and the same weighted.
    factors: [Values; WAVES],
    weighted: [Values; WAVES],
}

impl Workspace {
    #[inline(always)]
    const fn new() -> Self {
        let rows = [[0.0; CHANNELS_MAX]; WAVES];
        let projections = [[0.0; UNKNOWNS_MAX]; WAVES];
        Self { normal: Normal::new(0), projections, gradients: rows, factors: rows, weighted: rows }
    }
}

impl Solution {
    /// Factors of cosine and sine of harmonic `h`, 0 the fundamental, for every channel.
    pub fn harmonic(&self, h: usize) -> (&Values, &Values) {
        let first = (self.shape.first_wave() + 2 * h).min(UNKNOWNS_MAX - 2);
        (&self.unknowns[first], &self.unknowns[first + 1])
    }
}

impl Solution {
    /// No solution yet. A constant of zeros is written in its place; the result of a function would be copied.
    pub const NONE: Self = {
        let lines = [0.0; HARMONICS_MAX];
        Self {
            nu: 0.0,
            shape: Shape { harmonics: 0, slope: false, nuisances: 0 },
            unknowns: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
            residual_sum_of_squares: [0.0; CHANNELS_MAX],
            step: 0.0,
            information: 0.0,
            power: lines,
            offset: lines,
            offset_sigma: lines,
            workspace: Workspace::new(),
        }
    };

    /// Visits the residual sums of squares of each number of harmonics, from none up to those of `shape`, or to as many as
    /// can be separated. Overwrites the solution.
    #[inline(never)]
    pub fn residual_sums(
        &mut self,
        moments: &Moments,
        levels: &Levels,
        nuisances: &Nuisances,
        shape: &Shape,
        visit: &mut dyn FnMut(usize, &Values),
    ) {
        let Self { unknowns: rows, workspace: Workspace { normal, .. }, .. } = self;
        normal.size = shape.unknowns().min(UNKNOWNS_MAX);
        fill(normal, moments, nuisances, shape);
        right_sides(rows, moments, levels, nuisances, shape);
        // Waves come last, so that the factor of fewer of them is a corner of this one.
        normal.factor_some();
        normal.forward_rows(rows);
        for harmonics in 0..=shape.harmonics {
            let size = Shape { harmonics, ..*shape }.unknowns();
            if size <= normal.size {
                visit(harmonics, &residual_sums_of_squares(levels, rows, size));
            }
        }
    }

    /// Variance of the fundamental's cosine factor, of its sine factor, and their covariance, for noise of variance 1. The
    /// same in every channel. None before there is a solution with a wave.
    #[inline(never)]
    pub fn fundamental_covariance(&self) -> Option<[f32; 3]> {
        // Unit vectors after forward substitution: their products are elements of the inverse.
        let mut columns = [[0.0; UNKNOWNS_MAX]; 2];
        for (column, index) in columns.iter_mut().zip(self.shape.first_wave()..) {
            *column.get_mut(index)? = 1.0;
            self.workspace.normal.forward(column);
        }
        let [cos, sin] = &columns;
        Some([dot_all(cos, cos), dot_all(sin, sin), dot_all(cos, sin)])
    }

    /// Solves at the frequency `nu` of `moments`, without meaning if there are no harmonics. None if the equations are
    /// singular there.
    #[inline(never)]
    pub fn solve(
        &mut self,
        moments: &Moments,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        shape: Shape,
    ) -> Option<()> {
        let sums = &moments.trigonometric;
        let (size, frames) = (shape.unknowns(), levels.frames as f32);
        let Self { unknowns: rows, workspace: Workspace { normal, projections, gradients, factors, weighted }, .. } =
            self;
        normal.size = size.min(UNKNOWNS_MAX);
        fill(normal, moments, nuisances, &shape);
        normal.factor()?;
        right_sides(rows, moments, levels, nuisances, &shape);
        normal.forward_rows(rows);
        let residual_sum_of_squares = residual_sums_of_squares(levels, rows, size);
        let mut weight = [0.0; CHANNELS_MAX];
        for c in 0..CHANNELS_MAX {
            weight[c] = if residual_sum_of_squares[c] > 0.0 {
                (frames - size as f32).max(1.0) / residual_sum_of_squares[c]
            } else {
                0.0
            };
        }

        // d model / d nu is a sum of u cos(h theta) and u sin(h theta).
        let waves = 2 * shape.harmonics.min(HARMONICS_MAX);
        for d in 0..waves {
            let along = if d % 2 == 0 { &moments.u_cos[d / 2] } else { &moments.u_sin[d / 2] };
            // Zero behind the last: products of these take all.
            projections[d] = [0.0; UNKNOWNS_MAX];
            for (i, projections) in projections[d].iter_mut().enumerate().take(size) {
                *projections = match shape.function(i) {
                    Function::Wave(b) => sums.product(Weight::U, wave(d), b),
                    Function::Slope => sums.product(Weight::UU, wave(d), Wave::One),
                    Function::Nuisance(k) => along[CHANNELS_MAX + k],
                };
            }
            normal.forward(&mut projections[d]);
            if let Some(along) = along.first_chunk() {
                gradients[d] = less_products(along, &projections[d][..size], &rows[..]);
            }
        }
        normal.backward_rows(rows);

        let lines = [0.0; HARMONICS_MAX];
        (self.nu, self.shape, self.residual_sum_of_squares) = (nu, shape, residual_sum_of_squares);
        (self.step, self.information) = (0.0, 0.0);
        (self.power, self.offset, self.offset_sigma) = (lines, lines, lines);
        if waves == 0 {
            return Some(());
        }
        let mut line_gradient = [0.0; HARMONICS_MAX];
        let mut line_information = [0.0; HARMONICS_MAX];
        let first = shape.first_wave();
        for d in 0..waves {
            let (cos, sin) = (&rows[first + d / 2 * 2], &rows[first + d / 2 * 2 + 1]);
            let turn = 2.0 * PI * (d / 2 + 1) as f32;
            let (turn, amplitude) = if d % 2 == 0 { (turn, sin) } else { (-turn, cos) };
            for c in 0..CHANNELS_MAX {
                factors[d][c] = turn * amplitude[c];
                weighted[d][c] = weight[c] * factors[d][c];
            }
            line_gradient[d / 2] += dot_all(&weighted[d], &gradients[d]);
            for e in 0..=d {
                let common = dot_all(&projections[d], &projections[e]);
                let spread = sums.product(Weight::UU, wave(d), wave(e)) - common;
                let product = dot_all(&weighted[d], &factors[e]);
                let part = if e < d { 2.0 } else { 1.0 } * product * spread;
                self.information += part;
                if d / 2 == e / 2 {
                    line_information[d / 2] += part;
                }
                if d == e {
                    let turn_squared = turn * turn;
                    self.power[d / 2] += 0.5 * frames * product / turn_squared;
                }
            }
        }
        if !(self.information > 0.0) {
            return None;
        }
        self.step = line_gradient.iter().sum::<f32>() / self.information;
        for h in 0..waves / 2 {
            if line_information[h] > 0.0 {
                self.offset[h] = (h + 1) as f32 * line_gradient[h] / line_information[h];
                self.offset_sigma[h] = (h + 1) as f32 / libm::sqrtf(line_information[h]);
            }
        }
        Some(())
    }
}
