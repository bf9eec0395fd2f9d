//! An update: what is pressed becomes forces within the display's limits. The part beside the fit, whose memory it borrows.

use crate::pins::Due;
use crate::pins::strains::{UNIT_PITCH_MM, by_place, of_pressure};
use ads1258::reading;
use heapless::Vec;
use ridgetone_display::{Limits, Pressing, Square, Steps};
use ridgetone_proto::settings::{PinDisplay, Settings};
use ridgetone_proto::telemetry::{PINS_SIDE_MAX, Pins};

/// Memory that [`Driver::update`] needs, values.
pub const MEMORY: usize = Square::floats(PINS_SIDE_MAX);

/// How much even forces are preferred: as `ridgetone pins` has it.
const REGULARISATION: f32 = 0.01;
/// Systems that an update solves at most: 10 x 10 pins stay below 200,000 instructions.
const PIVOTS_MAX: u32 = 6;
/// Poisson's ratio of the finger on the pins: as rubber, it keeps its volume.
const POISSON: f32 = 0.5;

/// Where the pins are.
#[derive(Clone, Debug)]
pub struct Driver {
    levels: [u8; PINS_SIDE_MAX * PINS_SIDE_MAX],
    pressing: Pressing,
}

impl Driver {
    /// Pins that do not press.
    pub const fn new() -> Self {
        Self { levels: [0; PINS_SIDE_MAX * PINS_SIDE_MAX], pressing: Pressing::new() }
    }

    /// Moves the pins towards what is pressed. They go down where no force can be computed. `settings.pins` must be on and
    /// valid; `memory` has [`MEMORY`] values, whose content does not matter.
    // Not inlined: it runs between fits, which need the stack.
    #[inline(never)]
    pub fn update(&mut self, due: &Due, memory: &mut [f32], settings: &Settings) -> Pins {
        let PinDisplay { side, spacing_mm, depth_mm, mpa_per_v, .. } = settings.pins;
        if due.is_first {
            *self = Self::new();
        }
        let mpa_per_code = reading::volts(1, settings.vref_v) * mpa_per_v;
        // Strain times Young's modulus.
        let wanted = by_place(&of_pressure(&due.pressed, due.taxels)).map(|code| code * mpa_per_code);
        let side = usize::from(side);
        let display = Square {
            side,
            spacing_mm,
            sensor_spacing_mm: (0.5 * UNIT_PITCH_MM) as f32,
            depth_mm,
            poisson: POISSON,
            regularisation: REGULARISATION,
            pivots_max: PIVOTS_MAX,
        };
        let solution = display.forces(memory, &wanted, &mut self.pressing);
        let is_optimal = solution.as_ref().is_some_and(|solution| solution.is_optimal);
        let forces_n = solution.as_ref().map_or(&[][..], |solution| solution.forces);
        let limits = limits(&settings.pins);
        let (steps, greatest_n) = (Steps::new(&limits), limits.greatest_n());
        let mut pins = Pins {
            t_us: due.t_us,
            taxels: due.taxels,
            limited: 0,
            is_optimal,
            level_n: steps.quantum_n(),
            levels: Vec::new(),
        };
        for (pin, level) in self.levels.iter_mut().take(side * side).enumerate() {
            let wanted_n = forces_n.get(pin).copied().unwrap_or(0.0);
            *level = steps.towards(u16::from(*level), wanted_n) as u8;
            pins.limited += u8::from(wanted_n > greatest_n);
            // There is space for every pin.
            let _ = pins.levels.push(*level);
        }
        pins
    }
}

impl Default for Driver {
    fn default() -> Self {
        Self::new()
    }
}

/// The limits of a display, as the crate `ridgetone-display` has them.
pub fn limits(display: &PinDisplay) -> Limits {
    Limits {
        force_n: display.force_n,
        stroke_mm: display.stroke_mm,
        stiffness_n_mm: PinDisplay::STIFFNESS_N_MM,
        update_hz: f32::from(display.rate_hz),
        levels: u16::from(display.levels),
        slew_n_s: display.slew_n_s,
    }
}
