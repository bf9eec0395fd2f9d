//! Places of pins, or of sensors, on a regular grid.

use crate::display::error::{Error, within};

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
    /// millimetre across. Otherwise they are on the half space, and the force is in newtons.
    /// `depth_mm`: 0.1 to 100. `quantity` is strain times Young's modulus, or stress.
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
            let value = if sensors.rows == 1 && pins.rows == 1 {
                let stress = crate::display::half_plane::normal(x - pin_x, depth_mm);
                match quantity {
                    Quantity::Strain => stress.strain(poisson),
                    Quantity::Stress => stress.z,
                }
            } else {
                let (r_mm, depth_mm) = (f64::hypot(x - pin_x, y - pin_y) as f32, depth_mm as f32);
                return match quantity {
                    Quantity::Strain => {
                        crate::display::half_space::strain(r_mm, depth_mm, poisson as f32)
                    }
                    Quantity::Stress => crate::display::half_space::stress(r_mm, depth_mm),
                };
            };
            value as f32
        })
    }
}

/// What sensor and finger have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Normal strain times Young's modulus: strain matching.
    Strain,
    /// Normal stress: stress matching. Shear stress is left out, as no display of pins can make it.
    Stress,
}
