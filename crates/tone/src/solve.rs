//! Least squares from the blocks of a window: one frequency for all channels, by one Gauss-Newton
//! step; harmonics and baseline are projected out (variable projection).

use crate::blocks::{Blocks, LOCAL, Lines, PRODUCTS, product};
use crate::curves::curves;
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, CURVES_MAX, HARMONICS_MAX, LINES_MAX, UNKNOWNS_MAX};
use crate::normal::{Matrix, Normal, Rows, dot, subtract};
use crate::phase::{cos_sin, from_turns};
use crate::source::Values;
use crate::statistics::{Channels, Statistics};
use core::f32::consts::PI;

/// Two for each harmonic.
pub const WAVES: usize = 2 * HARMONICS_MAX;
/// Where the curves begin among the columns: behind level, slope and the lines.
pub const CURVES: usize = 2 + 2 * LINES_MAX;
/// Least share of a channel's squares that its residuals are taken to have: below, they are
/// rounding.
pub const RESIDUAL_SHARE_MIN: f32 = 1e-6;

/// Share of a channel's squares below which its residuals are taken frame by frame.
const CANCELLED_SHARE: f32 = 1e-3;
/// Least product of the shares that are each unknown's own: below, f32 invents what nearly equal
/// functions explain. Curves, which a solution has too, resemble each other.
pub const LIKELIHOOD_PRODUCT_MIN: f32 = 1e-6;
const SOLUTION_PRODUCT_MIN: f32 = 1e-13;
/// Mean square below which an interferer's cosine or sine is nothing but rounding.
pub const WAVE_SHARE_MIN: f32 = 1e-3;
/// Least share of a curve's squares that is not in the waves.
pub const CURVE_SHARE_MIN: f32 = 1e-4;

/// What is fitted to each channel beside level and slope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    pub harmonics: usize,
    /// Functions of a curved baseline.
    pub curves: usize,
    /// Whether there is an interferer.
    pub interferer: bool,
}

impl Shape {
    /// Unknowns of a channel.
    pub fn unknowns(&self) -> usize {
        self.first_curve() + self.curves
    }

    /// Where the harmonics begin: behind level, slope and interferer.
    pub fn first_wave(&self) -> usize {
        2 + 2 * self.interferer as usize
    }

    /// Where the curves begin.
    pub fn first_curve(&self) -> usize {
        self.first_wave() + 2 * self.harmonics
    }

    /// The columns of the unknowns, with `harmonics` harmonics in front of an interferer's.
    #[inline(never)]
    fn columns(&self, harmonics: usize) -> [usize; UNKNOWNS_MAX] {
        core::array::from_fn(|unknown| match unknown {
            0 | 1 => unknown,
            _ if unknown < self.first_wave() => unknown + 2 * harmonics,
            _ if unknown < self.first_curve() => 2 + unknown - self.first_wave(),
            _ => CURVES + unknown - self.first_curve(),
        })
    }
}

/// The sums over all blocks at one frequency.
#[derive(Clone, Debug)]
pub struct Equations {
    pub nu: f32,
    /// Harmonics of the blocks, and all their lines.
    harmonics: usize,
    lines: usize,
    width: usize,
    pub frames: f32,
    /// Products of level, slope, lines, and curves; the lower triangle.
    products: Matrix,
    rows: Rows,
    /// Of the waves times `u`: with the columns, of waves up to their own line; with each other
    /// times `u` again; and with the channels.
    u_products: [[f32; UNKNOWNS_MAX]; WAVES],
    uu_products: [[f32; WAVES]; WAVES],
    u_rows: [Values; WAVES],
    squares: Values,
    /// The factor of the latest shape.
    normal: Normal,
    /// The latest solution; its unknowns are the channels behind forward substitution before there
    /// is one.
    pub solution: Solution,
}

/// A solution at one frequency.
#[derive(Clone, Debug)]
pub struct Solution {
    pub nu: f32,
    pub shape: Shape,
    pub width: usize,
    pub frames: f32,
    /// Level, slope, interferer, cosine and sine of each harmonic, and curves, for each channel.
    pub unknowns: Rows,
    pub residual_squares: Values,
    /// One over the variance of each channel's noise.
    pub weights: Values,
    /// Gauss-Newton step in `nu`.
    pub step: f32,
    /// Information about `nu`.
    pub information: f32,
    /// What each harmonic contributes to it.
    pub line_information: [f32; HARMONICS_MAX],
    /// Power of each harmonic, in units of the noise: over all channels, a chi-square of two
    /// degrees each.
    pub power: [f32; HARMONICS_MAX],
    /// Variances of the fundamental's cosine and sine factors, and their covariance, for noise of
    /// variance 1.
    pub fundamental: [f32; 3],
}

impl Equations {
    /// None yet. A constant of zeros is written in its place; the result of a function would be
    /// copied.
    pub const NONE: Self = Self {
        nu: 0.0,
        harmonics: 0,
        lines: 0,
        width: 0,
        frames: 0.0,
        products: [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX],
        rows: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
        u_products: [[0.0; UNKNOWNS_MAX]; WAVES],
        uu_products: [[0.0; WAVES]; WAVES],
        u_rows: [[0.0; CHANNELS_MAX]; WAVES],
        squares: [0.0; CHANNELS_MAX],
        normal: Normal::new(0),
        solution: Solution::NONE,
    };

    /// At the blocks' lines, with the fundamental moved to `nu`; without curves it is for shapes
    /// without them.
    #[inline(never)]
    pub fn collect(&mut self, blocks: &Blocks, nu: f32, curves: bool) {
        let (all, lines) = Lines { nu, ..blocks.lines }.all(blocks.half_line);
        (self.nu, self.lines, self.width, self.squares) = (nu, lines, blocks.width, blocks.squares);
        self.harmonics = blocks.lines.harmonics.min(lines);
        self.frames = 0.0;
        for (i, (products, row)) in self.products.iter_mut().zip(&mut self.rows).enumerate() {
            if i < 2 + 2 * lines || i >= CURVES {
                (*products, *row) = ([0.0; UNKNOWNS_MAX], [0.0; CHANNELS_MAX]);
            }
        }
        let of_u = self
            .u_products
            .iter_mut()
            .zip(&mut self.uu_products)
            .zip(&mut self.u_rows);
        for ((products, uu_products), row) in of_u.take(2 * lines) {
            (*products, *uu_products, *row) =
                ([0.0; UNKNOWNS_MAX], [0.0; WAVES], [0.0; CHANNELS_MAX]);
        }
        for b in 0..blocks.count.min(BLOCKS_MAX) {
            self.add(
                blocks.u[b],
                blocks.products(b),
                &blocks.rows[b],
                &all,
                curves,
            );
        }
    }

    #[inline(never)]
    fn add(
        &mut self,
        u: f32,
        of: &[f32; PRODUCTS],
        local: &[Values; LOCAL],
        nu: &[f32; LINES_MAX],
        with_curves: bool,
    ) {
        let (lines, width) = (self.lines.min(LINES_MAX), self.width.min(CHANNELS_MAX));
        let (n, v, vv) = (of[product(0, 0)], of[product(1, 0)], of[product(1, 1)]);
        self.frames += n;
        self.products[0][0] += n;
        self.products[1][0] += u * n + v;
        self.products[1][1] += u * u * n + 2.0 * u * v + vv;
        let curves = if with_curves {
            curves(u)
        } else {
            [[0.0; 2]; CURVES_MAX]
        };
        if with_curves {
            for (k, [value, slope]) in curves.iter().enumerate() {
                let row = &mut self.products[CURVES + k];
                let (one, along) = (value * n + slope * v, value * v + slope * vv);
                row[0] += one;
                row[1] += u * one + along;
                for (product, [value, slope]) in row[CURVES..].iter_mut().zip(&curves) {
                    *product += value * one + slope * along;
                }
                for ((row, one), along) in self.rows[CURVES + k]
                    .iter_mut()
                    .zip(&local[0])
                    .zip(&local[1])
                    .take(width)
                {
                    *row += value * one + slope * along;
                }
            }
        }
        {
            let [level, slope, ..] = &mut self.rows;
            for c in 0..width {
                level[c] += local[0][c];
                slope[c] += u * local[0][c] + local[1][c];
            }
        }
        let mut turns = [(1.0, 0.0); LINES_MAX];
        for (turn, nu) in turns.iter_mut().zip(nu).take(lines) {
            *turn = cos_sin(from_turns(nu * u));
        }
        let (wave_products, curve_products) = self.products.split_at_mut(CURVES);
        let [_, wave_products @ ..] = wave_products.as_chunks_mut::<2>().0 else {
            return;
        };
        let [_, wave_rows @ ..] = self.rows.as_chunks_mut::<2>().0 else {
            return;
        };
        let [_, local @ ..] = local.as_chunks::<2>().0 else {
            return;
        };
        let products = wave_products
            .iter_mut()
            .zip(self.u_products.as_chunks_mut::<2>().0);
        let products = products.zip(self.uu_products.as_chunks_mut::<2>().0);
        let rows = wave_rows
            .iter_mut()
            .zip(self.u_rows.as_chunks_mut::<2>().0)
            .zip(local);
        for (l, ((((of_waves, of_u), of_uu), rows), (cos, sin))) in
            products.zip(rows).zip(&turns).enumerate().take(lines)
        {
            let at = 2 + 2 * l;
            // Rotated from the block's centre to the window's.
            let turn = |with_cos: f32, with_sin: f32| {
                [
                    cos * with_cos - sin * with_sin,
                    sin * with_cos + cos * with_sin,
                ]
            };
            let ones = turn(of[product(at, 0)], of[product(at + 1, 0)]);
            let alongs = turn(of[product(at, 1)], of[product(at + 1, 1)]);
            for p in 0..2 {
                let along = u * ones[p] + alongs[p];
                of_waves[p][0] += ones[p];
                of_waves[p][1] += along;
                of_u[p][0] += u * ones[p];
                of_u[p][1] += u * along;
                if with_curves {
                    for (k, [value, slope]) in curves.iter().enumerate() {
                        let with_curve = value * ones[p] + slope * alongs[p];
                        curve_products[k][(at + p) % UNKNOWNS_MAX] += with_curve;
                        of_u[p][CURVES + k] += u * with_curve;
                    }
                }
            }
            for (m, (other_cos, other_sin)) in turns.iter().enumerate().take(l + 1) {
                let other = 2 + 2 * m;
                let upper = if m == l {
                    product(at + 1, other)
                } else {
                    product(at, other + 1)
                };
                let with_cos = turn(of[product(at, other)], of[product(at + 1, other)]);
                let with_sin = turn(of[upper], of[product(at + 1, other + 1)]);
                for p in 0..2 {
                    let cos = other_cos * with_cos[p] - other_sin * with_sin[p];
                    let sin = other_sin * with_cos[p] + other_cos * with_sin[p];
                    let add = |pairs: &mut [f32], pair: usize, cos: f32, sin: f32| {
                        if let Some([with_cos, with_sin]) =
                            pairs.as_chunks_mut::<2>().0.get_mut(pair)
                        {
                            *with_cos += cos;
                            *with_sin += sin;
                        }
                    };
                    add(&mut of_waves[p], m + 1, cos, sin);
                    add(&mut of_u[p], m + 1, u * cos, u * sin);
                    add(&mut of_uu[p], m, u * (u * cos), u * (u * sin));
                }
            }
            let (([with_cos, with_sin], [u_cos, u_sin]), [cos_row, sin_row]) = rows;
            for c in 0..width {
                let [a, b] = turn(cos_row[c], sin_row[c]);
                with_cos[c] += a;
                with_sin[c] += b;
                u_cos[c] += u * a;
                u_sin[c] += u * b;
            }
        }
    }

    /// The equations of mixtures of channels, whose squares are then not known.
    pub fn mix(&mut self, apply: impl Fn(&mut [Values])) {
        apply(&mut self.rows);
        apply(&mut self.u_rows);
        self.squares = [0.0; CHANNELS_MAX];
    }

    /// Channels.
    pub fn width(&self) -> usize {
        self.width.min(CHANNELS_MAX)
    }

    /// Whether residuals are mostly rounding of the sums whose difference they are.
    pub fn is_cancelled(&self) -> bool {
        let residuals = self.solution.residual_squares.iter().zip(&self.squares);
        residuals
            .take(self.width())
            .any(|(residual, square)| *residual < CANCELLED_SHARE * square)
    }

    /// Their sums of squares.
    pub fn squares(&self) -> &Values {
        &self.squares
    }

    fn product(&self, a: usize, b: usize) -> f32 {
        self.products
            .get(a.max(b))
            .and_then(|row| row.get(a.min(b)))
            .map_or(0.0, |product| *product)
    }

    /// The product of a wave times `u` and a column.
    fn u_product(&self, wave: usize, column: usize) -> f32 {
        let is_later = (2..CURVES).contains(&column) && column >= 4 + 2 * (wave / 2);
        let (row, column) = if is_later {
            (column - 2, 2 + wave)
        } else {
            (wave, column)
        };
        self.u_products
            .get(row)
            .and_then(|row| row.get(column))
            .map_or(0.0, |product| *product)
    }

    /// The factor of a shape's equations, and the channels behind forward substitution. The size is
    /// less than the shape's if f32 cannot separate all unknowns.
    fn factor(&mut self, shape: &Shape, columns: &[usize; UNKNOWNS_MAX], product_min: f32) {
        let size = shape.unknowns().min(UNKNOWNS_MAX);
        self.normal.size = size;
        let unknowns = self
            .normal
            .lower
            .iter_mut()
            .zip(&mut self.solution.unknowns)
            .zip(columns);
        for (i, ((lower, unknown), column)) in unknowns.enumerate().take(size) {
            for (lower, other) in lower.iter_mut().zip(columns).take(i + 1) {
                let row = self.products.get(*column.max(other));
                *lower = row
                    .and_then(|row| row.get(*column.min(other)))
                    .map_or(0.0, |product| *product);
            }
            if let Some(row) = self.rows.get(*column) {
                unknown.copy_from_slice(row);
            }
        }
        // Folded onto half the frame rate an interferer has one phase only: of the other nothing is
        // there to fit.
        for i in 2..shape.first_wave().min(UNKNOWNS_MAX) {
            if self.normal.lower[i][i] < WAVE_SHARE_MIN * self.frames {
                self.normal
                    .lower
                    .iter_mut()
                    .take(size)
                    .for_each(|row| row[i] = 0.0);
                self.normal.lower[i] = [0.0; UNKNOWNS_MAX];
                self.normal.lower[i][i] = 1.0;
                self.solution.unknowns[i] = [0.0; CHANNELS_MAX];
            }
        }
        self.normal.factor(product_min);
        self.normal
            .forward_rows(&mut self.solution.unknowns, self.width);
    }

    /// Visits the residual sums of squares of each number of harmonics up to those of `shape`, and
    /// for each of them of each number of curves up to its own, as far as they can be separated.
    #[inline(never)]
    pub fn residuals(&mut self, shape: Shape, visit: &mut dyn FnMut(&Self, Shape, &Values)) {
        let waves = Shape { curves: 0, ..shape };
        let columns = waves.columns(self.harmonics);
        self.factor(&waves, &columns, LIKELIHOOD_PRODUCT_MIN);
        let (normal, rows) = (&self.normal, &self.solution.unknowns);
        // Curves border the equations: each is one more right-hand side, and not another factor.
        let (width, curves) = (self.width.min(CHANNELS_MAX), shape.curves.min(CURVES_MAX));
        let mut borders = [[0.0; UNKNOWNS_MAX]; CURVES_MAX];
        let mut with_channels = [[0.0; CHANNELS_MAX]; CURVES_MAX];
        let mut with_curves = [[0.0; CURVES_MAX]; CURVES_MAX];
        for k in 0..curves {
            for (border, column) in borders[k].iter_mut().zip(&columns).take(normal.size) {
                *border = self.product(CURVES + k, *column);
            }
            normal.forward(&mut borders[k]);
            with_channels[k] = self.rows[CURVES + k];
            for l in 0..=k {
                with_curves[k][l] = self.product(CURVES + k, CURVES + l);
            }
        }
        let (mut residuals, mut from) = (self.squares, 0);
        for harmonics in 0..=shape.harmonics {
            let own = Shape { harmonics, ..waves };
            let to = own.unknowns();
            if to > normal.size {
                return;
            }
            for (i, row) in rows.iter().enumerate().take(to).skip(from) {
                let factors: [f32; CURVES_MAX] =
                    core::array::from_fn(|k| borders[k].get(i).copied().unwrap_or(0.0));
                for (k, factor) in factors.iter().enumerate().take(curves) {
                    for (with, other) in with_curves[k].iter_mut().zip(&factors).take(k + 1) {
                        *with -= factor * other;
                    }
                    for (with, row) in with_channels[k].iter_mut().zip(row).take(width) {
                        *with -= factor * row;
                    }
                }
                for (residual, row) in residuals.iter_mut().zip(row).take(width) {
                    *residual -= row * row;
                }
            }
            from = to;
            self.visit_curves(own, curves, residuals, with_channels, with_curves, visit);
        }
    }

    /// Takes one curve after the other from the residuals.
    fn visit_curves(
        &self,
        shape: Shape,
        most: usize,
        mut residuals: Values,
        mut with_channels: [Values; CURVES_MAX],
        mut with_curves: [[f32; CURVES_MAX]; CURVES_MAX],
        visit: &mut dyn FnMut(&Self, Shape, &Values),
    ) {
        let width = self.width.min(CHANNELS_MAX);
        for curves in 0..=most.min(CURVES_MAX) {
            if let Some(k) = curves.checked_sub(1) {
                let pivot = with_curves[k][k];
                if !(pivot > CURVE_SHARE_MIN * self.products[CURVES + k][CURVES + k]) {
                    return;
                }
                let own = with_channels[k];
                for l in k + 1..CURVES_MAX {
                    let factor = with_curves[l][k] / pivot;
                    for m in k + 1..=l {
                        with_curves[l][m] -= factor * with_curves[m][k];
                    }
                    for (with, own) in with_channels[l].iter_mut().zip(&own).take(width) {
                        *with -= factor * own;
                    }
                }
                for (residual, own) in residuals.iter_mut().zip(&own).take(width) {
                    *residual -= own * own / pivot;
                }
            }
            let mut floored = residuals;
            for (residual, square) in floored.iter_mut().zip(&self.squares).take(width) {
                // Not `f32::max`, which is a call.
                let least = RESIDUAL_SHARE_MIN * square;
                *residual = if *residual > least { *residual } else { least };
            }
            visit(self, Shape { curves, ..shape }, &floored);
        }
    }

    /// Power of the blocks' line at half the frequency beside the latest solution, in units of the
    /// noise: a chi-square of two degrees for each channel if it is not there. Zero without such a
    /// line, or if f32 cannot separate it.
    #[inline(never)]
    pub fn half_power(&mut self) -> f32 {
        let Shape {
            harmonics,
            curves,
            interferer,
        } = self.solution.shape;
        let size = self.solution.shape.unknowns();
        let mut columns = self.solution.shape.columns(self.harmonics);
        let Some(last) = columns.get_mut(size..size + 2) else {
            return 0.0;
        };
        if interferer || self.lines <= self.harmonics {
            return 0.0;
        }
        // Behind all unknowns: forward substitution leaves of its rows what the others have not.
        (last[0], last[1]) = (2 + 2 * self.harmonics, 3 + 2 * self.harmonics);
        let unknowns = self.solution.unknowns;
        self.factor(
            &Shape {
                harmonics,
                curves: curves + 2,
                interferer,
            },
            &columns,
            SOLUTION_PRODUCT_MIN,
        );
        let own = core::mem::replace(&mut self.solution.unknowns, unknowns);
        let Some(own) = own.get(size..self.normal.size) else {
            return 0.0;
        };
        own.iter()
            .flat_map(|row| row.iter().zip(&self.solution.weights))
            .map(|(own, weight)| weight * own * own)
            .sum()
    }

    /// The solution for a shape. None if its equations are singular, or if it has no tone.
    #[inline(never)]
    pub fn solve(&mut self, shape: Shape, least: &Values) -> Option<()> {
        let columns = shape.columns(self.harmonics);
        self.factor(&shape, &columns, SOLUTION_PRODUCT_MIN);
        let size = shape.unknowns();
        let mut projections = [[0.0; UNKNOWNS_MAX]; WAVES];
        for (d, projection) in projections.iter_mut().enumerate().take(2 * shape.harmonics) {
            for (projection, column) in projection.iter_mut().zip(&columns).take(size) {
                *projection = self.u_product(d, *column);
            }
        }
        let (normal, out) = (&self.normal, &mut self.solution);
        (out.nu, out.shape, out.width, out.frames) = (self.nu, shape, self.width, self.frames);
        if normal.size < size || shape.harmonics == 0 {
            return None;
        }
        let freedom = (self.frames - size as f32).max(1.0);
        let width = self.width.min(CHANNELS_MAX);
        let mut explained = [0.0; CHANNELS_MAX];
        for row in out.unknowns.iter().take(size) {
            explained
                .iter_mut()
                .zip(row)
                .take(width)
                .for_each(|(explained, value)| *explained += value * value);
        }
        for c in 0..width {
            let residual = (self.squares[c] - explained[c])
                .max(RESIDUAL_SHARE_MIN * self.squares[c])
                .max(least[c]);
            out.residual_squares[c] = residual;
            out.weights[c] = if residual > 0.0 {
                freedom / residual
            } else {
                0.0
            };
        }
        let waves = 2 * shape.harmonics.min(HARMONICS_MAX);
        let mut gradients = self.u_rows;
        for (projection, gradient) in projections.iter_mut().zip(&mut gradients).take(waves) {
            normal.forward(projection);
            subtract(
                gradient,
                out.unknowns.get(..size).unwrap_or_default(),
                projection,
                1.0,
                width,
            );
        }
        normal.backward_rows(&mut out.unknowns, self.width);
        let first = shape.first_wave();
        let mut columns = [[0.0; UNKNOWNS_MAX]; 2];
        for (column, index) in columns.iter_mut().zip(first..) {
            column[index % UNKNOWNS_MAX] = 1.0;
            normal.forward(column);
        }
        let within = |vector: &[f32; UNKNOWNS_MAX], other: &[f32; UNKNOWNS_MAX]| {
            dot(vector.get(..size).unwrap_or(vector), other)
        };
        let [cos, sin] = &columns;
        out.fundamental = [within(cos, cos), within(sin, sin), within(cos, sin)];
        out.power = [0.0; HARMONICS_MAX];
        let mut line_information = [0.0; HARMONICS_MAX];
        let (mut score, mut information) = (0.0, 0.0);
        for (d, (gradient, projection)) in
            gradients.iter().zip(&projections).enumerate().take(waves)
        {
            let (factor, amplitude) = out.derivative(d);
            let (own, h) = (
                &out.unknowns[(first + d) % UNKNOWNS_MAX],
                d / 2 % HARMONICS_MAX,
            );
            let (mut power, mut weighted) = (0.0, [0.0; CHANNELS_MAX]);
            for c in 0..width {
                weighted[c] = out.weights[c] * amplitude[c];
                score += factor * weighted[c] * gradient[c];
                power += out.weights[c] * own[c] * own[c];
            }
            let weighted = weighted.get(..width).unwrap_or(&weighted);
            for (e, (uu, other_projection)) in self.uu_products[d % WAVES]
                .iter()
                .zip(&projections)
                .enumerate()
                .take(d + 1)
            {
                let (other_factor, other) = out.derivative(e);
                let spread = uu - within(projection, other_projection);
                let part = if e < d { 2.0 } else { 1.0 }
                    * spread
                    * dot(weighted, other)
                    * factor
                    * other_factor;
                information += part;
                if d / 2 == e / 2 {
                    line_information[h] += part;
                }
            }
            out.power[h] += 0.5 * self.frames * power;
        }
        out.line_information = line_information;
        (out.step, out.information) = (score / information, information);
        (information > 0.0).then_some(())
    }
}

impl Solution {
    /// No solution yet. A constant of zeros is written in its place; the result of a function would
    /// be copied.
    pub const NONE: Self = Self {
        nu: 0.0,
        shape: Shape {
            harmonics: 0,
            curves: 0,
            interferer: false,
        },
        width: 0,
        frames: 0.0,
        unknowns: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
        residual_squares: [0.0; CHANNELS_MAX],
        weights: [0.0; CHANNELS_MAX],
        step: 0.0,
        information: 0.0,
        line_information: [0.0; HARMONICS_MAX],
        power: [0.0; HARMONICS_MAX],
        fundamental: [0.0; 3],
    };

    /// The derivative of the model by `nu` is a sum of waves times `u`: the factor of a wave
    /// (cosine and sine of the first harmonic, and so on) is this number times this of each
    /// channel.
    pub fn derivative(&self, wave: usize) -> (f32, &Values) {
        let order = 2.0 * PI * (wave / 2 + 1) as f32;
        let amplitude = &self.unknowns[(self.shape.first_wave() + (wave ^ 1)) % UNKNOWNS_MAX];
        (
            if wave.is_multiple_of(2) {
                order
            } else {
                -order
            },
            amplitude,
        )
    }

    /// Power of the residuals over the noise, by the frames' third differences: its mean over the
    /// channels of which it is known, its harmonic mean, to which a broken channel adds little, and
    /// their number.
    pub fn noise_ratio(&self, statistics: &Statistics, channels: &Channels) -> (f32, f32, f32) {
        let (mut ratio, mut inverse, mut known) = (0.0, 0.0, 0.0);
        for (c, weight) in channels.list().iter().zip(&self.weights) {
            let share = statistics.noise_variance[*c as usize % CHANNELS_MAX] * weight;
            if share > 0.0 {
                (ratio, inverse, known) = (ratio + 1.0 / share, inverse + share, known + 1.0);
            }
        }
        if known > 0.0 {
            (ratio / known, known / inverse, known)
        } else {
            (1.0, 1.0, 0.0)
        }
    }

    /// Power of the residuals over the tone's.
    pub fn remainder(&self) -> f32 {
        self.frames * self.width as f32 / self.power.iter().sum::<f32>().max(f32::MIN_POSITIVE)
    }

    /// Factors of cosine and sine of harmonic `h`, 0 the fundamental, for every channel.
    pub fn harmonic(&self, h: usize) -> (&Values, &Values) {
        let first = (self.shape.first_wave() + 2 * h).min(UNKNOWNS_MAX - 2);
        (&self.unknowns[first], &self.unknowns[first + 1])
    }
}
