//! The optimum with one unknown for each sensor instead of each pin: for few sensors and many pins.
//!
//! For a set P of pins that press, (A_P' A_P + c)^-1 A_P' w = A_P' v with (A_P A_P' + c) v = w.
//! What is left of the wanted strains is c v, so the gradient of a pin that rests is -c a'v: one
//! product a'v is the force of a pin that presses, and the sign for one that rests.

use crate::display::nonnegative::{Budget, Found, exchange};
use crate::display::packed::{dot, factor, largest, solve, triangle};
use crate::display::set::Set;

/// What counts as zero, over the largest product. With 16 sensors f32 rounds by less.
pub(crate) const ZERO: f32 = 1e-5;

/// What does not change from frame to frame, and room for what does.
pub(crate) struct SensorSpace<'a> {
    /// Regularisation: c.
    pub(crate) constant: f32,
    /// A A' + c of all pins, packed.
    pub(crate) all: &'a [f32],
    /// That of the set, and its factor.
    pub(crate) lower: &'a mut [f32],
    /// v.
    pub(crate) v: &'a mut [f32],
}

/// Adds the products of a pin's row with itself, times a factor: 1 or -1.
pub(crate) fn add(matrix: &mut [f32], row: &[f32], times: f32) {
    let mut rest = matrix;
    let (fours, last) = row.as_chunks::<4>();
    for (i, value) in row.iter().enumerate() {
        let (line, below) = rest.split_at_mut(i + 1);
        let value = times * value;
        let (line_fours, line_last) = line.as_chunks_mut::<4>();
        // What is left of the line belongs to the next four of the row.
        let next = fours.get(line_fours.len()).map_or(last, |four| &four[..]);
        for (elements, others) in line_fours.iter_mut().zip(fours) {
            elements
                .iter_mut()
                .zip(others)
                .for_each(|(element, other)| *element += value * other);
        }
        line_last
            .iter_mut()
            .zip(next)
            .for_each(|(element, other)| *element += value * other);
        rest = below;
    }
}

/// Strains that are wanted, and how pins make strains.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    /// A row for each pin: the strains under a unit force.
    pub(crate) map: &'a [f32],
    pub(crate) wanted: &'a [f32],
}

impl SensorSpace<'_> {
    /// Solves from the set that pressed last; `x` gets the forces.
    pub(crate) fn solve_from(
        &mut self,
        target: Target<'_>,
        pressing: Set,
        x: &mut [f32],
        pivots_max: u32,
    ) -> Found {
        let Target { map, wanted } = target;
        let budget = Budget {
            pivots: pivots_max,
            multiply_adds: u32::MAX,
        };
        let found = exchange(pressing, budget, |pressing| {
            let multiply_adds = self.products(map, wanted, pressing, x);
            let zero = ZERO * largest(x);
            let is_wrong = |i: usize| {
                if pressing.has(i) {
                    x[i] < -zero
                } else {
                    x[i] > zero
                }
            };
            (Set::of(x.len(), is_wrong), multiply_adds)
        });
        for (i, x) in x.iter_mut().enumerate() {
            // What is no number stays one: the caller looks.
            if !found.pressing.has(i) || *x < 0.0 {
                *x = 0.0;
            }
        }
        found
    }

    /// Products of all pins with v, for one set. Gives the number of multiplications.
    fn products(&mut self, map: &[f32], wanted: &[f32], pressing: &Set, x: &mut [f32]) -> u32 {
        let (pins, sensors) = (x.len(), wanted.len());
        // From none, or from all: what is fewer to add or to take away.
        let few = 2 * pressing.count() <= pins;
        if few {
            self.lower.fill(0.0);
            (0..sensors).for_each(|i| self.lower[triangle(i) + i] = self.constant);
        } else {
            self.lower.copy_from_slice(self.all);
        }
        let mut changed = 0;
        for (i, row) in map.chunks_exact(sensors).enumerate() {
            if pressing.has(i) == few {
                add(self.lower, row, if few { 1.0 } else { -1.0 });
                changed += 1;
            }
        }
        self.v.copy_from_slice(wanted);
        // It has c on its diagonal.
        if factor(self.lower, sensors, 0.0).is_err() {
            self.v.fill(0.0);
        } else {
            solve(self.lower, self.v);
        }
        x.iter_mut()
            .zip(map.chunks_exact(sensors))
            .for_each(|(x, row)| *x = dot(row, self.v));
        let s = sensors as u32;
        changed * s * (s + 1) / 2 + s * s * s / 6 + s * s + s * pins as u32
    }
}
