//! Touch at a distance: what a sensor array feels at one place becomes forces of a pin display
//! under a finger at another, up to 10 x 10 pins.
//!
//! ```
//! use ridgetone_teletaction::display::{Afterimage, Grid, Limits, Matching, Pins, Quantity, SUBJECTS};
//!
//! // Sixteen sensors 1.5 mm deep in a skin, and 4 x 4 pins 2 mm apart under a rubber layer of 2 mm.
//! const SENSORS: usize = 16;
//! const PINS: usize = 16;
//! let (sensors, pins) = (Grid::new(4, 4, 1.5)?, Grid::new(4, 4, 2.0)?);
//! let map = sensors.map(&pins, 2.0, 0.5, Quantity::Strain)?;
//! let mut memory = [0.0; Matching::floats(PINS, SENSORS)];
//! let mut matching = Matching::new(&mut memory, PINS, SENSORS, 0.01, map)?;
//!
//! // A finger that keeps what was pressed into it, and a display with limits.
//! let (mut kept, mut forces, mut felt) = ([0.0; SENSORS], [0.0; PINS], [0.0; SENSORS]);
//! let mut afterimage = Afterimage::new(SUBJECTS[1], &mut kept);
//! let mut display = Pins::new(Limits::IDEAL, &mut forces)?;
//!
//! // Frames at 50 Hz: an edge over the left half of the sensors.
//! for _ in 0..50 {
//!     let mut wanted: [f32; SENSORS] = core::array::from_fn(|n| if n % 4 < 2 { 0.1 } else { 0.0 });
//!     afterimage.take_off(&mut wanted)?;
//!     let solution = matching.forces(&wanted)?;
//!     display.advance(0.02, solution.forces)?;
//!     matching.felt(display.forces_n(), &mut felt)?;
//!     afterimage.advance(0.02, &felt)?;
//! }
//! let forces = display.forces_n();
//! assert!(forces[0] > 0.1 && forces[0] > 3.0 * forces[3]);
//! # Ok::<(), ridgetone_teletaction::display::Error>(())
//! ```
//!
//! The method is that of Moy et al., *Human Psychophysics for Teletaction System Design*: an
//! elastic half plane (equations 1 to 4), the Kelvin body (5 to 8), and strain matching (9 to 11).
//!
//! - Forces only press: least squares without negative forces, by block principal pivoting. The
//!   solution fulfils the conditions of an optimum; [`Solution::is_optimal`] says so.
//! - [`Grid::map`] gives the response of strain or stress to a line load (one row of pins) or to a
//!   force at a point (several rows). Strain is that of the paper's slices in both, or that of a
//!   half space ([`Quantity`]). [`half_plane`] has closed forms and transfer functions, with and
//!   without the shear stress between the layers.
//! - [`Afterimage`]: skin keeps part of a strain for seconds. It is taken off the wanted strains, so
//!   a long touch needs less force. A pressing pin cannot take it away.
//! - [`Pins`] gives whole levels from none to the greatest force, at the display's own rate, and no
//!   step beyond its slew, whatever is wanted. NaN and impossible settings are errors, and the pins
//!   stay as they are; [`Pins::release`] lets them go.
//! - Linear, quasi-static, flat. A real finger is none of these, as the paper says of itself.

// `!(a > b)` is intended: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod afterimage;
mod error;
mod grid;
pub mod half_plane;
pub mod half_space;
mod kelvin;
mod limits;
mod matching;
mod nonnegative;
mod packed;
mod sensor_space;
mod set;

pub use afterimage::Afterimage;
pub use error::Error;
pub use grid::{Grid, Quantity};
pub use kelvin::{Kelvin, SUBJECTS};
pub use limits::{Limits, Pins, Steps};
pub use matching::{Matching, PINS_MAX, Solution};
