//! Strain matching of a block 4 mm wide: Figure 8.

use super::layers::RUBBER;
use anyhow::{Context, Result};
use nalgebra::{DMatrix, DVector};
use ridgetone_teletaction::display::half_plane::normal;
use ridgetone_teletaction::display::{Grid, Matching, Quantity};

/// The numbers of section 2.3: millimetres.
const DEPTH_MM: f64 = 1.5;
const WIDTH_MM: f64 = 4.0;
const PIN_MM: f64 = 1.0;
const STEP_MM: f64 = 0.1;

/// Pins and sensors reach from -5 to 5 mm.
const PINS: usize = 11;
const SENSORS: usize = 101;

/// Regularisation of the third column.
pub const REGULARISATION: f32 = 0.03;

/// A way to choose the forces.
#[derive(Clone, Debug)]
pub struct Way {
    pub name: &'static str,
    /// Newtons per millimetre across, for a pressure of 1 N/mm^2.
    pub forces: Vec<f64>,
    /// Root mean square error of that over the root mean square of the sensors'.
    pub error: f64,
}

#[derive(Clone, Debug)]
pub struct Figure8 {
    pub ways: Vec<Way>,
    /// Greatest over smallest singular value of the map.
    pub condition: f64,
}

pub fn block() -> Result<Figure8> {
    let sensors = Grid::new(SENSORS, 1, STEP_MM)?;
    let pins = Grid::new(PINS, 1, PIN_MM)?;
    let x_mm: Vec<f64> = (0..SENSORS).map(|n| sensors.place_mm(n).0).collect();
    let pin_mm: Vec<f64> = (0..PINS).map(|n| pins.place_mm(n).0).collect();
    // Line loads 0.02 mm apart under the block (equation 9).
    let loads = 200;
    let step_mm = WIDTH_MM / f64::from(loads);
    let at = |x: f64| {
        let load = |n: i32| {
            normal(
                x + 0.5 * WIDTH_MM - (f64::from(n) + 0.5) * step_mm,
                DEPTH_MM,
            )
            .strain(RUBBER)
        };
        (0..loads).map(load).sum::<f64>() * step_mm
    };
    let strain: Vec<f64> = x_mm.iter().map(|x| at(*x)).collect();

    // Equation 11 by the library's singular values.
    let map = DMatrix::from_fn(SENSORS, PINS, |sensor, pin| {
        normal(x_mm[sensor] - pin_mm[pin], DEPTH_MM).strain(RUBBER)
    });
    let values = map.singular_values();
    let any_sign = map
        .clone()
        .svd(true, true)
        .solve(&DVector::from_vec(strain.clone()), 1e-12);
    let any_sign = any_sign.map_err(anyhow::Error::msg)?;
    let way = |name, forces: Vec<f64>| {
        let made: Vec<f64> = (&map * DVector::from_vec(forces.clone()))
            .iter()
            .copied()
            .collect();
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let error = squares(&mut made.iter().zip(&strain).map(|(a, b)| a - b))
            / squares(&mut strain.iter().copied());
        Way {
            name,
            forces,
            error: error.sqrt(),
        }
    };
    let wanted: Vec<f32> = strain.iter().map(|strain| *strain as f32).collect();
    let pressing = |regularisation: f32| -> Result<Vec<f64>> {
        let map = sensors.map(&pins, DEPTH_MM, RUBBER, Quantity::Strain)?;
        let mut memory = vec![0.0; Matching::floats(PINS, SENSORS)];
        let mut matching = Matching::new(&mut memory, PINS, SENSORS, regularisation, map)?;
        Ok(matching
            .forces(&wanted)?
            .forces
            .iter()
            .map(|force| f64::from(*force))
            .collect())
    };
    let ways = vec![
        way("any sign (equation 11)", any_sign.iter().copied().collect()),
        way("pressing only", pressing(0.0)?),
        way("pressing only, regularised", pressing(REGULARISATION)?),
    ];
    let condition = values.max()
        / values
            .iter()
            .copied()
            .reduce(f64::min)
            .context("no singular values")?;
    Ok(Figure8 { ways, condition })
}
