//! Sums over all blocks of products of lines with each other and with the baselines.
//!
//! Products of two lines are sums of multiples of the phase, so a few numbers suffice: cosine and
//! sine of each multiple, and of each line with each baseline.

use crate::limits::{DEGREE_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::phase::{Wave, line_products};
use crate::solve::Shape;

/// Number of multiples of the unit line whose sums are kept.
pub const WAVES: usize = 2 * HARMONICS_MAX + 4;

/// Maximum number of functions of the lines: cosine and sine of each.
pub const LINE_FUNCTIONS: usize = 2 * HARMONICS_MAX;
/// Products of functions of the lines.
pub type OfLines = Square<LINE_FUNCTIONS>;
/// A row for each function of the lines, a column for each unknown.
pub type OfModel = [[f32; UNKNOWNS_MAX]; LINE_FUNCTIONS];

/// Maximum length of a list of totals.
pub const LIST_MAX: usize = 2 * (2 * HARMONICS_MAX + 1) + (DEGREE_MAX + 1) * LINE_FUNCTIONS;

#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Sums of the multiples of the phase.
    pub waves: [Wave; WAVES],
    /// Products of each line with each baseline.
    pub baselines: [[Wave; DEGREE_MAX + 1]; HARMONICS_MAX],
}

impl Totals {
    /// Writes the products of a shape's lines with all its functions into rows.
    pub fn of_shape(&self, shape: &Shape, products: &mut [[f32; UNKNOWNS_MAX]]) {
        let first = shape.first_line();
        let rows = products.as_chunks_mut::<2>().0.iter_mut();
        for ((line, baselines), rows) in shape.lines.iter().zip(&self.baselines).zip(rows) {
            for (j, wave) in baselines.iter().enumerate().take(first) {
                (rows[0][j], rows[1][j]) = (wave[0], wave[1]);
            }
            for (j, other) in shape.lines.iter().enumerate().take(HARMONICS_MAX) {
                let product = line_products(&self.waves, line, other);
                for (row, product) in rows.iter_mut().zip(product) {
                    row[first + 2 * j] = product[0];
                    row[first + 2 * j + 1] = product[1];
                }
            }
        }
    }

    /// Writes the totals of a shape as a list.
    pub fn list(&self, shape: &Shape, list: &mut [f32]) {
        let waves = self.waves.iter().take(2 * shape.lines.max() + 1);
        let baselines = self.baselines.iter().take(shape.lines.count());
        let baselines = baselines.flat_map(|row| row.iter().take(shape.first_line()));
        let numbers = waves.chain(baselines).flatten();
        list.iter_mut()
            .zip(numbers)
            .for_each(|(place, x)| *place = *x);
    }
}

pub fn list_len(shape: &Shape) -> usize {
    2 * (2 * shape.lines.max() + 1) + 2 * shape.lines.count() * shape.first_line()
}

/// Computes the products of a shape's lines with all its functions from a list of totals.
#[inline(never)]
pub fn unfold(shape: &Shape, list: &[f32], products: &mut OfModel) {
    let mut totals = Totals::default();
    let Some((waves, baselines)) = list.split_at_checked(2 * (2 * shape.lines.max() + 1)) else {
        return;
    };
    let pairs = totals.waves.as_flattened_mut().iter_mut().zip(waves);
    pairs.for_each(|(place, x)| *place = *x);
    let rows = baselines.chunks_exact(2 * shape.first_line());
    for (own, row) in totals.baselines.iter_mut().zip(rows) {
        let pairs = own.as_flattened_mut().iter_mut().zip(row);
        pairs.for_each(|(place, x)| *place = *x);
    }
    totals.of_shape(shape, products);
}

/// Adjoint of [`unfold`]: the product of `list` with a list of totals is the product of `weights`
/// with the unfolded rows.
#[inline(never)]
pub fn fold(shape: &Shape, weights: &OfModel, list: &mut [f32; LIST_MAX]) {
    let first = shape.first_line();
    let by_wave = by_wave(weights, first, shape.lines);
    let Some((waves, baselines)) = list.split_at_mut_checked(2 * (2 * shape.lines.max() + 1))
    else {
        return;
    };
    let pairs = waves.iter_mut().zip(by_wave.as_flattened());
    pairs.for_each(|(place, x)| *place = *x);
    let rows = baselines.chunks_exact_mut(2 * first);
    for (row, [cos, sin]) in rows.zip(weights.as_chunks::<2>().0) {
        let pairs = row.as_chunks_mut::<2>().0.iter_mut();
        for (pair, (cos, sin)) in pairs.zip(cos.iter().zip(sin)) {
            *pair = [*cos, *sin];
        }
    }
}

/// Coefficients of the multiples of the phase in a weighted sum of all products of two lines; the
/// lines' columns begin at `first`.
pub fn by_wave<const N: usize>(
    weights: &[[f32; N]; LINE_FUNCTIONS],
    first: usize,
    lines: Lines,
) -> [Wave; WAVES] {
    let mut by_wave = [[0.0; 2]; WAVES];
    for (one, [cos, sin]) in lines.iter().zip(weights.as_chunks::<2>().0) {
        let [of_cos, of_sin] =
            [cos, sin].map(|row| row.get(first..).unwrap_or_default().as_chunks::<2>().0);
        for (other, ([cc, cs], [sc, ss])) in lines.iter().zip(of_cos.iter().zip(of_sin)) {
            let sign = if one < other { -0.5 } else { 0.5 };
            let difference = &mut by_wave[one.abs_diff(other) % WAVES];
            difference[0] += 0.5 * (cc + ss);
            difference[1] += sign * (sc - cs);
            let sum = &mut by_wave[(one + other) % WAVES];
            sum[0] += 0.5 * (cc - ss);
            sum[1] += 0.5 * (cs + sc);
        }
    }
    by_wave
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folded_list_weighs_as_the_rows_do() {
        let shape = Shape {
            lines: Lines::up_to(3).with(5),
            degree: 2,
        };
        let mut totals = Totals::default();
        let mut number = 0.0;
        let mut next = || {
            number += 1.0;
            libm::cosf(number * number)
        };
        let waves = totals.waves.as_flattened_mut();
        waves.iter_mut().for_each(|x| *x = next());
        // The sine of zero is zero.
        totals.waves[0][1] = 0.0;
        let baselines = totals.baselines.as_flattened_mut().as_flattened_mut();
        baselines.iter_mut().for_each(|x| *x = next());
        let mut weights = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
        for row in weights.iter_mut().take(2 * shape.lines.count()) {
            row[..shape.unknowns()].iter_mut().for_each(|x| *x = next());
        }
        let mut rows = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
        totals.of_shape(&shape, &mut rows);
        let products = rows.as_flattened().iter().zip(weights.as_flattened());
        let wanted: f32 = products.map(|(x, y)| x * y).sum();
        let [mut list, mut folded] = [[0.0; LIST_MAX]; 2];
        totals.list(&shape, &mut list);
        fold(&shape, &weights, &mut folded);
        let pairs = list.iter().zip(&folded).take(list_len(&shape));
        let got: f32 = pairs.map(|(x, y)| x * y).sum();
        assert!((got - wanted).abs() < 1e-4, "{got} {wanted}");
    }
}
