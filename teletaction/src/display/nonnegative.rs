//! Least squares without negative unknowns: the quadratic program min x'Gx/2 - b'x, x >= 0, by
//! block principal pivoting.
//!
//! Kim and Park, *Fast Nonnegative Matrix Factorization: An Active-Set-Like Method and
//! Comparisons*, SIAM J. Sci. Comput. 33 (2011), section 4; after Portugal, Judice and Vicente
//! (1994). Each pivot solves for the smaller one of the two sets: for the pins that press, with G,
//! or for those that rest, with its inverse. So no system has more than half of the unknowns.

use crate::display::packed::{at, factor, largest, solve, triangle};
use crate::display::set::Set;

/// What does not change from frame to frame.
pub(crate) struct Program<'a> {
    /// G, packed.
    pub(crate) gram: &'a [f32],
    /// Its inverse, packed.
    pub(crate) inverse: &'a [f32],
    /// The factor's place: a triangle of half of the unknowns.
    pub(crate) lower: &'a mut [f32],
    /// The right-hand side of the smaller system.
    pub(crate) small: &'a mut [f32],
}

/// How a solution was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    /// Those that press.
    pub(crate) pressing: Set,
    pub(crate) pivots: u32,
    /// Whether the conditions of an optimum hold.
    pub(crate) is_optimal: bool,
    pub(crate) multiply_adds: u32,
}

/// Tries of exchanging all at once before one is exchanged alone (Kim and Park, section 4.2).
const TRIES: u32 = 3;

/// What counts as zero, over the largest unknown, or over the largest right-hand side.
const ZERO: f32 = 2e-6;

/// Most work of a search, which ends it before its optimum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Budget {
    /// Systems that it solves.
    pub(crate) pivots: u32,
    /// Multiplications behind which no other system is begun.
    pub(crate) multiply_adds: u32,
}

/// Exchanges pins until none is in the wrong set, from the set that pressed last. `solve` gives
/// those that are wrong for a set, and the number of its multiplications.
pub(crate) fn exchange(
    mut pressing: Set,
    budget: Budget,
    mut solve: impl FnMut(&Set) -> (Set, u32),
) -> Found {
    let (mut fewest, mut tries, mut pivots, mut multiply_adds) = (usize::MAX, 0, 0, 0);
    loop {
        let (mut wrong, more) = solve(&pressing);
        let count = wrong.count();
        pivots += 1;
        multiply_adds += more;
        if count == 0 || pivots >= budget.pivots || multiply_adds > budget.multiply_adds {
            return Found {
                pressing,
                pivots,
                is_optimal: count == 0,
                multiply_adds,
            };
        }
        if count < fewest {
            (fewest, tries) = (count, TRIES + 1);
        }
        if tries > 0 {
            tries -= 1;
        } else {
            // Murty's rule, to exchange the first one alone, ends for certain.
            wrong.keep_first();
        }
        pressing.flip_all(&wrong);
    }
}

/// The right side of the program, and its solution without a bound.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) free: &'a [f32],
    pub(crate) b: &'a [f32],
}

/// Memory for the solution and its gradient.
pub(crate) struct Answer<'a> {
    pub(crate) x: &'a mut [f32],
    pub(crate) y: &'a mut [f32],
}

/// Solves with G.
pub(crate) fn solve_from(
    program: &mut Program<'_>,
    pressing: Set,
    given: Given<'_>,
    answer: &mut Answer<'_>,
    pivots_max: u32,
) -> Found {
    let Given { free, b } = given;
    let n = answer.x.len();
    let (zero_x, zero_y) = (ZERO * largest(free), ZERO * largest(b));
    let budget = Budget {
        pivots: pivots_max,
        multiply_adds: u32::MAX,
    };
    let found = exchange(pressing, budget, |pressing| {
        let multiply_adds = pivot(program, pressing, given, answer);
        let Answer { x, y } = &*answer;
        let is_wrong = |i: usize| {
            if pressing.has(i) {
                x[i] < -zero_x
            } else {
                y[i] < -zero_y
            }
        };
        (Set::of(n, is_wrong), multiply_adds)
    });
    answer.x.iter_mut().for_each(|x| *x = x.max(0.0));
    found
}

/// Solution and gradient for one set. Gives the number of multiplications.
fn pivot(
    program: &mut Program<'_>,
    pressing: &Set,
    given: Given<'_>,
    answer: &mut Answer<'_>,
) -> u32 {
    let Given { free, b } = given;
    let (x, y) = (&mut *answer.x, &mut *answer.y);
    let n = x.len();
    let is_pressing = |i: usize| pressing.has(i);
    let press = 2 * pressing.count() <= n;
    // The smaller system, over `of`: those that press, with G, or those that rest, with its
    // inverse.
    let matrix = if press { program.gram } else { program.inverse };
    let of = |i: &usize| is_pressing(*i) == press;
    let size = (0..n).filter(of).count();
    let (lower, small) = (
        &mut program.lower[..triangle(size)],
        &mut program.small[..size],
    );
    for (row, i) in (0..n).filter(of).enumerate() {
        for (column, j) in (0..i + 1).filter(of).enumerate() {
            lower[triangle(row) + column] = at(matrix, i, j);
        }
        small[row] = if press { b[i] } else { -free[i] };
    }
    // Parts of a matrix that was factored have larger pivots than it had.
    if factor(lower, size, 0.0).is_err() {
        small.fill(0.0);
    } else {
        solve(lower, small);
    }
    // For pins that rest the gradient is the matrix times the pressing forces, less b. Pins that
    // press give way.
    let (inside, outside) = if press { (x, y) } else { (y, x) };
    let start = if press { b } else { free };
    for i in 0..n {
        outside[i] = if press { -start[i] } else { start[i] };
        inside[i] = 0.0;
    }
    for (row, j) in (0..n).filter(of).enumerate() {
        let value = small[row];
        inside[j] = value;
        let above = &matrix[triangle(j)..][..=j];
        outside[..=j]
            .iter_mut()
            .zip(above)
            .for_each(|(outside, element)| *outside += element * value);
        for i in j + 1..n {
            outside[i] += matrix[triangle(i) + j] * value;
        }
    }
    (0..n).filter(of).for_each(|i| outside[i] = 0.0);
    let s = size as u32;
    s * s * s / 6 + s * s + n as u32 * s
}
