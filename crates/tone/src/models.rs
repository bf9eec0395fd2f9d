//! All models of a frequency in one factor: ever more lines, and with each number of them ever more
//! curves.
//!
//! About the window's centre a cosine is even and a sine is odd: there are two systems of half the
//! size. A curve is one more right-hand side of both.

use crate::limits::{CHANNELS_SEARCHED, CURVES_MAX, LINES_MAX};
use crate::solve::{CURVE_SHARE_MIN, LIKELIHOOD_PRODUCT_MIN, RESIDUAL_SHARE_MIN, WAVE_SHARE_MIN};

/// Right-hand sides: channels, and behind them curves.
pub const SIDES: usize = CHANNELS_SEARCHED + CURVES_MAX;
/// Most unknowns of a system: level or slope, and the lines.
pub const SIZE: usize = 1 + LINES_MAX;
/// A pivot must be more than this share of its diagonal element.
const PIVOT_SHARE_MIN: f32 = 1e-6;

/// The even or the odd system, factored as far as it goes; the diagonal has reciprocals.
#[derive(Clone, Copy)]
struct Half {
    lower: [[f32; SIZE]; SIZE],
    /// The right-hand sides behind forward substitution.
    sides: [[f32; SIDES]; SIZE],
}

/// The models of a frequency.
#[derive(Clone, Copy)]
pub struct Models {
    halves: [Half; 2],
    /// Unknowns of each half.
    pub size: usize,
    /// The share of each unknown that is its own, multiplied.
    product: f32,
    /// Products of the sides with each other, less what the unknowns explain: the lower triangle.
    rest: [[f32; SIDES]; SIDES],
}

impl Models {
    /// Of nothing.
    pub const NONE: Self = Self {
        halves: [Half {
            lower: [[0.0; SIZE]; SIZE],
            sides: [[0.0; SIDES]; SIZE],
        }; 2],
        size: 0,
        product: 0.0,
        rest: [[0.0; SIDES]; SIDES],
    };

    /// Without unknowns: products of the sides.
    pub fn new(rest: [[f32; SIDES]; SIDES]) -> Self {
        Self {
            product: 1.0,
            rest,
            ..Self::NONE
        }
    }

    /// One unknown more in each half, the even one first: its products with those that are there
    /// and behind them with itself, and its right-hand sides. False if f32 cannot separate it from
    /// them. A wave whose square is next to nothing counts as none: folded onto half the frame rate
    /// an interferer has one phase only.
    #[inline(never)]
    pub fn add(&mut self, products: &[[f32; SIZE]; 2], sides: [&[f32]; 2], count: f32) -> bool {
        let size = self.size % SIZE;
        for ((half, products), sides) in self.halves.iter_mut().zip(products).zip(sides) {
            let diagonal = products.get(size).copied().unwrap_or(0.0);
            if diagonal < WAVE_SHARE_MIN * count && size > 0 {
                continue;
            }
            let (known, rows) = half.lower.split_at_mut(size);
            let (known_sides, side_rows) = half.sides.split_at_mut(size);
            let (Some(row), Some(side)) = (rows.first_mut(), side_rows.first_mut()) else {
                return false;
            };
            side.iter_mut()
                .zip(sides)
                .for_each(|(side, value)| *side = *value);
            let mut pivot = diagonal;
            for (j, ((above, known_side), product)) in known
                .iter()
                .zip(known_sides.iter())
                .zip(products)
                .enumerate()
            {
                let done = row
                    .iter()
                    .zip(above)
                    .take(j)
                    .map(|(a, b)| a * b)
                    .sum::<f32>();
                let factor = (product - done) * above[j % SIZE];
                row[j % SIZE] = factor;
                pivot -= factor * factor;
                side.iter_mut()
                    .zip(known_side)
                    .for_each(|(side, known)| *side -= factor * known);
            }
            self.product *= pivot / diagonal;
            if !(pivot > PIVOT_SHARE_MIN * diagonal && self.product > LIKELIHOOD_PRODUCT_MIN) {
                return false;
            }
            let inverse = 1.0 / libm::sqrtf(pivot);
            row[size] = inverse;
            side.iter_mut().for_each(|side| *side *= inverse);
            for (s, rest) in self.rest.iter_mut().enumerate() {
                for (rest, other) in rest.iter_mut().zip(side.iter()).take(s + 1) {
                    *rest -= side[s] * other;
                }
            }
        }
        self.size += 1;
        true
    }

    /// Visits the product over the channels of their residuals' shares, without and with ever more
    /// curves, as far as those can be separated; `inverse_squares` are one over the channels'
    /// squares.
    #[inline(never)]
    pub fn residuals(
        &self,
        curves: &[f32; CURVES_MAX],
        inverse_squares: &[f32; CHANNELS_SEARCHED],
        visit: &mut impl FnMut(f32),
    ) {
        let (mut residuals, mut rest) = ([0.0; CHANNELS_SEARCHED], [[0.0; SIDES]; CURVES_MAX]);
        for (c, residual) in residuals.iter_mut().enumerate() {
            *residual = self.rest[c][c];
        }
        rest.iter_mut()
            .zip(self.rest.iter().skip(CHANNELS_SEARCHED))
            .for_each(|(rest, row)| *rest = *row);
        for used in 0..=CURVES_MAX {
            if let Some(k) = used.checked_sub(1) {
                let (known, others) = rest.split_at_mut(used);
                let Some(own) = known.last() else { return };
                let pivot = own[CHANNELS_SEARCHED + k];
                if !(pivot > CURVE_SHARE_MIN * curves[k]) {
                    return;
                }
                let inverse = 1.0 / pivot;
                let with_own: [f32; CURVES_MAX] = core::array::from_fn(|l| {
                    others
                        .get(l)
                        .and_then(|other| other.get(CHANNELS_SEARCHED + k))
                        .map_or(0.0, |product| *product)
                });
                for (l, other) in others.iter_mut().enumerate() {
                    let factor = with_own[l] * inverse;
                    for c in 0..CHANNELS_SEARCHED {
                        other[c] -= factor * own[c];
                    }
                    for (m, with) in with_own.iter().enumerate().take(l + 1) {
                        if let Some(product) = other.get_mut(CHANNELS_SEARCHED + used + m) {
                            *product -= factor * with;
                        }
                    }
                }
                for (residual, own) in residuals.iter_mut().zip(own) {
                    *residual -= own * own * inverse;
                }
            }
            let mut product = 1.0;
            for (residual, inverse) in residuals.iter().zip(inverse_squares) {
                let share = residual * inverse;
                // Not `f32::max`, which is a call.
                product *= if share > RESIDUAL_SHARE_MIN {
                    share
                } else {
                    RESIDUAL_SHARE_MIN
                };
            }
            visit(product);
        }
    }
}
