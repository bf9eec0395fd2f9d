//! Strain matching and stress matching: the forces of the pins whose strains in the finger are
//! nearest to those in the sensor.
//!
//! Equations 9 to 11 of Moy et al., with forces that only press and with Tikhonov's regularisation,
//! which the paper leaves to others.

use crate::display::error::{Error, finite, length, within};
use crate::display::nonnegative::{Answer, Found, Given, Program, solve_from};
use crate::display::packed::{at, dot, factor, invert, triangle};
use crate::display::sensor_space::{SensorSpace, Target, add};
use crate::display::set::Set;

/// Most pins: a display of 10 x 10.
pub const PINS_MAX: usize = 100;

/// Most sensors.
const SENSORS_MAX: usize = 1024;

/// Least pivot over its diagonal element: below it f32 cannot separate the pins.
const PIVOT_MIN: f32 = 1e-5;

/// Pivots at most by default. Of 8,000 frames that had nothing to do with the ones before, none
/// took more than 12 (`tests/display/matching.rs`).
pub(crate) const PIVOTS_MAX: u32 = 20;

/// Pins and sensors with all that is computed once.
pub struct Matching<'a> {
    pins: usize,
    /// The map, a row for each pin.
    map: &'a [f32],
    way: Way<'a>,
    x: &'a mut [f32],
    pressing: Set,
    pivots_max: u32,
}

/// Which unknowns are the fewer ones.
enum Way<'a> {
    Pins {
        /// Sensors to forces without a bound, a row for each pin.
        free_map: &'a [f32],
        program: Program<'a>,
        free: &'a mut [f32],
        b: &'a mut [f32],
        y: &'a mut [f32],
    },
    Sensors(SensorSpace<'a>),
}

/// Whether a display is solved by its sensors.
const fn by_sensors(pins: usize, sensors: usize) -> bool {
    2 * sensors <= pins
}

/// Forces for one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<'a> {
    /// A force for each pin, none below 0, in the unit that the map is per.
    pub forces: &'a [f32],
    /// Systems that were solved.
    pub pivots: u32,
    /// False: the pivots were used up. The forces press, and are not the best.
    pub is_optimal: bool,
    /// Multiplications with an addition, all in all.
    pub multiply_adds: u32,
}

impl<'a> Matching<'a> {
    /// Values that the memory of [`Self::new`] must hold for `pins` pins and `sensors` sensors:
    /// 2000 (8 kB) for 100 pins and 16 sensors.
    pub const fn floats(pins: usize, sensors: usize) -> usize {
        if by_sensors(pins, sensors) {
            pins * sensors + 2 * triangle(sensors) + sensors + pins
        } else {
            2 * pins * sensors + 2 * triangle(pins) + triangle(pins / 2) + 4 * pins + pins / 2
        }
    }

    /// Computes everything that does not change from frame to frame: about `pins^3`
    /// multiplications, or `pins sensors^2` if the sensors are at most half as many as the pins.
    ///
    /// - `memory`: at least [`Self::floats`] values; their content does not matter.
    /// - `pins`: 1 to [`PINS_MAX`]. `sensors`: 1 to 1024.
    /// - `regularisation`: from 0 to 10, relative to the mean square of what a pin does. It keeps
    ///   noise out of the forces: they become smaller and more even. 0.001 to 0.1 is usual; 0 needs
    ///   at least as many sensors as pins.
    /// - `map(sensor, pin)`: strain at a sensor's place in the finger for a unit force of a pin,
    ///   such as [`Grid::map`] gives.
    ///
    /// Fails if a setting or the map is impossible, and if the forces are not determined.
    ///
    /// [`Grid::map`]: crate::display::Grid::map
    pub fn new(
        memory: &'a mut [f32],
        pins: usize,
        sensors: usize,
        regularisation: f32,
        map: impl Fn(usize, usize) -> f32,
    ) -> Result<Self, Error> {
        within("pins", pins as f64, 1.0, PINS_MAX as f64)?;
        within("sensors", sensors as f64, 1.0, SENSORS_MAX as f64)?;
        within("regularisation", f64::from(regularisation), 0.0, 10.0)?;
        let (found, needed) = (memory.len(), Self::floats(pins, sensors));
        if found < needed {
            return Err(Error::Length {
                what: "memory",
                found,
                needed,
            });
        }
        let (by_pin, memory) = memory.split_at_mut(pins * sensors);
        let (x, memory) = memory.split_at_mut(pins);
        for (pin, row) in by_pin.chunks_exact_mut(sensors).enumerate() {
            row.iter_mut()
                .enumerate()
                .for_each(|(sensor, value)| *value = map(sensor, pin));
        }
        finite("element of the map", by_pin)?;
        let by_pin = &*by_pin;
        let mean = by_pin
            .chunks_exact(sensors)
            .map(|row| dot(row, row))
            .sum::<f32>()
            / pins as f32;
        let constant = regularisation * mean;
        let way = if by_sensors(pins, sensors) {
            let (all, memory) = memory.split_at_mut(triangle(sensors));
            let (lower, memory) = memory.split_at_mut(triangle(sensors));
            all.fill(0.0);
            (0..sensors).for_each(|i| all[triangle(i) + i] = constant);
            by_pin
                .chunks_exact(sensors)
                .for_each(|row| add(all, row, 1.0));
            // With more pins than sensors only the regularisation determines the forces.
            if !(regularisation > PIVOT_MIN) {
                return Err(Error::Singular { pin: sensors });
            }
            Way::Sensors(SensorSpace {
                constant,
                all,
                lower,
                v: &mut memory[..sensors],
            })
        } else {
            by_pins(memory, by_pin, pins, sensors, constant)?
        };
        Ok(Self {
            pins,
            map: by_pin,
            way,
            x,
            pressing: Set::of(pins, |_| true),
            pivots_max: PIVOTS_MAX,
        })
    }

    /// Number of pins.
    pub fn pins(&self) -> usize {
        self.pins
    }

    /// Number of sensors.
    pub fn sensors(&self) -> usize {
        self.map.len() / self.pins
    }

    /// Systems to solve at most in a frame, 1 to 1000; 20 if it is not called. It bounds the time
    /// of a frame.
    pub fn set_pivots_max(&mut self, pivots_max: u32) {
        self.pivots_max = pivots_max.clamp(1, 1000);
    }

    /// Forces whose strains are the nearest to the wanted ones, a value for each sensor. It begins
    /// from the last frame's solution.
    ///
    /// Fails if a value is not finite, or their number is wrong; the next frame does not depend on
    /// it.
    pub fn forces(&mut self, wanted: &[f32]) -> Result<Solution<'_>, Error> {
        let sensors = self.sensors();
        length("wanted strains", wanted.len(), sensors)?;
        finite("wanted strain", wanted)?;
        let found = match &mut self.way {
            Way::Pins {
                free_map,
                program,
                free,
                b,
                y,
            } => {
                for pin in 0..self.pins {
                    b[pin] = dot(&self.map[pin * sensors..][..sensors], wanted);
                    free[pin] = dot(&free_map[pin * sensors..][..sensors], wanted);
                }
                // Values near the end of f32's range would give infinite forces.
                finite("force of pin", b)?;
                finite("force of pin", free)?;
                let mut found = solve_from(
                    program,
                    self.pressing,
                    Given { free, b },
                    &mut Answer { x: self.x, y },
                    self.pivots_max,
                );
                found.multiply_adds += 2 * (self.pins * sensors) as u32;
                found
            }
            Way::Sensors(space) => {
                let target = Target {
                    map: self.map,
                    wanted,
                };
                space.solve_from(target, self.pressing, self.x, self.pivots_max)
            }
        };
        finite("force of pin", self.x)?;
        self.pressing = found.pressing;
        let Found {
            pivots,
            is_optimal,
            multiply_adds,
            ..
        } = found;
        Ok(Solution {
            forces: self.x,
            pivots,
            is_optimal,
            multiply_adds,
        })
    }

    /// Strains that forces make in the finger at once, a value for each sensor (equation 10).
    pub fn felt(&self, forces: &[f32], strains: &mut [f32]) -> Result<(), Error> {
        let sensors = self.sensors();
        length("forces", forces.len(), self.pins)?;
        length("strains", strains.len(), sensors)?;
        finite("force", forces)?;
        strains.fill(0.0);
        for (force, row) in forces.iter().zip(self.map.chunks_exact(sensors)) {
            strains
                .iter_mut()
                .zip(row)
                .for_each(|(strain, element)| *strain += element * force);
        }
        Ok(())
    }
}

/// What is computed once for unknowns of the pins.
fn by_pins<'a>(
    memory: &'a mut [f32],
    map: &[f32],
    pins: usize,
    sensors: usize,
    constant: f32,
) -> Result<Way<'a>, Error> {
    let (free_map, memory) = memory.split_at_mut(pins * sensors);
    let (gram, memory) = memory.split_at_mut(triangle(pins));
    let (inverse, memory) = memory.split_at_mut(triangle(pins));
    let (lower, memory) = memory.split_at_mut(triangle(pins / 2));
    let (small, memory) = memory.split_at_mut(pins / 2);
    let (free, memory) = memory.split_at_mut(pins);
    let (b, memory) = memory.split_at_mut(pins);
    let y = &mut memory[..pins];
    let row = |pin: usize| &map[pin * sensors..][..sensors];
    for i in 0..pins {
        for j in 0..=i {
            gram[triangle(i) + j] = dot(row(i), row(j)) + if i == j { constant } else { 0.0 };
        }
    }
    inverse.copy_from_slice(gram);
    factor(inverse, pins, PIVOT_MIN).map_err(|pin| Error::Singular { pin })?;
    invert(inverse, pins);
    for i in 0..pins {
        for sensor in 0..sensors {
            free_map[i * sensors + sensor] = (0..pins)
                .map(|j| at(inverse, i, j) * map[j * sensors + sensor])
                .sum();
        }
    }
    let program = Program {
        gram,
        inverse,
        lower,
        small,
    };
    Ok(Way::Pins {
        free_map,
        program,
        free,
        b,
        y,
    })
}
