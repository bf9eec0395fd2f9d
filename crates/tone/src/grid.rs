//! Below four cycles a window a tone, its harmonics and a curved baseline resemble each other:
//! their exact likelihoods on a grid of frequencies, from the window's pieces.
//!
//! The pieces of a few channels and the curves are folded about the window's centre: a cosine needs
//! the sums of mirror images alone, and a sine their differences.

use crate::blocks::Lines;
use crate::curves::curves;
use crate::limits::{
    CANDIDATES_MAX, CHANNELS_MAX, CHANNELS_SEARCHED, CURVES_MAX, HARMONICS_MAX, PIECES_MAX,
};
use crate::models::{Models, SIDES, SIZE};
use crate::phase::{cos_sin, from_turns};
use crate::refine::likelihood;
use crate::significance::ln;
use crate::source::Values;
use crate::statistics::{Channels, Statistics};
use heapless::Vec;

/// Series that meet the waves: the right-hand sides, which are channels and curves; level and
/// slope.
const SERIES: usize = SIDES + 2;
const LEVEL: usize = SIDES;
/// Cycles in the window from which the grid begins, and its step.
const FIRST_CYCLES: f32 = 0.57;
const STEP_CYCLES: f32 = 0.19;
/// Its steps; the last has 3.61 cycles.
const STEPS: usize = 17;
/// With at least this number of harmonics it has points between two whose scores are less than this
/// below the best.
const FINE_HARMONICS: usize = 3;
const FINE_SCORE: f32 = 12.0;
/// Most points, with those at candidates of the periodogram.
pub const POINTS: usize = 2 * STEPS + CANDIDATES_MAX;

/// Points between those of the grid, for each candidate; a step that is too short for one, cycles
/// per half window.
const REFINEMENTS: usize = 2;
const TINY: f32 = 0.003;

/// The likelihood at a frequency, by the best number of harmonics and the best baseline.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Cycles per half window.
    pub nu: f32,
    /// Log-likelihood less a penalty for each unknown.
    pub score: f32,
}

impl Default for Point {
    fn default() -> Self {
        Self {
            nu: 0.0,
            score: f32::NEG_INFINITY,
        }
    }
}

/// Sums of mirror images, and differences.
pub type Folded = [[f32; SERIES]; 2];

/// The pieces of a window.
pub struct Grid<'g> {
    folded: &'g mut [Folded],
    rows: usize,
    pieces: f32,
    /// Their logarithm.
    ln_pieces: f32,
    /// `u` from one piece to the next.
    step: f32,
    width: usize,
    inverse_squares: [f32; CHANNELS_SEARCHED],
    /// Squares of the curves.
    curves: [f32; CURVES_MAX],
    harmonics: usize,
    interferer: Option<f32>,
    /// Without a tone.
    models: Models,
    /// The score of those.
    pub baseline: f32,
}

impl<'g> Grid<'g> {
    /// Without pieces, with memory for them. It is filled in its place: as a result of `fill` it
    /// would be copied.
    #[inline(always)]
    pub const fn empty(folded: &'g mut [Folded]) -> Self {
        Self {
            folded,
            rows: 0,
            pieces: 0.0,
            ln_pieces: 0.0,
            step: 0.0,
            width: 0,
            inverse_squares: [0.0; CHANNELS_SEARCHED],
            curves: [0.0; CURVES_MAX],
            harmonics: 0,
            interferer: None,
            models: Models::NONE,
            baseline: 0.0,
        }
    }

    /// Takes the pieces of some channels, for a greatest number of harmonics and an interferer,
    /// with curves or without.
    #[inline(never)]
    pub fn fill(
        &mut self,
        pieces: &[Values],
        statistics: &Statistics,
        channels: &Channels,
        (harmonics, interferer): (usize, Option<f32>),
        is_curved: bool,
    ) {
        let count = pieces.len().min(PIECES_MAX).min(2 * self.folded.len());
        (self.rows, self.pieces, self.step) =
            (count.div_ceil(2), count as f32, statistics.piece_step);
        self.ln_pieces = ln(self.pieces);
        self.width = channels.list().len().min(CHANNELS_SEARCHED);
        (self.harmonics, self.interferer, self.baseline) =
            (harmonics, interferer, f32::NEG_INFINITY);
        let mut units = [(0, 0.0); CHANNELS_SEARCHED];
        for (unit, c) in units.iter_mut().zip(channels.list()) {
            let c = *c as usize % CHANNELS_MAX;
            *unit = (
                c,
                libm::sqrtf(statistics.frames as f32 / statistics.about_line[c]),
            );
        }
        let mut products = [[0.0; SERIES]; SERIES];
        for row in 0..self.rows {
            // From the centre outwards; of an odd number the middle one is its own mirror image.
            let (after, before) = (count / 2 + row, (count - 1) / 2 - row);
            let u = (0.5 * (after as f32 - before as f32)) * self.step;
            let share = if after == before { 0.5 } else { 1.0 };
            let at = |piece: usize, u: f32| series(pieces, piece, u, &units, is_curved);
            let (mut one, mut other) = (at(after, u), at(before, -u));
            one.iter_mut()
                .chain(&mut other)
                .for_each(|value| *value *= share);
            if let Some([sums, differences]) = self.folded.get_mut(row) {
                for s in 0..SERIES {
                    (sums[s], differences[s]) = (one[s] + other[s], one[s] - other[s]);
                }
            }
            // Products of both, and only once of a middle one.
            let weight = 1.0 / share;
            for s in 0..SERIES {
                // Of the channels with each other squares alone.
                for t in (if s < CHANNELS_SEARCHED { s } else { 0 })..=s {
                    products[s][t] += weight * (one[s] * one[t] + other[s] * other[t]);
                }
            }
        }
        // A channel that is not there is explained.
        for c in self.width..CHANNELS_SEARCHED {
            products[c][c] = 1.0;
        }
        self.inverse_squares = core::array::from_fn(|c| 1.0 / products[c][c]);
        self.curves =
            core::array::from_fn(|k| products[CHANNELS_SEARCHED + k][CHANNELS_SEARCHED + k]);
        self.models = Models::new(core::array::from_fn(|s| {
            core::array::from_fn(|t| products[s][t])
        }));
        let mut own = [[0.0; SIZE]; 2];
        [own[0][0], own[1][0]] = [products[LEVEL][LEVEL], products[LEVEL + 1][LEVEL + 1]];
        let is_whole = self
            .models
            .add(&own, [&products[LEVEL], &products[LEVEL + 1]], self.pieces);
        if let Some(nu) = interferer {
            let (turns, before) = (nu * self.step, self.models);
            let transform = self.transform(turns);
            let own = products_with(&transform, &[], (self.pieces, self.sum(2.0 * turns)));
            if !self
                .models
                .add(&own, [&transform[0], &transform[1]], self.pieces)
            {
                // Folded to next to nothing by the pieces' rate it is a part of the baseline.
                (self.models, self.interferer) = (before, None);
            }
        }
        if is_whole {
            self.baseline = self.score(&self.models);
        }
    }

    /// Sums of every series times cosine and sine of a wave of `turns` turns from one piece to the
    /// next.
    #[inline(never)]
    fn transform(&self, turns: f32) -> [[f32; SERIES]; 2] {
        let mut sums = [[0.0; SERIES]; 2];
        let odd = self.pieces as usize % 2 == 1;
        let (mut cos, mut sin) = cos_sin(from_turns(if odd { 0.0 } else { 0.5 * turns }));
        let (cos_1, sin_1) = cos_sin(from_turns(turns));
        for [even, odd] in self.folded.iter().take(self.rows) {
            for s in 0..SERIES {
                sums[0][s] += cos * even[s];
                sums[1][s] += sin * odd[s];
            }
            (cos, sin) = (cos * cos_1 - sin * sin_1, sin * cos_1 + cos * sin_1);
        }
        sums
    }

    /// Sum of the cosines of a wave of `turns` turns from one piece to the next.
    fn sum(&self, turns: f32) -> f32 {
        let (_, sin) = cos_sin(from_turns(0.5 * turns));
        let (_, all) = cos_sin(from_turns(0.5 * turns * self.pieces));
        if sin.abs() > 1e-6 {
            all / sin
        } else {
            self.pieces
        }
    }

    /// The points and those at other frequencies, from the lowest frequency on.
    pub fn points(&self, others: impl Iterator<Item = f32>) -> Vec<Point, POINTS> {
        // A line alone is as wide as two cycles: every other point shows it.
        let stride = if self.harmonics == 1 { 2 } else { 1 };
        let cycles = (0..STEPS)
            .step_by(stride)
            .map(|k| FIRST_CYCLES + STEP_CYCLES * k as f32);
        let mut points: Vec<Point, POINTS> = Vec::new();
        for nu in cycles
            .map(|cycles| cycles / (self.pieces * self.step))
            .chain(others)
        {
            insert(&mut points, self.point(nu));
        }
        // Summits of many harmonics are narrower than the grid: it is finer where it is likely.
        if self.harmonics >= FINE_HARMONICS {
            let best = points
                .iter()
                .fold(f32::NEG_INFINITY, |best, point| best.max(point.score));
            // From the last on: what is put in moves none that is to come.
            for k in (1..points.len()).rev() {
                if let Some([one, other]) = points.get(k - 1..=k)
                    && one.score.min(other.score) > best - FINE_SCORE
                {
                    let nu = 0.5 * (one.nu + other.nu);
                    insert(&mut points, self.point(nu));
                }
            }
        }
        points
    }

    /// The likeliest point between three, of which the middle one is the likeliest.
    pub fn refine(&self, [mut before, mut this, mut after]: [Point; 3]) -> Point {
        for _ in 0..REFINEMENTS {
            // Residuals, by one that is 1, are nearly a parabola where their logarithm is none.
            let share = -2.0 / (self.pieces * self.width as f32);
            let residual = |point: &Point| libm::expf(share * (point.score - this.score)) - 1.0;
            let (left, right) = (this.nu - before.nu, after.nu - this.nu);
            let (below, above) = (residual(&before) / left, residual(&after) / right);
            let between = 0.5 * (below * right - above * left) / (below + above);
            if !between.is_finite() || !(between.abs() > TINY) {
                break;
            }
            let next = self.point(this.nu + between.max(-0.8 * left).min(0.8 * right));
            let (worse, is_left) = match next.score > this.score {
                true => (core::mem::replace(&mut this, next), between > 0.0),
                false => (next, between < 0.0),
            };
            *if is_left { &mut before } else { &mut after } = worse;
        }
        this
    }

    /// The likelihood at a frequency.
    #[inline(never)]
    fn point(&self, nu: f32) -> Point {
        let turns = nu * self.step;
        // Harmonics must stay below half the rate of the pieces, and beside an interferer there is
        // one less.
        let lines = Lines {
            nu,
            harmonics: self.harmonics,
            interferer: self.interferer,
        }
        .all(false)
        .1;
        let most = ((0.48 / turns) as usize)
            .min(lines.saturating_sub(self.interferer.is_some() as usize))
            .max(1);
        // Of the harmonics with each other all sums are those of a multiple of the fundamental.
        let mut multiples = [self.pieces; 2 * HARMONICS_MAX + 1];
        for (m, multiple) in multiples.iter_mut().enumerate().take(2 * most + 1).skip(1) {
            *multiple = self.sum(m as f32 * turns);
        }
        let (mut models, mut score) = (self.models, f32::NEG_INFINITY);
        for order in 1..=most {
            let transform = self.transform(order as f32 * turns);
            let mut others: Vec<(f32, f32), SIZE> = Vec::new();
            if let Some(interferer) = self.interferer {
                let (own, other) = (order as f32 * turns, interferer * self.step);
                let _ = others.push((self.sum(own - other), self.sum(own + other)));
            }
            let multiple = |m: usize| multiples.get(m).copied().unwrap_or(0.0);
            for other in 1..order {
                let _ = others.push((multiple(order - other), multiple(order + other)));
            }
            let own = products_with(&transform, &others, (multiple(0), multiple(2 * order)));
            if !models.add(&own, [&transform[0], &transform[1]], self.pieces) {
                break;
            }
            score = score.max(self.score(&models));
        }
        Point { nu, score }
    }

    /// The score of models by the best number of curves.
    fn score(&self, models: &Models) -> f32 {
        let (mut best, mut unknowns) = (f32::NEG_INFINITY, 2 * models.size);
        models.residuals(&self.curves, &self.inverse_squares, &mut |product| {
            let score = likelihood((self.pieces, self.ln_pieces), self.width, product, unknowns);
            best = if score > best { score } else { best };
            unknowns += 1;
        });
        best
    }
}

/// Puts a point to its place by frequency.
fn insert(points: &mut Vec<Point, POINTS>, mut point: Point) {
    let place = points
        .iter()
        .position(|other| other.nu > point.nu)
        .unwrap_or(points.len());
    points
        .iter_mut()
        .skip(place)
        .for_each(|other| core::mem::swap(other, &mut point));
    let _ = points.push(point);
}

/// A piece of every series.
fn series(
    pieces: &[Values],
    piece: usize,
    u: f32,
    units: &[(usize, f32); CHANNELS_SEARCHED],
    is_curved: bool,
) -> [f32; SERIES] {
    let mut series = [0.0; SERIES];
    if let Some(values) = pieces.get(piece) {
        for (value, (c, unit)) in series.iter_mut().zip(units) {
            *value = values[*c % CHANNELS_MAX] * unit;
        }
    }
    let [.., first, second, third, level, slope] = &mut series;
    let [a, b, c] = if is_curved {
        curves(u)
    } else {
        [[0.0; 2]; CURVES_MAX]
    };
    (*level, *slope, *first, *second, *third) = (1.0, u, a[0], b[0], c[0]);
    series
}

/// Products of a wave's cosine and of its sine with level or slope, with other waves, and with
/// itself, from the sums of the cosines of their differences and sums.
fn products_with(
    transform: &[[f32; SERIES]; 2],
    others: &[(f32, f32)],
    own: (f32, f32),
) -> [[f32; SIZE]; 2] {
    let mut products = [[0.0; SIZE]; 2];
    [products[0][0], products[1][0]] = [transform[0][LEVEL], transform[1][LEVEL + 1]];
    for (i, (apart, both)) in others.iter().chain([&own]).enumerate() {
        for (products, sign) in products.iter_mut().zip([0.5, -0.5]) {
            if let Some(product) = products.get_mut(1 + i) {
                *product = 0.5 * apart + sign * both;
            }
        }
    }
    products
}
