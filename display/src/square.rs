//! A square display over a square array, computed anew in each frame: for a chip whose memory is somebody else's in between.

use crate::half_space::strain_by_square;
use crate::matching::{PINS_MAX, PIVOTS_MAX, Solution};
use crate::nonnegative::Found;
use crate::packed::{at, triangle};
use crate::sensor_space::{SensorSpace, add};
use crate::set::Set;

/// Sensors on a side of the array, and all of them.
const SIDE: usize = 4;
const SENSORS: usize = SIDE * SIDE;

/// A symmetric matrix of the sensors, packed.
type Products = [f32; triangle(SENSORS)];

/// 4 x 4 sensors, and as many pins on each side as wanted, around the same middle on a half space.
///
/// [`Matching`](crate::Matching) keeps 8 kB from frame to frame. This keeps nothing: a frame computes the response of a quarter of the pins,
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
}

impl Square {
    /// Values that the memory of [`Self::forces`] must hold for so many pins on a side: 1988 (8 kB) for 10.
    pub const fn floats(side: usize) -> usize {
        side * side * (SENSORS + 1) + 2 * triangle(SENSORS) + SENSORS
    }

    /// Forces whose strains are the nearest to the wanted ones, row by row. `wanted` are strains times Young's modulus, newtons per square
    /// millimetre, row by row; `may_press` says of a pin whether it probably presses, such as in the frame before. The memory's
    /// content does not matter.
    ///
    /// None if the memory is too small, if there are more than 10 x 10 pins or none, or if a wanted value or a force is not finite.
    // Not inlined: a chip's firmware makes it as small as can be, and its caller perhaps not.
    #[inline(never)]
    pub fn forces<'a>(
        &self,
        memory: &'a mut [f32],
        wanted: &[f32; SENSORS],
        may_press: &dyn Fn(usize) -> bool,
    ) -> Option<Solution<'a>> {
        let pins = self.side * self.side;
        let memory = memory.get_mut(..Self::floats(self.side))?;
        if pins == 0 || pins > PINS_MAX {
            return None;
        }
        let (map, memory) = memory.split_at_mut_checked(pins * SENSORS)?;
        let (all, memory) = memory.split_first_chunk_mut::<{ triangle(SENSORS) }>()?;
        let (lower, memory) = memory.split_first_chunk_mut::<{ triangle(SENSORS) }>()?;
        let (v, x) = memory.split_first_chunk_mut::<SENSORS>()?;
        self.fill(map);
        self.sum(map, (all, lower));
        // The mean square of what a pin does.
        let trace: f32 = (0..SENSORS).map(|i| all[triangle(i) + i]).sum();
        let constant = self.regularisation * (trace / pins as f32);
        (0..SENSORS).for_each(|i| all[triangle(i) + i] += constant);
        let pressing = Set::of(pins, may_press);
        let mut space = SensorSpace { constant, all, lower, v };
        let found = space.solve_from(map, wanted, pressing, x, PIVOTS_MAX);
        let Found { pivots, is_optimal, multiply_adds, .. } = found;
        // Of numbers the sum is one, and of what is none it is none.
        let sum: f32 = wanted.iter().chain(&*x).sum();
        sum.is_finite().then_some(Solution { forces: x, pivots, is_optimal, multiply_adds })
    }

    /// The response of each sensor to each pin, a row for each pin.
    fn fill(&self, map: &mut [f32]) {
        let side = self.side;
        // Squared distance along one direction.
        let square = |pin: usize, sensor: usize| {
            let middle = |n: usize, count: usize| n as f32 - 0.5 * (count as f32 - 1.0);
            let off_mm = middle(sensor, SIDE) * self.sensor_spacing_mm - middle(pin, side) * self.spacing_mm;
            off_mm * off_mm
        };
        for row in 0..side.div_ceil(2) {
            for column in 0..side.div_ceil(2) {
                for sensor in 0..SENSORS {
                    let (y, x) = (sensor / SIDE, sensor % SIDE);
                    let response = strain_by_square(square(row, y) + square(column, x), self.depth_mm, self.poisson);
                    for (row, y) in [(row, y), (side - 1 - row, SIDE - 1 - y)] {
                        for (column, x) in [(column, x), (side - 1 - column, SIDE - 1 - x)] {
                            if let Some(value) = map.get_mut((row * side + column) * SENSORS + y * SIDE + x) {
                                *value = response;
                            }
                        }
                    }
                }
            }
        }
    }

    /// The products of all rows with themselves: those of a quarter, and their mirror images. `part` has as much room.
    fn sum(&self, map: &[f32], (all, part): (&mut Products, &mut Products)) {
        let half = self.side.div_ceil(2);
        // A pin in the middle is its own image.
        let share = |n: usize| if 2 * n + 1 == self.side { 0.5 } else { 1.0 };
        part.fill(0.0);
        for row in 0..half {
            for column in 0..half {
                let pin = row * self.side + column;
                if let Some(responses) = map.get(pin * SENSORS..(pin + 1) * SENSORS) {
                    add(part, responses, share(row) * share(column));
                }
            }
        }
        for i in 0..SENSORS {
            for j in 0..=i {
                // 3 mirrors the place in a row, 12 the row.
                if let Some(element) = all.get_mut(triangle(i) + j) {
                    *element = [0, 3, 12, 15].iter().map(|mirror| at(part, i ^ mirror, j ^ mirror)).sum();
                }
            }
        }
    }
}
