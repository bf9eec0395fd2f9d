//! Strain in an elastic half plane under a line load on its surface: the stresses of
//! [`half_plane`], and Hooke's law with no stress across the plane (Moy et al., *Human
//! Psychophysics for Teletaction System Design*, equations 3 and 4).

use crate::half_plane::{self, Stress};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Material {
    /// Young's modulus in MPa = N/mm^2.
    pub(crate) modulus_mpa: f64,
    /// Poisson's ratio.
    pub(crate) poisson: f64,
}

/// Strain at a point, without unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Strain {
    /// Along the surface's normal; positive where compressed.
    pub(crate) normal: f64,
    /// Shear of the layers parallel to the surface; positive where the surface is dragged along +x.
    pub(crate) shear: f64,
}

impl Material {
    /// Strain at `x_mm` from a line load of 1 N per mm that presses on the surface, at `depth_mm`.
    pub(crate) fn pressed(self, x_mm: f64, depth_mm: f64) -> Strain {
        self.strain(half_plane::normal(x_mm, depth_mm))
    }

    /// Strain under a load of 1 N per mm that drags the surface along +x.
    pub(crate) fn dragged(self, x_mm: f64, depth_mm: f64) -> Strain {
        self.strain(half_plane::tangential(x_mm, depth_mm))
    }

    fn strain(self, stress: Stress) -> Strain {
        Strain {
            normal: stress.strain(self.poisson) / self.modulus_mpa,
            shear: 2.0 * (1.0 + self.poisson) * stress.xz / self.modulus_mpa,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    const SOFT: Material = Material {
        modulus_mpa: 1.7,
        poisson: 0.5,
    };

    /// Flamant's solution in polar coordinates: the only stress is radial, -2 (Fz cos + Fx sin) /
    /// (pi r).
    fn polar(x: f64, z: f64, press: f64, drag: f64) -> Strain {
        let (r, angle) = (x.hypot(z), x.atan2(z));
        let radial = 2.0 * (press * angle.cos() + drag * angle.sin()) / (PI * r);
        let (along_z, along_x) = (radial * angle.cos().powi(2), radial * angle.sin().powi(2));
        Strain {
            normal: (along_z - 0.5 * along_x) / 1.7,
            shear: radial * angle.sin() * angle.cos() * 2.0 * 1.5 / 1.7,
        }
    }

    #[test]
    fn line_loads_are_flamants() {
        for x in [-3.0, -1.0, -0.2, 0.0, 0.4, 2.0] {
            for z in [0.2, 1.3, 4.0] {
                for (got, expected) in [
                    (SOFT.pressed(x, z), polar(x, z, 1.0, 0.0)),
                    (SOFT.dragged(x, z), polar(x, z, 0.0, 1.0)),
                ] {
                    assert!(
                        (got.normal - expected.normal).abs() < 1e-12,
                        "{x} {z} {got:?} {expected:?}"
                    );
                    assert!(
                        (got.shear - expected.shear).abs() < 1e-12,
                        "{x} {z} {got:?} {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_layer_carries_the_whole_load() {
        // Over a wide layer the shear stress integrates to the drag and the stress along z to the
        // pressure. For an incompressible material (nu = 0.5) the shear strain integrates to
        // 2 (1 + nu) / E times the drag. The normal strain integrates to (1 - nu) / E times the
        // pressure, since the stress along x has the same integral as the stress along z.
        let sum = |f: &dyn Fn(f64) -> f64| {
            (-400_000..400_000)
                .map(|i| f(f64::from(i) * 0.01 + 0.005) * 0.01)
                .sum::<f64>()
        };
        let shear = sum(&|x| SOFT.dragged(x, 1.3).shear) * 1.7 / 3.0;
        assert!((shear - 1.0).abs() < 1e-3, "{shear}");
        let normal = sum(&|x| SOFT.pressed(x, 1.3).normal) * 1.7 / 0.5;
        assert!((normal - 1.0).abs() < 1e-2, "{normal}");
    }
}
