//! Stress in an elastic half plane under line loads on its surface: plane stress, Flamant's
//! solution. Compression is positive.
//!
//! Equations 1 and 2 of Moy et al., *Human Psychophysics for Teletaction System Design*, after
//! Johnson, *Contact Mechanics*, chapter 2. Stresses are per newton per millimetre of the line.
//! Depths are in millimetres, and above 0.

use core::f64::consts::PI;

/// Stresses at a point, or their amplitudes at a spatial frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stress {
    /// Along the surface.
    pub x: f64,
    /// Along the surface's normal.
    pub z: f64,
    /// Shear.
    pub xz: f64,
}

impl Stress {
    /// Normal strain along z times Young's modulus, by Hooke's law with no stress across the plane
    /// (equation 3).
    pub fn strain(self, poisson: f64) -> f64 {
        self.z - poisson * self.x
    }
}

/// Stress under a normal line load, at `x_mm` along the surface from the load and `z_mm` deep
/// (equation 1).
pub fn normal(x_mm: f64, z_mm: f64) -> Stress {
    let (x, z) = (x_mm, z_mm);
    stress(x, z, [z * x * x, z * z * z, z * z * x])
}

/// Stress under a tangential line load towards +x (equation 2).
pub fn tangential(x_mm: f64, z_mm: f64) -> Stress {
    let (x, z) = (x_mm, z_mm);
    stress(x, z, [x * x * x, x * z * z, z * x * x])
}

/// Divides scaled stresses by pi r^4 / 2.
fn stress(x: f64, z: f64, scaled: [f64; 3]) -> Stress {
    let r2 = x * x + z * z;
    let [x, z, xz] = scaled.map(|value| 2.0 / (PI * r2 * r2) * value);
    Stress { x, z, xz }
}
