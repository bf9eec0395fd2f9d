//! The least-squares solution at one frequency, and the step towards a better one.
//!
//! For a fixed frequency every other unknown is linear, so they are solved for exactly (variable
//! projection) and a Gauss-Newton step moves the frequency alone. Channels count by the inverse of
//! their own residual variance, which makes this the maximum of the likelihood with unknown noise
//! in each channel.

use crate::levels::Levels;
use crate::moments::{HARMONICS_MAX, Moments};
use crate::normal::{Normal, Rows, UNKNOWNS, Vector, dot_all, less_products};
use crate::nuisance::Nuisances;
use crate::significance::ln;
use crate::source::CHANNELS_MAX;
use crate::source::Values;
use crate::waves::{Wave, Weight};
use core::f32::consts::PI;

/// What is fitted at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Harmonics, the fundamental included.
    pub harmonics: usize,
    /// Whether each channel has a slope besides its offset.
    pub slope: bool,
    /// How many of the nuisances each channel has.
    pub nuisances: usize,
}

/// One of the functions that a channel is made of.
#[derive(Clone, Copy)]
enum Function {
    /// A wave.
    Wave(Wave),
    /// `u`.
    Slope,
    /// One of the [`Nuisances`].
    Nuisance(usize),
}

impl Shape {
    /// Unknowns of a channel.
    pub fn unknowns(&self) -> usize {
        self.first_wave() + 2 * self.harmonics
    }

    /// Those before the first harmonic's.
    pub fn first_wave(&self) -> usize {
        1 + self.slope as usize + self.nuisances
    }

    #[inline(always)]
    fn function(&self, index: usize) -> Function {
        let first = self.first_wave();
        match index {
            0 => Function::Wave(Wave::One),
            1 if self.slope => Function::Slope,
            _ if index >= first => Function::Wave(wave(index - first)),
            _ => Function::Nuisance(index - 1 - self.slope as usize),
        }
    }
}

/// Cosine and sine of the harmonics, one after the other.
#[inline(always)]
fn wave(index: usize) -> Wave {
    if index.is_multiple_of(2) { Wave::Cos(index / 2 + 1) } else { Wave::Sin(index / 2 + 1) }
}

/// The least-squares solution at one frequency and the step towards a better one.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Cycles per half stretch ([`crate::frame_span`]).
    pub nu: f32,
    /// What was fitted.
    pub shape: Shape,
    /// Each channel's unknowns: offset beyond [`Levels::offset`], slope, nuisances, cosine and sine of each harmonic.
    pub unknowns: Rows,
    /// Residual sums of squares; 0 for a taxel that takes no part.
    pub residual_sum_of_squares: Values,
    /// Gauss-Newton step in `nu`.
    pub step: f32,
    /// Information about `nu`: the inverse of its variance.
    pub information: f32,
    /// Weighted power of each harmonic.
    pub power: [f32; HARMONICS_MAX],
    /// Where each harmonic alone would rather be, in `nu` from its place.
    pub offset: [f32; HARMONICS_MAX],
    /// Standard deviation of that.
    pub offset_sigma: [f32; HARMONICS_MAX],
    room: Room,
}

/// Waves of the harmonics: a cosine and a sine each.
const WAVES: usize = 2 * HARMONICS_MAX;

/// Where [`Solution::solve`] works; kept, because it need not be emptied every time: what is read has been written
/// before, and the rest counts for nothing.
#[derive(Clone, Debug)]
struct Room {
    normal: Normal,
    /// What each of the derivative's functions has in common with the model's own.
    across: [Vector; WAVES],
    /// What it has in common with what the solution leaves of each channel.
    pulls: [Values; WAVES],
    /// What it is taken times, and the same weighted.
    factors: [Values; WAVES],
    weighted: [Values; WAVES],
}

impl Room {
    #[inline(always)]
    const fn new() -> Self {
        let rows = [[0.0; CHANNELS_MAX]; WAVES];
        let across = [[0.0; UNKNOWNS]; WAVES];
        Self { normal: Normal::new(0), across, pulls: rows, factors: rows, weighted: rows }
    }
}

impl Solution {
    /// Factors of cosine and sine of harmonic `h`, 0 the fundamental, for every taxel.
    pub fn harmonic(&self, h: usize) -> (&Values, &Values) {
        let first = (self.shape.first_wave() + 2 * h).min(UNKNOWNS - 2);
        (&self.unknowns[first], &self.unknowns[first + 1])
    }
}

/// Sum of squares that quantization alone leaves in so many frames: 1/12 of a code squared in each.
pub fn quantization(frames: f32) -> f32 {
    frames / 12.0
}

/// Smallest residual sum of squares that f32 sums can tell from rounding.
fn floor(squares: f32, frames: f32) -> f32 {
    let (rounding, quantization) = (1e-6 * squares, quantization(frames));
    if rounding > quantization { rounding } else { quantization }
}

/// Fills the lower triangle of the normal equations.
#[inline(never)]
fn fill(normal: &mut Normal, moments: &Moments, nuisances: &Nuisances, shape: &Shape) {
    let sums = &moments.trigonometric;
    let first = shape.first_wave();
    for (i, row) in normal.lower.iter_mut().enumerate().take(shape.unknowns()) {
        for (j, place) in row.iter_mut().enumerate().take((i + 1).min(first)) {
            *place = match (shape.function(i), shape.function(j)) {
                (Function::Wave(a), Function::Wave(b)) => sums.product(Weight::One, a, b),
                (Function::Slope, Function::Wave(a)) | (Function::Wave(a), Function::Slope) => {
                    sums.product(Weight::U, a, Wave::One)
                }
                (Function::Slope, Function::Slope) => sums.product(Weight::UU, Wave::One, Wave::One),
                (Function::Nuisance(k), Function::Nuisance(l)) => nuisances.each[k][l],
                (Function::Nuisance(k), Function::Slope) | (Function::Slope, Function::Nuisance(k)) => nuisances.u[k],
                (Function::Nuisance(k), Function::Wave(a)) | (Function::Wave(a), Function::Nuisance(k)) => match a {
                    Wave::One => nuisances.one[k],
                    Wave::Cos(h) => moments.cos[h - 1][CHANNELS_MAX + k],
                    Wave::Sin(h) => moments.sin[h - 1][CHANNELS_MAX + k],
                },
            };
        }
    }
    // Harmonics with each other, two rows at a time; of a harmonic with itself one place above the diagonal too, which
    // nobody reads.
    let rows = normal.lower.get_mut(first..).unwrap_or_default();
    for (h, [cos, sin]) in rows.as_chunks_mut().0.iter_mut().enumerate().take(shape.harmonics) {
        let cos = cos.get_mut(first..).unwrap_or_default().as_chunks_mut().0;
        let sin = sin.get_mut(first..).unwrap_or_default().as_chunks_mut().0;
        for (k, (cos, sin)) in cos.iter_mut().zip(sin).enumerate().take(h + 1) {
            [*cos, *sin] = sums.products(h + 1, k + 1);
        }
    }
}

/// Right-hand sides of the channels' normal equations.
fn right_sides(right: &mut Rows, moments: &Moments, levels: &Levels, nuisances: &Nuisances, shape: &Shape) {
    for (i, right) in right.iter_mut().enumerate().take(shape.unknowns()) {
        let row: &[f32] = match shape.function(i) {
            Function::Wave(Wave::One) => &levels.y,
            Function::Slope => &levels.uy,
            Function::Wave(Wave::Cos(h)) => &moments.cos[h - 1],
            Function::Wave(Wave::Sin(h)) => &moments.sin[h - 1],
            Function::Nuisance(k) => &nuisances.y[k],
        };
        if let Some(row) = row.first_chunk() {
            *right = *row;
        }
    }
}

/// What is left of the channels' squares when `half`, half way to their solution, explains the rest.
pub fn left(levels: &Levels, half: &Rows, size: usize) -> Values {
    let mut residual_sum_of_squares = levels.yy;
    for row in half.iter().take(size) {
        for c in 0..CHANNELS_MAX {
            residual_sum_of_squares[c] -= row[c] * row[c];
        }
    }
    for c in 0..CHANNELS_MAX {
        let least = floor(levels.yy[c], levels.frames as f32);
        // Not `max`, which is a call. NaN gives way too.
        let least = if residual_sum_of_squares[c] > least { residual_sum_of_squares[c] } else { least };
        residual_sum_of_squares[c] = if levels.usable & 1 << c != 0 { least } else { 0.0 };
    }
    residual_sum_of_squares
}

/// Residual sums of squares alone; `bent`: with a bend in steps besides ([`crate::levels::Bend`]). None if the unknowns
/// cannot be told apart.
#[inline(never)]
pub fn residual_sum_of_squares(
    moments: &Moments,
    levels: &Levels,
    nuisances: &Nuisances,
    shape: &Shape,
    bent: bool,
) -> Option<Values> {
    let (size, sums, bend) = (shape.unknowns(), &moments.trigonometric, &levels.bend);
    let steps = if bent { &[Weight::Second, Weight::Third][..] } else { &[] };
    let (mut normal, mut rows) = (Normal::new(size + steps.len()), [[0.0; CHANNELS_MAX]; UNKNOWNS]);
    fill(&mut normal, moments, nuisances, shape);
    right_sides(&mut rows, moments, levels, nuisances, shape);
    for (k, weight) in steps.iter().enumerate() {
        let row = normal.lower.get_mut(size + k)?;
        for (i, place) in row.iter_mut().enumerate().take(size) {
            *place = match shape.function(i) {
                Function::Wave(Wave::One) => bend.one[k],
                Function::Wave(a) => sums.product(*weight, a, Wave::One),
                Function::Slope => bend.u[k],
                // An interferer: next to nothing over whole blocks.
                Function::Nuisance(_) => 0.0,
            };
        }
        row.get_mut(size..size + 2)?.copy_from_slice(&bend.each[k]);
        *rows.get_mut(size + k)? = bend.y[k];
    }
    normal.factor()?;
    normal.forward_rows(&mut rows);
    Some(left(levels, &rows, normal.size))
}

impl Solution {
    /// None yet; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self::NONE
    }

    /// All of it zero: in its place that is emptied, where what a function makes would be copied.
    pub const NONE: Self = {
        let lines = [0.0; HARMONICS_MAX];
        Self {
            nu: 0.0,
            shape: Shape { harmonics: 0, slope: false, nuisances: 0 },
            unknowns: [[0.0; CHANNELS_MAX]; UNKNOWNS],
            residual_sum_of_squares: [0.0; CHANNELS_MAX],
            step: 0.0,
            information: 0.0,
            power: lines,
            offset: lines,
            offset_sigma: lines,
            room: Room::new(),
        }
    };

    /// Residual sums of squares that so many harmonics leave, from none on up to those of `shape`, or to as many as can be
    /// told apart. No solution is left.
    #[inline(never)]
    pub fn residual_sums(
        &mut self,
        moments: &Moments,
        levels: &Levels,
        nuisances: &Nuisances,
        shape: &Shape,
        visit: &mut dyn FnMut(usize, &Values),
    ) {
        let Self { unknowns: rows, room: Room { normal, .. }, .. } = self;
        normal.size = shape.unknowns().min(UNKNOWNS);
        fill(normal, moments, nuisances, shape);
        right_sides(rows, moments, levels, nuisances, shape);
        // Waves come last, so that the factor of fewer of them is a corner of this one.
        normal.factor_some();
        normal.forward_rows(rows);
        for harmonics in 0..=shape.harmonics {
            let size = Shape { harmonics, ..*shape }.unknowns();
            if size <= normal.size {
                visit(harmonics, &left(levels, rows, size));
            }
        }
    }

    /// What noise of variance 1 makes of the fundamental's factors: variance of the cosine's and of the sine's, and
    /// their covariance. The same in every channel. None before there is a solution with a wave.
    #[inline(never)]
    pub fn fundamental_covariance(&self) -> Option<[f32; 3]> {
        // Half ways to the columns of the inverse: their products are its elements.
        let mut columns = [[0.0; UNKNOWNS]; 2];
        for (column, index) in columns.iter_mut().zip(self.shape.first_wave()..) {
            *column.get_mut(index)? = 1.0;
            self.room.normal.forward(column);
        }
        let [cos, sin] = &columns;
        Some([dot_all(cos, cos), dot_all(sin, sin), dot_all(cos, sin)])
    }

    /// Solves at the frequency `nu` of `moments`, which without harmonics there is none of. None if the unknowns
    /// cannot be told apart there.
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
        let Self { unknowns: rows, room: Room { normal, across, pulls, factors, weighted }, .. } = self;
        normal.size = size.min(UNKNOWNS);
        fill(normal, moments, nuisances, &shape);
        normal.factor()?;
        right_sides(rows, moments, levels, nuisances, &shape);
        normal.forward_rows(rows);
        let residual_sum_of_squares = left(levels, rows, size);
        let mut weight = [0.0; CHANNELS_MAX];
        for c in 0..CHANNELS_MAX {
            weight[c] = if residual_sum_of_squares[c] > 0.0 {
                (frames - size as f32).max(1.0) / residual_sum_of_squares[c]
            } else {
                0.0
            };
        }

        // d model / d nu is a mixture of u cos(h theta) and u sin(h theta).
        let waves = 2 * shape.harmonics.min(HARMONICS_MAX);
        for d in 0..waves {
            let along = if d % 2 == 0 { &moments.u_cos[d / 2] } else { &moments.u_sin[d / 2] };
            // Zero behind the last: products of these take all.
            across[d] = [0.0; UNKNOWNS];
            for (i, across) in across[d].iter_mut().enumerate().take(size) {
                *across = match shape.function(i) {
                    Function::Wave(b) => sums.product(Weight::U, wave(d), b),
                    Function::Slope => sums.product(Weight::UU, wave(d), Wave::One),
                    Function::Nuisance(k) => along[CHANNELS_MAX + k],
                };
            }
            normal.forward(&mut across[d]);
            if let Some(along) = along.first_chunk() {
                pulls[d] = less_products(along, &across[d][..size], &rows[..]);
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
        let mut line_pull = [0.0; HARMONICS_MAX];
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
            line_pull[d / 2] += dot_all(&weighted[d], &pulls[d]);
            for e in 0..=d {
                let common = dot_all(&across[d], &across[e]);
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
        self.step = line_pull.iter().sum::<f32>() / self.information;
        for h in 0..waves / 2 {
            if line_information[h] > 0.0 {
                self.offset[h] = (h + 1) as f32 * line_pull[h] / line_information[h];
                self.offset_sigma[h] = (h + 1) as f32 / libm::sqrtf(line_information[h]);
            }
        }
        Some(())
    }
}

impl Default for Solution {
    fn default() -> Self {
        Self::new()
    }
}

/// Residuals over the frames' own noise ([`Levels::rough`]) from which there is more in the channels than is
/// modelled.
const MISFIT: f32 = 1.5;

/// Sums of squares `rest`, left by so many `unknowns` of a channel, over the channels' noise ([`Levels::rough`]): 1 if
/// they are nothing else. None if the noise is not known.
#[inline(never)]
pub fn over_noise(levels: &Levels, residual_sum_of_squares: &Values, unknowns: usize) -> Option<f32> {
    let freedom = (levels.frames as f32 - unknowns as f32).max(1.0);
    let (mut sum, mut channels) = (0.0, 0.0);
    for c in 0..CHANNELS_MAX {
        if levels.usable & 1 << c != 0 && levels.rough[c] > 0.0 {
            sum += residual_sum_of_squares[c] / (freedom * levels.rough[c]);
            channels += 1.0;
        }
    }
    (channels > 0.0).then_some(sum / channels)
}

/// Whether there is more in the channels than is modelled, by [`over_noise`].
pub fn is_misfit(over_noise: Option<f32>) -> bool {
    over_noise.is_some_and(|over| over > MISFIT)
}

/// Log-likelihood gained by what leaves the sums of squares `rest` with so many `unknowns` of a channel,
/// over what left `before`: negative where `before` is likelier. Bartlett's factor is in it: the logarithm of few frames
/// overstates what so many unknowns explain.
#[inline(never)]
pub fn gain(levels: &Levels, before: &Values, residual_sum_of_squares: &Values, unknowns: usize) -> f32 {
    let factor = (levels.frames as f32 - unknowns as f32).max(0.0);
    let mut sum = 0.0;
    // The logarithm of four at once: a residual is no less than a millionth of its squares, so f32 holds their product.
    for group in 0..CHANNELS_MAX / 4 {
        let mut product = 1.0;
        for c in 4 * group..4 * group + 4 {
            if levels.usable & 1 << c != 0 && residual_sum_of_squares[c] > 0.0 && before[c] > 0.0 {
                product *= before[c] / residual_sum_of_squares[c];
            }
        }
        sum += ln(product);
    }
    0.5 * factor * sum
}
