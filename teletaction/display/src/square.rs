//! A square display over a square array, computed anew in each frame: for a chip whose memory is
//! somebody else's in between.

use crate::blocks::{Block, Blocks, FOUR, add, dot, factor, set_diagonal, solve};
use crate::half_space::strain_by_square;
use crate::matching::{PINS_MAX, Solution};
use crate::nonnegative::{Budget, Found, exchange};
use crate::packed::{largest, triangle};
use crate::sensor_space::ZERO;
use crate::set::Set;
use crate::symmetry::{by_sums, sums, transposed};

/// Sensors on a side of the array, and all of them.
const SIDE: usize = 4;
const SENSORS: usize = SIDE * SIDE;

/// Most pins on a side, and on a side of the first quarter.
const PINS_SIDE_MAX: usize = PINS_MAX.isqrt();

/// Elements of a symmetric matrix of the sensors.
const ELEMENTS: usize = triangle(FOUR) * SENSORS;

/// The pins that press: where the next frame begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pressing(Set);

impl Pressing {
    /// No pin.
    pub const fn new() -> Self {
        Self(Set::NONE)
    }
}

impl Default for Pressing {
    fn default() -> Self {
        Self::new()
    }
}

/// 4 x 4 sensors, and as many pins on each side as wanted, around the same middle on a half space.
///
/// [`Matching`](crate::Matching) keeps 8 kB from frame to frame. This keeps 16 bytes: a frame
/// computes the response of a quarter of the pins, and the other three are its mirror images. In
/// sums and differences of sensors that are mirror images the response of an image is the same up
/// to signs, and most products of the images cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Pins on a side, 1 to 10.
    pub side: usize,
    /// Distance of the pins, millimetres, above 0.
    pub spacing_mm: f32,
    /// Distance of the sensors, millimetres, above 0.
    pub sensor_spacing_mm: f32,
    /// Thickness of the layer over the receptors of the finger, millimetres, above 0.
    pub depth_mm: f32,
    /// Poisson's ratio, 0 to 0.5.
    pub poisson: f32,
    /// Relative to the mean square of what a pin does, above 0: see
    /// [`Matching::new`](crate::Matching::new).
    pub regularisation: f32,
    /// Systems to solve at most in a frame. The next frame goes on where this one ended.
    pub pivots_max: u32,
    /// Multiplications of a frame behind which no other system is begun; with the one before it
    /// bounds the time, see [`Self::multiply_adds`].
    pub multiply_adds_max: u32,
}

impl Square {
    /// Values that the memory of [`Self::forces`] must hold for `side` pins on a side: 836 (3.3 kB)
    /// for 10.
    pub const fn floats(side: usize) -> usize {
        side.div_ceil(2) * side.div_ceil(2) * (SENSORS + FOUR) + 2 * ELEMENTS + SENSORS
    }

    /// Multiplications of a system with `side` pins on a side: least and greatest number. In
    /// between they go by the pins that have just begun or ended to press.
    pub const fn multiply_adds(side: usize) -> [u32; 2] {
        let quarter = side.div_ceil(2) * side.div_ceil(2);
        let least = multiply_adds(quarter);
        [least, least + (ELEMENTS * quarter) as u32]
    }

    /// Forces whose strains are the nearest to the wanted ones, row by row. `wanted` are strains
    /// times Young's modulus, newtons per square millimetre, row by row; `pressing` are the pins of
    /// the frame before, and then of this one. The memory's content does not matter.
    ///
    /// None if the memory is too small, if there are more than 10 x 10 pins or none, or if a wanted
    /// value or a force is not finite.
    // Not inlined: a chip's firmware makes it as small as can be, and its caller perhaps not.
    #[inline(never)]
    pub fn forces<'a>(
        &self,
        memory: &'a mut [f32],
        wanted: &[f32; SENSORS],
        pressing: &mut Pressing,
    ) -> Option<Solution<'a>> {
        if self.side == 0 || self.side > PINS_SIDE_MAX {
            return None;
        }
        let half = self.side.div_ceil(2);
        let (quarter, memory) = memory.split_at_mut_checked(half * half * SENSORS)?;
        let (x, memory) = memory.split_at_mut_checked(half * half * FOUR)?;
        let (product, memory) = memory.split_first_chunk_mut::<ELEMENTS>()?;
        let (lower, memory) = memory.split_first_chunk_mut::<ELEMENTS>()?;
        let quarter = quarter.as_chunks_mut().0.as_chunks_mut().0;
        self.fill(quarter);
        let there = self.there();
        let squares = |(n, pin): (usize, &Block)| {
            there.four(n).count_ones() as f32 * pin.iter().map(|four| dot(four, four)).sum::<f32>()
        };
        let squares: f32 = quarter.iter().enumerate().map(squares).sum();
        let mut system = System {
            quarter,
            there,
            included: Set::NONE,
            product: product
                .as_chunks_mut()
                .0
                .as_chunks_mut()
                .0
                .first_chunk_mut()?,
            lower: lower
                .as_chunks_mut()
                .0
                .as_chunks_mut()
                .0
                .first_chunk_mut()?,
            wanted: by_sums(wanted.as_chunks().0.first_chunk()?),
            v: memory.as_chunks_mut().0.first_chunk_mut()?,
            x: x.as_chunks_mut().0,
        };
        set_diagonal(
            system.product,
            self.regularisation * (squares / (self.side * self.side) as f32),
        );
        let begin = pressing.0.and(&there);
        let budget = Budget {
            pivots: self.pivots_max,
            multiply_adds: self.multiply_adds_max,
        };
        let found = exchange(begin, budget, |pressing| system.solve(pressing));
        let Found {
            pivots,
            is_optimal,
            multiply_adds,
            ..
        } = found;
        pressing.0 = found.pressing;
        // Of numbers the sum is one, and of what is none it is none: a wanted value that is none is
        // in every force.
        let mut sum = 0.0;
        let forces = lower.get_mut(..self.side * self.side)?;
        for (n, x) in x.as_chunks::<FOUR>().0.iter().enumerate() {
            let (row, column) = (n / half.max(1), n % half.max(1));
            let rows = [row, self.side - 1 - row].map(|row| row * self.side);
            let columns = [column, self.side - 1 - column];
            let (there, pressing) = (there.four(n), found.pressing.four(n));
            for (image, x) in x.iter().enumerate() {
                sum += x;
                if there >> image & 1 != 0
                    && let Some(force) = forces.get_mut(rows[image / 2] + columns[image % 2])
                {
                    *force = if pressing >> image & 1 != 0 && *x > 0.0 {
                        *x
                    } else {
                        0.0
                    };
                }
            }
        }
        f32::is_finite(sum).then_some(Solution {
            forces,
            pivots,
            is_optimal,
            multiply_adds,
        })
    }

    /// The response of each sensor to each pin of the first quarter.
    fn fill(&self, quarter: &mut [Block]) {
        let (half, response) = (
            self.side.div_ceil(2),
            strain_by_square(self.depth_mm, self.poisson),
        );
        let middle = |n: usize, count: usize| n as f32 - 0.5 * (count as f32 - 1.0);
        // Squared distances of the sensors along one direction.
        let along = |pin: usize| {
            let pin_mm = middle(pin, self.side) * self.spacing_mm;
            let square = |off_mm: f32| off_mm * off_mm;
            core::array::from_fn::<f32, SIDE, _>(|n| {
                square(middle(n, SIDE) * self.sensor_spacing_mm - pin_mm)
            })
        };
        for row in 0..half {
            let along_rows = along(row);
            for column in 0..=row {
                let along_columns = along(column);
                let pin = by_sums(&along_rows.map(|y| along_columns.map(|x| response(y + x))));
                // Exchanged rows and columns have the same distances.
                for (at, pin) in [
                    (row * half + column, pin),
                    (column * half + row, transposed(&pin)),
                ] {
                    if let Some(place) = quarter.get_mut(at) {
                        *place = pin;
                    }
                }
            }
        }
    }

    /// The images that are pins: one in the middle of an odd row or column is its own image.
    fn there(&self) -> Set {
        let half = self.side.div_ceil(2);
        let mut there = Set::NONE;
        for n in 0..half * half {
            let is_middle = |n: usize| 2 * n + 1 == self.side;
            let columns = if is_middle(n % half) { 0b0101 } else { 0b1111 };
            let rows = if is_middle(n / half) { 0b0011 } else { 0b1111 };
            there.put_four(n, rows & columns);
        }
        there
    }
}

/// Multiplications of a system with `quarter` pins in the first quarter, but for those that form
/// its matrix.
const fn multiply_adds(quarter: usize) -> u32 {
    (SENSORS * SENSORS * SENSORS / 6 + SENSORS * SENSORS + SENSORS * quarter) as u32
}

/// One frame: as [`SensorSpace`](crate::sensor_space::SensorSpace), in sums and differences of the
/// sensors.
struct System<'a> {
    /// The response to each pin of the first quarter.
    quarter: &'a [Block],
    /// The images that are pins.
    there: Set,
    /// Those whose products are in `product`.
    included: Set,
    product: &'a mut Blocks,
    /// Its factor.
    lower: &'a mut Blocks,
    wanted: Block,
    v: &'a mut Block,
    /// The forces of each pin of the quarter and of its images.
    x: &'a mut [[f32; FOUR]],
}

impl System<'_> {
    /// The pins that are wrong in a set that presses, and the number of multiplications.
    fn solve(&mut self, pressing: &Set) -> (Set, u32) {
        // How often each image counts more than before, as sums; the forces' place is free until
        // they are known.
        for (n, weights) in self.x.iter_mut().enumerate() {
            let (before, now) = (self.included.four(n), pressing.four(n));
            let count = |image: u32| (now >> image & 1) as i32 - (before >> image & 1) as i32;
            *weights = sums([0, 1, 2, 3].map(count)).map(|weight| weight as f32);
        }
        let multiply_adds =
            multiply_adds(self.quarter.len()) + add(self.product, self.quarter, self.x);
        self.included = *pressing;
        self.lower.copy_from_slice(self.product);
        *self.v = self.wanted;
        // It has the constant on its diagonal: only settings that are impossible make it fail.
        match factor(self.lower) {
            Some(()) => solve(self.lower, self.v),
            None => *self.v = [[f32::NAN; FOUR]; FOUR],
        }
        for (x, pin) in self.x.iter_mut().zip(self.quarter) {
            *x = sums(core::array::from_fn(|s| dot(&pin[s], &self.v[s])));
        }
        let (zero, mut wrong) = (ZERO * largest(self.x.as_flattened()), Set::NONE);
        for (n, x) in self.x.iter().enumerate() {
            let pressing = pressing.four(n);
            let is_wrong = |image: usize| {
                if pressing >> image & 1 != 0 {
                    x[image] < -zero
                } else {
                    x[image] > zero
                }
            };
            wrong.put_four(
                n,
                (0..FOUR)
                    .map(|image| u32::from(is_wrong(image)) << image)
                    .sum(),
            );
        }
        (wrong.and(&self.there), multiply_adds)
    }
}
