//! Gratings and displays under a layer of rubber: Figures 17, 18, 19 and 22.

use super::layers::RUBBER;
use ridgetone_teletaction::display::half_plane::{normal_wave, strain_without_shear};
use ridgetone_teletaction::pins::{Pressure, pins_with_errors, ridges};

/// How deep a grating indents, millimetres (section 2.6). No index depends on it.
const INDENT_MM: f64 = 2.0;

/// The rubber, and the receptors' depth below it, millimetres (figure 18).
const RUBBER_MM: f64 = 2.0;
const SKIN_MM: f64 = 0.7;

/// Periods that people felt: experiments 1 and 2, millimetres.
pub const PERIODS_MM: [f64; 10] = [2.4, 3.0, 3.4, 3.6, 3.8, 4.0, 4.2, 4.4, 4.8, 5.2];

/// The pressure under a grating, over Young's modulus.
fn pressure(period_mm: f64) -> Pressure {
    Pressure::under(&ridges(period_mm, INDENT_MM))
}

/// Modulation indices of strain at the receptors (Figure 18), and of stress at the skin (Figure
/// 19): each with and without shear stress between two layers of rubber.
#[derive(Clone, Copy, Debug)]
pub struct Indices {
    pub strain: (f64, f64),
    pub stress: (f64, f64),
}

impl Indices {
    pub fn of(period_mm: f64) -> Self {
        let pressure = pressure(period_mm);
        let half_mm = 0.5 * RUBBER_MM;
        let index = |transfer: &dyn Fn(f64) -> f64| pressure.index(1, transfer);
        Self {
            strain: (
                index(&|k| normal_wave(k, RUBBER_MM + SKIN_MM).strain(RUBBER)),
                index(&|k| strain_without_shear(k, half_mm, half_mm + SKIN_MM, RUBBER)),
            ),
            stress: (
                index(&|k| normal_wave(k, RUBBER_MM).z),
                index(&|k| normal_wave(k, half_mm).z * normal_wave(k, half_mm).z),
            ),
        }
    }
}

/// Strain at the receptors cell by cell (Figure 17d), and its mean.
pub fn figure_17d(period_mm: f64) -> (Vec<f64>, f64) {
    let deep = pressure(period_mm).at_depth(|k| normal_wave(k, RUBBER_MM + SKIN_MM).strain(RUBBER));
    let mean = deep.iter().sum::<f64>() / deep.len() as f64;
    (deep, mean)
}

/// Spacing of the pins in Figure 22, millimetres.
pub const SPACING_MM: f64 = 2.0;

/// Index of normal stress under 2 mm of rubber, if pins are off by a share of their height, with a
/// period of `pins` pins (Figure 22).
pub fn figure_22(pins: usize, error: f64) -> f64 {
    Pressure::under(&pins_with_errors(SPACING_MM, pins, error))
        .index(1, |k| normal_wave(k, RUBBER_MM).z)
}
