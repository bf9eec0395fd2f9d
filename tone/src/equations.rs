//! The normal equations of the channels at one frequency, and the residual sums of squares that follow from them.

use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, UNKNOWNS_MAX};
use crate::moments::Moments;
use crate::normal::{Normal, Rows};
use crate::nuisance::Nuisances;
use crate::source::Values;
use crate::waves::{Wave, Weight};

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

/// One of the functions whose sum a channel is.
#[derive(Clone, Copy)]
pub enum Function {
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

    /// Unknowns before the first harmonic's.
    pub fn first_wave(&self) -> usize {
        1 + self.slope as usize + self.nuisances
    }

    #[inline(always)]
    pub fn function(&self, index: usize) -> Function {
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
pub fn wave(index: usize) -> Wave {
    if index.is_multiple_of(2) { Wave::Cos(index / 2 + 1) } else { Wave::Sin(index / 2 + 1) }
}

/// Sum of squares that quantization alone leaves: a twelfth of a step squared in each frame.
pub fn quantization_squares(levels: &Levels) -> f32 {
    let step = levels.quantization_step;
    levels.frames as f32 * (step * step) / 12.0
}

/// Fills the lower triangle of the normal equations.
#[inline(never)]
pub fn fill(normal: &mut Normal, moments: &Moments, nuisances: &Nuisances, shape: &Shape) {
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
    // Harmonics with each other, two rows at a time; this fills one place above the diagonal too, which nobody reads.
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
pub fn right_sides(right: &mut Rows, moments: &Moments, levels: &Levels, nuisances: &Nuisances, shape: &Shape) {
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

/// Residual sums of squares of the first `size` unknowns, from the right-hand sides after forward substitution; no less
/// than quantization, and what f32 can distinguish from the rounding of the sums.
pub fn residual_sums_of_squares(levels: &Levels, forward: &Rows, size: usize) -> Values {
    let (mut residual_sum_of_squares, quantization) = (levels.yy, quantization_squares(levels));
    for row in forward.iter().take(size) {
        for c in 0..CHANNELS_MAX {
            residual_sum_of_squares[c] -= row[c] * row[c];
        }
    }
    for c in 0..CHANNELS_MAX {
        // Not `max`, which is a call. A NaN is replaced too.
        let rounding = 1e-6 * levels.yy[c];
        let least = if rounding > quantization { rounding } else { quantization };
        let least = if residual_sum_of_squares[c] > least { residual_sum_of_squares[c] } else { least };
        residual_sum_of_squares[c] = if levels.usable & 1 << c != 0 { least } else { 0.0 };
    }
    residual_sum_of_squares
}

/// Residual sums of squares without a solution; if `bent`, with the steps of a bend in addition
/// ([`crate::sums::Bend`]). None if the equations are singular.
#[inline(never)]
pub fn residual_sums_without_solution(
    moments: &Moments,
    levels: &Levels,
    nuisances: &Nuisances,
    shape: &Shape,
    bent: bool,
) -> Option<Values> {
    let (size, sums, bend) = (shape.unknowns(), &moments.trigonometric, &levels.bend);
    let steps = if bent { &[Weight::Second, Weight::Third][..] } else { &[] };
    let (mut normal, mut rows) = (Normal::new(size + steps.len()), [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX]);
    fill(&mut normal, moments, nuisances, shape);
    right_sides(&mut rows, moments, levels, nuisances, shape);
    for (k, weight) in steps.iter().enumerate() {
        let row = normal.lower.get_mut(size + k)?;
        for (i, place) in row.iter_mut().enumerate().take(size) {
            *place = match shape.function(i) {
                Function::Wave(Wave::One) => bend.one[k],
                Function::Wave(a) => sums.product(*weight, a, Wave::One),
                Function::Slope => bend.u[k],
                // An interferer: its sums over complete blocks are almost zero.
                Function::Nuisance(_) => 0.0,
            };
        }
        row.get_mut(size..size + 2)?.copy_from_slice(&bend.each[k]);
        *rows.get_mut(size + k)? = bend.y[k];
    }
    normal.factor()?;
    normal.forward_rows(&mut rows);
    Some(residual_sums_of_squares(levels, &rows, normal.size))
}
