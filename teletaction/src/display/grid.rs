//! Places of pins, or of sensors, on a regular grid.

use crate::display::error::{Error, within};
use crate::display::{half_plane, half_space};

/// A regular grid around the origin, row by row: the columns along x, the rows along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    columns: usize,
    rows: usize,
    spacing_mm: f64,
}

impl Grid {
    /// `spacing_mm` is the distance of neighbours, millimetres, from 0.01 to 100. Columns and rows:
    /// 1 to 1000.
    pub const fn new(columns: usize, rows: usize, spacing_mm: f64) -> Result<Self, Error> {
        // `within` is not const: a grid is often a constant.
        if !(columns >= 1 && columns <= 1000) {
            return Err(Error::Setting {
                name: "columns",
                value: columns as f64,
                least: 1.0,
                greatest: 1000.0,
            });
        }
        if !(rows >= 1 && rows <= 1000) {
            return Err(Error::Setting {
                name: "rows",
                value: rows as f64,
                least: 1.0,
                greatest: 1000.0,
            });
        }
        if !(spacing_mm >= 0.01 && spacing_mm <= 100.0) {
            return Err(Error::Setting {
                name: "spacing_mm",
                value: spacing_mm,
                least: 0.01,
                greatest: 100.0,
            });
        }
        Ok(Self {
            columns,
            rows,
            spacing_mm,
        })
    }

    /// Number of places.
    pub const fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Number of columns.
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Distance of neighbours, millimetres.
    pub const fn spacing_mm(&self) -> f64 {
        self.spacing_mm
    }

    /// Where number `index` is, millimetres: along x and along y.
    pub fn place_mm(&self, index: usize) -> (f64, f64) {
        let along =
            |n: usize, count: usize| (n as f64 - 0.5 * (count as f64 - 1.0)) * self.spacing_mm;
        (
            along(index % self.columns, self.columns),
            along(index / self.columns, self.rows),
        )
    }

    /// Response of place `at` of this grid to a unit force at place `pin` of another: what
    /// [`Matching::new`] takes as its map.
    ///
    /// If both grids have one row, they are a slice of the half plane, and the force is per
    /// millimetre across. Otherwise, and always for [`Quantity::HalfSpaceStrain`], the force is at a
    /// point, in newtons. `depth_mm`: 0.1 to 100.
    ///
    /// [`Matching::new`]: crate::display::Matching::new
    pub fn map(
        &self,
        pins: &Grid,
        depth_mm: f64,
        poisson: f64,
        quantity: Quantity,
    ) -> Result<impl Fn(usize, usize) -> f32 + use<>, Error> {
        within("depth_mm", depth_mm, 0.1, 100.0)?;
        within("poisson", poisson, 0.0, 0.5)?;
        let (sensors, pins) = (*self, *pins);
        Ok(move |sensor: usize, pin: usize| {
            let ((x, y), (pin_x, pin_y)) = (sensors.place_mm(sensor), pins.place_mm(pin));
            let is_slice = sensors.rows == 1 && pins.rows == 1;
            let line = || half_plane::normal(x - pin_x, depth_mm);
            let r_mm = f64::hypot(x - pin_x, y - pin_y) as f32;
            let (z_mm, ratio) = (depth_mm as f32, poisson as f32);
            match quantity {
                Quantity::Strain if is_slice => line().strain(poisson) as f32,
                Quantity::Strain => half_space::slice_strain(r_mm, z_mm, ratio),
                Quantity::HalfSpaceStrain => half_space::strain(r_mm, z_mm, ratio),
                Quantity::Stress if is_slice => line().z as f32,
                Quantity::Stress => half_space::stress(r_mm, z_mm),
            }
        })
    }
}

/// What sensor and finger have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Normal strain times Young's modulus, as the paper's slices have it (plane stress): strain
    /// matching.
    Strain,
    /// Normal strain times Young's modulus in a half space, where nothing gives way across: a wide
    /// even pressure hardly strains rubber, so that matching takes greater forces.
    HalfSpaceStrain,
    /// Normal stress: stress matching. Shear stress is left out, as no display of pins can make it.
    Stress,
}
