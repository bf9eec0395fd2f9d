//! Positions of pins or sensors on a regular grid, and the strain at a sensor under the force of a
//! pin.
//!
//! A pin is a point force on a half space: Boussinesq's solution (Johnson, *Contact Mechanics*,
//! section 3.2, equation 3.18). Compression is positive. Strains are multiplied by Young's modulus
//! and are per newton, so strains and stresses are both per square millimetre.

use super::Error;
use crate::stimulus::within;
use std::f64::consts::PI;

/// A regular grid around the origin, row by row: columns along x, rows along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    columns: usize,
    rows: usize,
    spacing_mm: f64,
}

impl Grid {
    /// Creates a grid of 1 to 1000 columns and rows, 0.01 to 100 mm apart.
    pub fn new(columns: usize, rows: usize, spacing_mm: f64) -> Result<Self, Error> {
        within("columns", columns as f32, 1.0, 1000.0)?;
        within("rows", rows as f32, 1.0, 1000.0)?;
        within("spacing_mm", spacing_mm as f32, 0.01, 100.0)?;
        Ok(Self {
            columns,
            rows,
            spacing_mm,
        })
    }

    pub const fn count(&self) -> usize {
        self.columns * self.rows
    }

    pub const fn columns(&self) -> usize {
        self.columns
    }

    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Position of point `index` along x and y, millimetres.
    pub fn position_mm(&self, index: usize) -> (f64, f64) {
        let along =
            |n: usize, count: usize| (n as f64 - 0.5 * (count as f64 - 1.0)) * self.spacing_mm;
        (
            along(index % self.columns, self.columns),
            along(index / self.columns, self.rows),
        )
    }
}

/// Mechanical quantity to match: measured under the sensor's skin, and reproduced in the finger by
/// the pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Normal strain in the paper's thin slices (plane stress).
    Strain,
    /// Normal strain in a half space. Its integral over the plane is 1 - poisson - 2 poisson^2
    /// times the force, which is zero for rubber: a wide, even pressure hardly strains it.
    HalfSpaceStrain,
    /// Normal stress. Shear stress is left out because no pin display can produce it.
    Stress,
}

/// A layer over the sensors: depth 0.1 to 100 mm, Poisson's ratio 0 to 0.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    pub depth_mm: f64,
    pub poisson: f64,
    pub quantity: Quantity,
}

impl Layer {
    pub fn check(&self) -> Result<(), Error> {
        within("depth_mm", self.depth_mm as f32, 0.1, 100.0)?;
        within("poisson", self.poisson as f32, 0.0, 0.5)?;
        Ok(())
    }

    /// Response at a distance of `r_mm` from a force of 1 N.
    pub fn response(&self, r_mm: f64) -> f64 {
        match self.quantity {
            Quantity::Strain => self.slice_strain(r_mm),
            Quantity::HalfSpaceStrain => self.strain(r_mm, self.poisson),
            Quantity::Stress => {
                let r2 = r_mm * r_mm + self.depth_mm * self.depth_mm;
                1.5 / PI * self.depth_mm.powi(3) / (r2 * r2 * r2.sqrt())
            }
        }
    }

    fn strain(&self, r_mm: f64, poisson: f64) -> f64 {
        let depth = self.depth_mm * self.depth_mm;
        // The stress along z minus Poisson's ratio times the sum of the radial and the
        // circumferential stress; with r^2 = R^2 - z^2 the sum has two terms.
        let inverse = 1.0 / (r_mm * r_mm + depth);
        0.5 / PI
            * (1.0 + poisson)
            * self.depth_mm
            * inverse
            * inverse.sqrt()
            * (3.0 * depth * inverse - 2.0 * poisson)
    }

    /// Strain in a thin slice. Under a line load a half space is in plane strain, and plane strain
    /// with Poisson's ratio v / (1 + v) equals plane stress with v if Young's modulus is multiplied
    /// by (1 + 2 v) / (1 + v)^2.
    fn slice_strain(&self, r_mm: f64) -> f64 {
        let one_more = 1.0 + self.poisson;
        let modulus = (one_more + self.poisson) / (one_more * one_more);
        self.strain(r_mm, self.poisson / one_more) / modulus
    }
}
