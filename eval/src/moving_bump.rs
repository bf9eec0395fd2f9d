//! A bump that moves over 4 x 4 sensors: the frames of the benchmark of a display, and the firmware's updates of one; the same on the chip
//! and here.

use ridgetone::pins::strains::{PLACES, UNIT_PITCH_MM};
use ridgetone::pins::{Driver, Due};
use ridgetone_display::{Error, Grid, Matching, Quantity};
use ridgetone_proto::settings::{PinDisplay, Settings};

/// Sensors, 4 x 4, 3 mm apart.
const SIDE: usize = 4;
const SPACING_MM: f64 = 3.0;

/// Pins at most.
const PINS: usize = 100;

/// Memory of the display.
pub const FLOATS: usize = Matching::floats(PINS, SIDE * SIDE);

/// A display of `side` x `side` pins over the 9 mm of the sensors, 1.5 mm below the skin's surface.
pub fn matching(memory: &mut [f32], side: usize) -> Result<Matching<'_>, Error> {
    let sensors = Grid::new(SIDE, SIDE, SPACING_MM)?;
    let width_mm = SPACING_MM * (SIDE - 1) as f64;
    let pins = Grid::new(side, side, width_mm / (side.max(2) - 1) as f64)?;
    Matching::new(memory, pins.count(), sensors.count(), 0.01, sensors.map(&pins, 1.5, 0.5, Quantity::Strain)?)
}

/// One frame: a bump 2 mm wide, 0.2 mm farther in each, from 8 mm before the middle on. Gives the number of multiplications and the bits of
/// the sum of all forces.
pub fn step(matching: &mut Matching<'_>, frame: u32) -> Option<(u32, u32)> {
    let at_mm = -8.0 + 0.2 * frame as f32;
    let place = |n: usize| SPACING_MM as f32 * (n as f32 - 1.5);
    let wanted: [f32; SIDE * SIDE] = core::array::from_fn(|n| {
        let (x, y) = (place(n % SIDE) - at_mm, place(n / SIDE));
        libm::expf(-0.25 * (x * x + y * y))
    });
    let solution = matching.forces(&wanted).ok()?;
    let sum: f32 = solution.forces.iter().sum();
    solution.is_optimal.then_some((solution.multiply_adds, sum.to_bits()))
}

/// Settings of a display of `side` x `side` pins over a fingertip 10 mm wide, with the other limits by default.
pub fn settings(side: u8) -> Settings {
    let spacing_mm = 10.0 / f32::from(side.max(1));
    Settings { pins: PinDisplay { rate_hz: 20, side, spacing_mm, ..PinDisplay::DEFAULT }, ..Settings::DEFAULT }
}

/// One update of the firmware: a bump 1 mm wide, 0.1 mm farther in each, from 4 mm before the middle on. Gives the number of pins that are
/// limited, and the sum of all levels.
pub fn update(driver: &mut Driver, memory: &mut [f32], settings: &Settings, frame: u32) -> (u32, u32) {
    let at_mm = -4.0 + 0.1 * frame as f32;
    let place = |n: usize| 0.5 * UNIT_PITCH_MM as f32 * (n as f32 - 1.5);
    let mut pressed = [0.0; SIDE * SIDE];
    for (n, taxel) in PLACES.as_flattened().iter().enumerate() {
        let (x, y) = (place(n % SIDE) - at_mm, place(n / SIDE));
        if let Some(code) = pressed.get_mut(*taxel) {
            *code = 20_000.0 * libm::expf(-(x * x + y * y));
        }
    }
    let due = Due::new(u64::from(frame), u16::MAX, pressed);
    let pins = driver.update(&due, memory, settings);
    (pins.limited.into(), pins.levels.iter().map(|level| u32::from(*level)).sum())
}
