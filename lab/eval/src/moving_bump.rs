//! What moves over 4 x 4 sensors: the frames of the benchmark of a display, and the firmware's
//! updates of one; the same on the chip and here.

use ridgetone::pins::Due;
use ridgetone::pins::strains::{PLACES, UNIT_PITCH_MM};
use ridgetone_display::{Error, Grid, Matching, Quantity};
use ridgetone_proto::settings::{PinDisplay, Settings};
use ridgetone_proto::telemetry::Pins;
use serde::{Deserialize, Serialize};

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
    Matching::new(
        memory,
        pins.count(),
        sensors.count(),
        0.01,
        sensors.map(&pins, 1.5, 0.5, Quantity::Strain)?,
    )
}

/// One frame: a bump 2 mm wide, 0.2 mm farther in each, from 8 mm before the middle on. Gives the
/// number of multiplications and the bits of the sum of all forces.
pub fn step(matching: &mut Matching<'_>, frame: u32) -> Option<(u32, u32)> {
    let at_mm = -8.0 + 0.2 * frame as f32;
    let place = |n: usize| SPACING_MM as f32 * (n as f32 - 1.5);
    let wanted: [f32; SIDE * SIDE] = core::array::from_fn(|n| {
        let (x, y) = (place(n % SIDE) - at_mm, place(n / SIDE));
        libm::expf(-0.25 * (x * x + y * y))
    });
    let solution = matching.forces(&wanted).ok()?;
    let sum: f32 = solution.forces.iter().sum();
    solution
        .is_optimal
        .then_some((solution.multiply_adds, sum.to_bits()))
}

/// Settings of a display of `side` x `side` pins over a fingertip 10 mm wide, with the other limits
/// by default.
pub fn settings(side: u8) -> Settings {
    let spacing_mm = 10.0 / f32::from(side.max(1));
    Settings {
        pins: PinDisplay {
            rate_hz: 20,
            side,
            spacing_mm,
            ..PinDisplay::DEFAULT
        },
        ..Settings::DEFAULT
    }
}

/// What presses in the firmware's updates, from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Load {
    /// A bump 1 mm wide, 0.1 mm farther in each, through the middle along the columns: a mirror
    /// image of itself.
    Along,
    /// The same with a slope of one in three, beside the middle.
    Across,
    /// A bump 1 mm wide that goes round and round, up to 1.5 mm farther in each.
    Fast,
    /// An image that has nothing to do with the one before.
    Unrelated,
    /// All taxels alike, and in the next update none.
    Even,
    /// One taxel alone, another one in each.
    Hot,
    /// Pressed and pulled like the fields of a chessboard, the other way round in each.
    Chessboard,
    /// Each taxel is pressed or pulled as far as can be, by chance.
    Extremes,
    /// As `Unrelated`, while the display's limits and layer change each time.
    Limits,
}

impl Load {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Along,
        Self::Across,
        Self::Fast,
        Self::Unrelated,
        Self::Even,
        Self::Hot,
        Self::Chessboard,
        Self::Extremes,
        Self::Limits,
    ];

    /// Pressure at a place of the array, from -1 to 1, in an update.
    fn pressure(self, place: usize, frame: u32) -> f32 {
        let drawn = || {
            // Of a hash of both: multiplied, shifted, multiplied.
            let bits = (frame << 4 | place as u32)
                .wrapping_add(1)
                .wrapping_mul(0x9e37_79b1);
            ((bits ^ bits >> 15).wrapping_mul(0x85eb_ca77) >> 8) as f32 / 16_777_216.0
        };
        let sign = |is_pressed| if is_pressed { 1.0 } else { -1.0 };
        let along_mm = 0.1 * frame as f32 - 4.0;
        let [x_mm, y_mm] = match self {
            Self::Fast => [
                2.0 * libm::sinf(0.7 * frame as f32),
                1.5 * libm::cosf(0.9 * frame as f32),
            ],
            Self::Across => [along_mm, 0.3 + along_mm / 3.0],
            Self::Along => [along_mm, 0.0],
            Self::Unrelated | Self::Limits => return drawn(),
            Self::Even => return (frame % 2) as f32,
            Self::Hot => {
                return if place as u32 == frame * 7 % 16 {
                    1.0
                } else {
                    0.0
                };
            }
            Self::Chessboard => {
                return sign((place % SIDE + place / SIDE + frame as usize).is_multiple_of(2));
            }
            Self::Extremes => return sign(drawn() < 0.5),
        };
        let at_mm = |n: usize| 0.5 * UNIT_PITCH_MM as f32 * (n as f32 - 1.5);
        let (x, y) = (at_mm(place % SIDE) - x_mm, at_mm(place / SIDE) - y_mm);
        libm::expf(-(x * x + y * y))
    }

    /// What falls due in an update.
    pub fn due(self, frame: u32) -> Due {
        let mut pressed = [0.0; SIDE * SIDE];
        for (place, taxel) in PLACES.as_flattened().iter().enumerate() {
            if let Some(code) = pressed.get_mut(*taxel) {
                *code = 20_000.0 * self.pressure(place, frame);
            }
        }
        Due::new(50_000 * u64::from(frame), u16::MAX, pressed)
    }
}

/// Settings of a display in an update, by its own ones: other limits and another layer in each of
/// [`Load::Limits`].
pub fn settings_in(settings: &Settings, load: Load, frame: u32) -> Settings {
    if load != Load::Limits {
        return *settings;
    }
    let (of_three, of_four) = ((frame % 3) as f32, (frame % 4) as f32);
    let pins = PinDisplay {
        levels: 200 - 60 * (frame % 3) as u8,
        force_n: 2.0 - 0.6 * of_three,
        depth_mm: 0.5 + of_four,
        spacing_mm: settings.pins.spacing_mm * (1.0 + of_three),
        ..settings.pins
    };
    Settings { pins, ..*settings }
}

/// What must be the same on the chip and here: pins that are limited, whether the forces are the
/// best, and the levels.
pub fn summary(pins: &Pins) -> (u32, u32) {
    // Each level counts by its place.
    let hash = |hash: u32, level: &u8| hash.wrapping_mul(31).wrapping_add(u32::from(*level));
    (
        u32::from(pins.limited) << 1 | u32::from(pins.is_optimal),
        pins.levels.iter().fold(0, hash),
    )
}
