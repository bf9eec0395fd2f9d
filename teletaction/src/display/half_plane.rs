//! Stress and strain in an elastic half plane under loads on its surface: a thin slice (plane
//! stress). Compression is positive.
//!
//! Equations 1 to 4 of Moy et al., *Human Psychophysics for Teletaction System Design*, after
//! Johnson, *Contact Mechanics*, chapter 2, in space and as transfer functions over the wave number
//! `k`, radians per millimetre. Stresses and strains are times Young's modulus and per newton per
//! millimetre of the line. Depths are in millimetres, and above 0.
//!
//! The transfer functions are those of equations 1 and 2: a pressure cos(k x) makes (1 + k z)
//! exp(-k z) cos(k x) at depth z. Tests integrate the one to get the other.

use std::f64::consts::PI;

/// Stresses at a point, or their amplitudes at a wave number.
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
    /// Normal strain along z times Young's modulus (equation 3), with Poisson's ratio.
    pub fn strain(self, poisson: f64) -> f64 {
        self.z - poisson * self.x
    }

    /// Sum of two, with weights.
    pub fn mix(self, weight: f64, other: Self, other_weight: f64) -> Self {
        let sum = |a: f64, b: f64| weight * a + other_weight * b;
        Self {
            x: sum(self.x, other.x),
            z: sum(self.z, other.z),
            xz: sum(self.xz, other.xz),
        }
    }
}

/// Under a line load along the normal, `x_mm` beside it and `z_mm` deep (equation 1).
pub fn normal(x_mm: f64, z_mm: f64) -> Stress {
    let (x, z) = (x_mm, z_mm);
    stress(x, z, z * x * x, z * z * z, z * z * x)
}

/// Under a tangential line load towards +x (equation 2).
pub fn tangential(x_mm: f64, z_mm: f64) -> Stress {
    let (x, z) = (x_mm, z_mm);
    stress(x, z, x * x * x, x * z * z, z * x * x)
}

/// Under a line load at an angle to the normal, radians (equation 4).
pub fn at_angle(x_mm: f64, z_mm: f64, angle: f64) -> Stress {
    normal(x_mm, z_mm).mix(angle.cos(), tangential(x_mm, z_mm), angle.sin())
}

fn stress(x: f64, z: f64, along_x: f64, along_z: f64, shear: f64) -> Stress {
    let r2 = x * x + z * z;
    let scale = 2.0 / (PI * r2 * r2);
    Stress {
        x: scale * along_x,
        z: scale * along_z,
        xz: scale * shear,
    }
}

/// Amplitudes under a normal pressure cos(k x): x and z go as cos(k x), xz as sin(k x).
pub fn normal_wave(k: f64, z_mm: f64) -> Stress {
    let kz = k.abs() * z_mm;
    let fade = (-kz).exp();
    Stress {
        x: (1.0 - kz) * fade,
        z: (1.0 + kz) * fade,
        xz: k.signum() * kz * fade,
    }
}

/// Amplitudes under a tangential load cos(k x): x and z go as sin(k x), xz as cos(k x).
pub fn tangential_wave(k: f64, z_mm: f64) -> Stress {
    let (kz, sign) = (k.abs() * z_mm, k.signum());
    let fade = (-kz).exp();
    Stress {
        x: sign * (2.0 - kz) * fade,
        z: sign * kz * fade,
        xz: (1.0 - kz) * fade,
    }
}

/// Amplitude of the strain in the finger under a normal pressure cos(k x), if only the normal
/// stress crosses the layers' interface (block diagram b of figure 11): through `first_mm` to the
/// interface, its shear stress set to zero there, then `second_mm`.
pub fn strain_without_shear(k: f64, first_mm: f64, second_mm: f64, poisson: f64) -> f64 {
    normal_wave(k, first_mm).z * normal_wave(k, second_mm).strain(poisson)
}
