//! Strain matching: finds the pin forces whose strains in the finger are nearest to the sensor's.
//!
//! Equations 9 to 11 of Moy et al., *Human Psychophysics for Teletaction System Design*, with
//! forces that can only press and Tikhonov regularisation: minimise |A'x - w|^2 + c |x|^2 with x >=
//! 0, where row i of A holds the strains under pin i.
//!
//! The method is block principal pivoting (Kim and Park, *Fast Nonnegative Matrix Factorization: An
//! Active-Set-Like Method and Comparisons*, SIAM J. Sci. Comput. 33 (2011), section 4). For the set
//! P of pins that press, v solves (A_P' A_P + c) v = w, with one unknown per sensor. The force of a
//! pin that presses is its row times v. The gradient of an idle pin is -c times its row times v:
//! an idle pin with a positive product has to press.

use super::Error;
use super::grid::{Grid, Layer};
use crate::stimulus::within;

/// Maximum number of pins: a display of 10 x 10.
pub const PINS_MAX: usize = 100;

/// Maximum number of pivots, which bounds the time per frame. None of 1,600 random frames took more
/// than 12.
const PIVOTS_MAX: u32 = 20;

/// Attempts to exchange all pins at once before exchanging single pins (Kim and Park, section 4.2).
const TRIES: u32 = 3;

/// Forces below this fraction of the largest count as zero.
const ZERO: f64 = 1e-10;

/// Pins and sensors, with everything that is computed only once.
#[derive(Clone, Debug)]
pub struct Matching {
    /// Strains at the sensors under 1 N, one row per pin.
    map: Vec<Vec<f64>>,
    sensors: usize,
    /// Regularisation, c.
    constant: f64,
    pressing: Vec<bool>,
    forces: Vec<f64>,
}

/// Forces for one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<'a> {
    /// Forces, newtons, at least 0.
    pub forces: &'a [f64],
    /// Number of systems solved.
    pub pivots: u32,
    /// False if the pivots were used up: the forces are then feasible but not optimal.
    pub is_optimal: bool,
}

impl Matching {
    /// `regularisation` (1e-9 to 10) is relative to the mean square of a pin's strains. It
    /// suppresses noise by making forces smaller and more even.
    pub fn new(
        sensors: &Grid,
        pins: &Grid,
        layer: &Layer,
        regularisation: f64,
    ) -> Result<Self, Error> {
        within("pins", pins.count() as f32, 1.0, PINS_MAX as f32)?;
        within("regularisation", regularisation as f32, 1e-9, 10.0)?;
        layer.check()?;
        let response = |pin: usize, sensor: usize| {
            let ((x, y), (pin_x, pin_y)) = (sensors.position_mm(sensor), pins.position_mm(pin));
            layer.response(f64::hypot(x - pin_x, y - pin_y))
        };
        let map: Vec<Vec<f64>> = (0..pins.count())
            .map(|pin| {
                (0..sensors.count())
                    .map(|sensor| response(pin, sensor))
                    .collect()
            })
            .collect();
        let mean = map.iter().map(|row| dot(row, row)).sum::<f64>() / pins.count() as f64;
        Ok(Self {
            map,
            sensors: sensors.count(),
            constant: regularisation * mean,
            pressing: vec![true; pins.count()],
            forces: vec![0.0; pins.count()],
        })
    }

    /// Finds the forces whose strains are nearest to `target`, with one value per sensor. The
    /// search starts from the last frame's solution.
    pub fn forces(&mut self, target: &[f64]) -> Result<Solution<'_>, Error> {
        assert_eq!(target.len(), self.sensors);
        if let Some(index) = target.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite {
                what: "wanted strain",
                index,
            });
        }
        let (mut fewest, mut tries, mut pivots) = (usize::MAX, 0, 0);
        let is_optimal = loop {
            let mut wrong = self.pivot(target);
            pivots += 1;
            if wrong.is_empty() || pivots == PIVOTS_MAX {
                break wrong.is_empty();
            }
            if wrong.len() < fewest {
                (fewest, tries) = (wrong.len(), TRIES + 1);
            }
            if tries > 0 {
                tries -= 1;
            } else {
                // Murty's rule, exchanging the first pin only, is certain to terminate.
                wrong.truncate(1);
            }
            for pin in wrong {
                self.pressing[pin] = !self.pressing[pin];
            }
        };
        for (force, presses) in self.forces.iter_mut().zip(&self.pressing) {
            *force = if *presses { force.max(0.0) } else { 0.0 };
        }
        Ok(Solution {
            forces: &self.forces,
            pivots,
            is_optimal,
        })
    }

    /// Strains that `forces` cause in the finger (equation 10).
    pub fn felt(&self, forces: &[f32]) -> Vec<f64> {
        let mut strains = vec![0.0; self.sensors];
        for (force, row) in forces.iter().zip(&self.map) {
            for (strain, response) in strains.iter_mut().zip(row) {
                *strain += response * f64::from(*force);
            }
        }
        strains
    }

    /// Solves for the pins that press now. Returns the pins that are in the wrong set.
    fn pivot(&mut self, target: &[f64]) -> Vec<usize> {
        let n = self.sensors;
        let mut matrix = vec![vec![0.0; n]; n];
        for (row, _) in self.map.iter().zip(&self.pressing).filter(|(_, is)| **is) {
            for i in 0..n {
                for j in 0..=i {
                    matrix[i][j] += row[i] * row[j];
                }
            }
        }
        (0..n).for_each(|i| matrix[i][i] += self.constant);
        let v = solve(matrix, target);
        for (force, row) in self.forces.iter_mut().zip(&self.map) {
            *force = dot(row, &v);
        }
        let zero = ZERO * self.forces.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        (0..self.forces.len())
            .filter(|pin| {
                if self.pressing[*pin] {
                    self.forces[*pin] < -zero
                } else {
                    self.forces[*pin] > zero
                }
            })
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves a positive definite system by Cholesky's method; only the lower triangle is used.
fn solve(mut matrix: Vec<Vec<f64>>, right: &[f64]) -> Vec<f64> {
    let n = right.len();
    let mut x = right.to_vec();
    for i in 0..n {
        let (above, below) = matrix.split_at_mut(i);
        let row = &mut below[0];
        for j in 0..i {
            row[j] = (row[j] - dot(&row[..j], &above[j][..j])) / above[j][j];
        }
        row[i] = (row[i] - dot(&row[..i], &row[..i])).sqrt();
        x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
    }
    for i in (0..n).rev() {
        x[i] /= matrix[i][i];
        for j in 0..i {
            x[j] -= matrix[i][j] * x[i];
        }
    }
    x
}
