//! Rigid gratings and displays of pins against an elastic half plane: the pressure on the surface,
//! and how much of its ripple arrives at a depth.
//!
//! Moy et al., appendix (equations 17 to 21) and sections 2.6 and 2.7, read as follows. The
//! deflection is prescribed where there is contact; elsewhere there is no pressure; a pressure that
//! pulls is set to 0. The paper's order - invert everywhere, then clip - depends on the grid and
//! fails. Everything repeats, so that nothing has an edge.

use std::f64::consts::{PI, TAU};

/// Half of the width of a line load, millimetres (appendix: x_0).
const HALF_LOAD_MM: f64 = 0.025;

/// Distance from which on a line load deflects nothing, millimetres (appendix: x_b).
const REACH_MM: f64 = 3.0;

/// Width of a cell, millimetres: that of a line load. Smaller cells are ill-conditioned, since the
/// deflection below a load is as large as that beside it.
pub const CELL_MM: f64 = 2.0 * HALF_LOAD_MM;

/// Deflection at a distance from a line load of 1 N/mm, millimetres times Young's modulus (equation
/// 17).
fn deflection(x_mm: f64) -> f64 {
    let x_mm = x_mm.abs().max(HALF_LOAD_MM);
    if x_mm < REACH_MM {
        2.0 / PI * (REACH_MM / x_mm).ln()
    } else {
        0.0
    }
}

/// A periodic pressure on the surface, over Young's modulus, in cells of [`CELL_MM`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure(Vec<f64>);

impl Pressure {
    /// That makes these deflections, millimetres, in the cells where there is contact.
    pub fn under(contact_mm: &[Option<f64>]) -> Self {
        let count = contact_mm.len();
        let touched: Vec<(usize, f64)> = contact_mm
            .iter()
            .enumerate()
            .filter_map(|(n, mm)| Some((n, (*mm)?)))
            .collect();
        // All repetitions within reach count.
        let repeated: Vec<f64> = (0..count)
            .map(|n| {
                let times = (REACH_MM / (count as f64 * CELL_MM)) as i32 + 1;
                let at =
                    |time: i32| deflection((n as f64 + f64::from(time) * count as f64) * CELL_MM);
                (-times..=times).map(at).sum()
            })
            .collect();
        let mut rows: Vec<Vec<f64>> = touched
            .iter()
            .map(|(i, mm)| {
                touched
                    .iter()
                    .map(|(j, _)| repeated[i.abs_diff(*j)])
                    .chain([*mm])
                    .collect()
            })
            .collect();
        eliminate(&mut rows);
        let mut pressure = vec![0.0; count];
        for ((n, _), row) in touched.iter().zip(&rows) {
            pressure[*n] = (row[touched.len()] / CELL_MM).max(0.0);
        }
        Self(pressure)
    }

    /// Cell by cell.
    pub fn cells(&self) -> &[f64] {
        &self.0
    }

    /// Mean over a whole period.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Wave number of a harmonic, radians per millimetre.
    fn wave_number(&self, harmonic: usize) -> f64 {
        TAU * harmonic as f64 / (self.0.len() as f64 * CELL_MM)
    }

    /// Cosine and sine amplitude of a harmonic, from 1 on.
    fn harmonic(&self, harmonic: usize) -> (f64, f64) {
        let turn = TAU * harmonic as f64 / self.0.len() as f64;
        self.0
            .iter()
            .enumerate()
            .fold((0.0, 0.0), |(cosine, sine), (n, p)| {
                let (sin, cos) = (turn * n as f64).sin_cos();
                let share = 2.0 * p / self.0.len() as f64;
                (cosine + share * cos, sine + share * sin)
            })
    }

    /// Modulation index (equations 13 and 14) at a depth: amplitude of a harmonic over the mean.
    /// `transfer` is that of the depth, over radians per millimetre.
    pub fn index(&self, harmonic: usize, transfer: impl Fn(f64) -> f64) -> f64 {
        let (cosine, sine) = self.harmonic(harmonic);
        cosine.hypot(sine) * transfer(self.wave_number(harmonic)).abs()
            / (self.mean() * transfer(0.0))
    }

    /// The profile at a depth, cell by cell.
    pub fn at_depth(&self, transfer: impl Fn(f64) -> f64) -> Vec<f64> {
        let count = self.0.len();
        let waves: Vec<(f64, f64)> = (1..count / 2)
            .map(|h| {
                let (cosine, sine) = self.harmonic(h);
                let passed = transfer(self.wave_number(h));
                (passed * cosine, passed * sine)
            })
            .collect();
        let value = |n: usize| {
            let wave = |(h, (cosine, sine)): (usize, &(f64, f64))| {
                // Whole turns are left out, for the precision.
                let (sin, cos) = (TAU * ((h + 1) * n % count) as f64 / count as f64).sin_cos();
                cosine * cos + sine * sin
            };
            self.mean() * transfer(0.0) + waves.iter().enumerate().map(wave).sum::<f64>()
        };
        (0..count).map(value).collect()
    }
}

/// Solves the equations in place by Gauss's elimination with pivots; the last column becomes the
/// solution.
fn eliminate(rows: &mut [Vec<f64>]) {
    let n = rows.len();
    for column in 0..n {
        let size = |row: &usize| rows[*row][column].abs();
        let Some(pivot) = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))) else {
            return;
        };
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let row = &mut above[column];
        let scale = 1.0 / row[column];
        row[column..].iter_mut().for_each(|value| *value *= scale);
        for other in below.iter_mut() {
            let factor = other[column];
            other[column..]
                .iter_mut()
                .zip(&row[column..])
                .for_each(|(value, above)| *value -= factor * above);
        }
    }
    for column in (1..n).rev() {
        let value = rows[column][n];
        for row in &mut rows[..column] {
            row[n] -= row[column] * value;
        }
    }
}

/// Cells of a length, millimetres.
fn cells(length_mm: f64) -> usize {
    (length_mm / CELL_MM).round() as usize
}

/// One period of a rectangular grating whose ridges, half of the period wide, indent by
/// `indent_mm`.
pub fn ridges(period_mm: f64, indent_mm: f64) -> Vec<Option<f64>> {
    let count = cells(period_mm);
    (0..count)
        .map(|n| (n < count / 2).then_some(indent_mm))
        .collect()
}

/// One period of a display with pins half as wide as their spacing, at 1 mm, each off by `error`
/// times a cosine over `pins` pins: the worst that a resolution can do (section 2.7 and figure 21).
pub fn pins_with_errors(spacing_mm: f64, pins: usize, error: f64) -> Vec<Option<f64>> {
    let count = cells(spacing_mm);
    let cell = |n: usize| {
        let (pin, place) = (n / count, n % count);
        let height_mm = 1.0 + error * (TAU * pin as f64 / pins as f64).cos();
        (place < count / 2).then_some(height_mm)
    };
    (0..pins * count).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::half_plane::{normal_wave, strain_without_shear};

    fn strain(depth_mm: f64) -> impl Fn(f64) -> f64 {
        move |k| normal_wave(k, depth_mm).strain(0.5)
    }

    #[test]
    fn the_pressure_makes_the_deflection() {
        let contact = ridges(4.0, 2.0);
        let pressure = Pressure::under(&contact);
        for (n, wanted) in contact.iter().enumerate() {
            let made: f64 = (-160..240i32)
                .map(|m| {
                    let p = pressure.cells()[m.rem_euclid(80) as usize];
                    p * CELL_MM * deflection(f64::from(n as i32 - m) * CELL_MM)
                })
                .sum();
            match wanted {
                Some(wanted) => assert!((made - wanted).abs() < 1e-9, "{n}: {made}"),
                // Between ridges the surface stands higher.
                None => assert!(made < 2.0 && pressure.cells()[n] == 0.0, "{n}: {made}"),
            }
        }
    }

    /// Section 2.6 with figure 17d, and section 4.1 with figure 18.
    #[test]
    fn indices_are_the_papers() {
        let of = |period_mm: f64| Pressure::under(&ridges(period_mm, 2.0));
        let pressure = of(4.0);
        let deep = pressure.at_depth(strain(2.7));
        let mean = deep.iter().sum::<f64>() / deep.len() as f64;
        assert!(
            (mean - 0.22).abs() < 0.02 && (mean - 0.5 * pressure.mean()).abs() < 1e-12,
            "{mean}"
        );
        for (period_mm, least, most) in [(4.0, 0.16, 0.20), (3.4, 0.10, 0.15), (3.6, 0.10, 0.15)] {
            let index = of(period_mm).index(1, strain(2.7));
            println!("{period_mm} {index}");
            assert!((least..=most).contains(&index), "{period_mm}: {index}");
            assert!(of(period_mm).index(1, |k| strain_without_shear(k, 1.0, 1.7, 0.5)) > index);
        }
        // The profile is all but sinusoidal above 0.2 cycles a millimetre.
        let (low, high) = deep
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), v| (v.min(l), v.max(h)));
        let by_extremes = (high - low) / (2.0 * mean);
        assert!(
            (by_extremes / pressure.index(1, strain(2.7)) - 1.0).abs() < 0.05,
            "{by_extremes}"
        );
    }

    /// Figure 22: about 0.06 at 4 mm with 10 %, and below 0.1.
    #[test]
    fn errors_of_the_pins_are_the_papers() {
        let stress = |k: f64| normal_wave(k, 2.0).z;
        let index =
            |pins: usize| Pressure::under(&pins_with_errors(2.0, pins, 0.1)).index(1, stress);
        println!("{} {} {}", index(2), index(5), index(10));
        assert!((index(2) - 0.06).abs() < 0.01, "{}", index(2));
        assert!(index(5) < 0.1, "{}", index(5));
    }
}
