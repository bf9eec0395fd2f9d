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

pub use hal_mock::half_plane::{Stress, normal, tangential};

/// Stress under a line load at an angle to the normal, radians (equation 4).
pub fn at_angle(x_mm: f64, z_mm: f64, angle: f64) -> Stress {
    let (sin, cos) = angle.sin_cos();
    let (pressed, dragged) = (normal(x_mm, z_mm), tangential(x_mm, z_mm));
    let sum = |pressed: f64, dragged: f64| cos * pressed + sin * dragged;
    Stress {
        x: sum(pressed.x, dragged.x),
        z: sum(pressed.z, dragged.z),
        xz: sum(pressed.xz, dragged.xz),
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
