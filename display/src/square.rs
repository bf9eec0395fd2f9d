//! A square display over a square array, computed anew in each frame: for a chip whose memory is somebody else's in between.

use crate::half_space::strain_by_square;
use crate::matching::{PINS_MAX, Solution};
use crate::nonnegative::{Found, exchange};
use crate::packed::{at, dot, factor, solve, triangle};
use crate::sensor_space::{ZERO, add};
use crate::set::Set;

/// Sensors on a side of the array, and all of them.
const SIDE: usize = 4;
const SENSORS: usize = SIDE * SIDE;

/// What is done to a sensor's number to mirror nothing, its place in the row, its row, or both.
const MIRRORS: [usize; 4] = [0, 3, 12, 15];

/// A symmetric matrix of the sensors, packed.
type Products = [f32; triangle(SENSORS)];

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
/// [`Matching`](crate::Matching) keeps 8 kB from frame to frame. This keeps 16 bytes: a frame computes the response of a quarter of the pins,
/// and the other three mirror it.
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
    /// Relative to the mean square of what a pin does, above 0: see [`Matching::new`](crate::Matching::new).
    pub regularisation: f32,
    /// Systems to solve at most in a frame: it bounds the time. The next frame goes on where this one ended.
    pub pivots_max: u32,
}

impl Square {
    /// Values that the memory of [`Self::forces`] must hold for so many pins on a side: 788 (3 kB) for 10.
    pub const fn floats(side: usize) -> usize {
        side.div_ceil(2) * side.div_ceil(2) * SENSORS + 2 * triangle(SENSORS) + SENSORS + side * side
    }

    /// Forces whose strains are the nearest to the wanted ones, row by row. `wanted` are strains times Young's modulus, newtons per square
    /// millimetre, row by row; `pressing` are the pins of the frame before, and then of this one. The memory's content does not
    /// matter.
    ///
    /// None if the memory is too small, if there are more than 10 x 10 pins or none, or if a wanted value or a force is not finite.
    // Not inlined: a chip's firmware makes it as small as can be, and its caller perhaps not.
    #[inline(never)]
    pub fn forces<'a>(
        &self,
        memory: &'a mut [f32],
        wanted: &[f32; SENSORS],
        pressing: &mut Pressing,
    ) -> Option<Solution<'a>> {
        let (half, pins) = (self.side.div_ceil(2), self.side * self.side);
        if pins == 0 || pins > PINS_MAX {
            return None;
        }
        let memory = memory.get_mut(..Self::floats(self.side))?;
        let (quarter, memory) = memory.split_at_mut_checked(half * half * SENSORS)?;
        let quarter = quarter.as_chunks_mut::<SENSORS>().0;
        let (product, memory) = memory.split_first_chunk_mut::<{ triangle(SENSORS) }>()?;
        let (lower, memory) = memory.split_first_chunk_mut::<{ triangle(SENSORS) }>()?;
        let (v, x) = memory.split_first_chunk_mut::<SENSORS>()?;
        self.fill(quarter);
        let quarter = &*quarter;
        // Of all pins first: the mean square of what a pin does.
        self.sum(quarter, (product, lower));
        let trace: f32 = (0..SENSORS).map(|i| product[triangle(i) + i]).sum();
        let constant = self.regularisation * (trace / pins as f32);
        // From all, or from none: what is fewer to take away or to add.
        let mut included = Set::of(pins, |_| true);
        if 2 * pressing.0.count() <= pins {
            (*product, included) = ([0.0; triangle(SENSORS)], Set::NONE);
        }
        (0..SENSORS).for_each(|i| product[triangle(i) + i] += constant);
        let found = exchange(pins, pressing.0, self.pivots_max, |pressing| {
            included.flip_all(pressing);
            for pin in (0..pins).filter(|pin| included.has(*pin)) {
                let (responses, mirror) = self.response(quarter, pin);
                add(product, &mirrored(responses, MIRRORS[mirror % SIDE]), if pressing.has(pin) { 1.0 } else { -1.0 });
            }
            let changed = included.count() as u32;
            included = *pressing;
            (*lower, *v) = (*product, *wanted);
            // It has the constant on its diagonal.
            if factor(lower, SENSORS, 0.0).is_err() {
                v.fill(0.0);
            } else {
                solve(lower, v);
            }
            // Mirror images of v, for those of the pins.
            let images = MIRRORS.map(|mirror| mirrored(v, mirror));
            let mut largest = 0.0f32;
            for (pin, x) in x.iter_mut().enumerate() {
                let (responses, mirror) = self.response(quarter, pin);
                *x = dot(responses, &images[mirror % SIDE]);
                largest = largest.max(x.abs());
            }
            let zero = ZERO * largest;
            let is_wrong =
                |pin: usize| x.get(pin).is_some_and(|x| if pressing.has(pin) { *x < -zero } else { *x > zero });
            let s = SENSORS as u32;
            (Set::of(pins, is_wrong), changed * s * (s + 1) / 2 + s * s * s / 6 + s * s + s * pins as u32)
        });
        let Found { pivots, is_optimal, multiply_adds, .. } = found;
        pressing.0 = found.pressing;
        // Of numbers the sum is one, and of what is none it is none.
        let sum: f32 = wanted.iter().chain(&*x).sum();
        for (pin, x) in x.iter_mut().enumerate() {
            if !found.pressing.has(pin) || *x < 0.0 {
                *x = 0.0;
            }
        }
        sum.is_finite().then_some(Solution { forces: x, pivots, is_optimal, multiply_adds })
    }

    /// The response of each sensor to each pin of the first quarter.
    fn fill(&self, quarter: &mut [[f32; SENSORS]]) {
        let half = self.side.div_ceil(2);
        // Squared distance along one direction.
        let square = |pin: usize, sensor: usize| {
            let middle = |n: usize, count: usize| n as f32 - 0.5 * (count as f32 - 1.0);
            let off_mm = middle(sensor, SIDE) * self.sensor_spacing_mm - middle(pin, self.side) * self.spacing_mm;
            off_mm * off_mm
        };
        for (pin, responses) in quarter.iter_mut().enumerate() {
            let (row, column) = (pin / half.max(1), pin % half.max(1));
            for (sensor, response) in responses.iter_mut().enumerate() {
                let square = square(row, sensor / SIDE) + square(column, sensor % SIDE);
                *response = strain_by_square(square, self.depth_mm, self.poisson);
            }
        }
    }

    /// The response of each sensor to the pin of the first quarter whose mirror image a pin is, and which of [`MIRRORS`] it takes.
    fn response<'a>(&self, quarter: &'a [[f32; SENSORS]], pin: usize) -> (&'a [f32; SENSORS], usize) {
        let (side, half) = (self.side.max(1), self.side.div_ceil(2));
        let (row, column) = (pin / side, pin % side);
        let (row, rows) = if row < half { (row, 0) } else { (side - 1 - row, 2) };
        let (column, columns) = if column < half { (column, 0) } else { (side - 1 - column, 1) };
        (quarter.get(row * half + column).unwrap_or(&[0.0; SENSORS]), rows | columns)
    }

    /// The products of all rows with themselves: those of a quarter, and their mirror images. `part` has as much room.
    fn sum(&self, quarter: &[[f32; SENSORS]], (all, part): (&mut Products, &mut Products)) {
        let half = self.side.div_ceil(2).max(1);
        // A pin in the middle is its own image.
        let share = |n: usize| if 2 * n + 1 == self.side { 0.5 } else { 1.0 };
        part.fill(0.0);
        for (pin, responses) in quarter.iter().enumerate() {
            add(part, responses, share(pin / half) * share(pin % half));
        }
        for i in 0..SENSORS {
            for j in 0..=i {
                if let Some(element) = all.get_mut(triangle(i) + j) {
                    *element = MIRRORS.iter().map(|mirror| at(part, i ^ mirror, j ^ mirror)).sum();
                }
            }
        }
    }
}

/// Values of the sensors in a mirror.
fn mirrored(values: &[f32; SENSORS], mirror: usize) -> [f32; SENSORS] {
    core::array::from_fn(|sensor| values[(sensor ^ mirror) % SENSORS])
}
