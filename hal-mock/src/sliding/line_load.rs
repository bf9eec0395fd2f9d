//! Strain in an elastic half plane under a line load on its surface: plane stress, Flamant's
//! solution.
//!
//! Stresses and Hooke's law with none across the plane: Moy et al., *Human Psychophysics for
//! Teletaction System Design*, equations 1 to 4, after Johnson, *Contact Mechanics*, chapter 2.

/// An elastic material.
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

/// Stresses under a line load, each times -pi r^4 / 2.
struct Stress {
    along_x: f64,
    along_z: f64,
    shear: f64,
}

impl Material {
    /// Strain at `x_mm` beside and `depth_mm` under a load of 1 N per mm of its line that presses
    /// on the surface.
    pub(crate) fn pressed(self, x_mm: f64, depth_mm: f64) -> Strain {
        let (x, z) = (x_mm, depth_mm);
        let stress = Stress {
            along_x: z * x * x,
            along_z: z * z * z,
            shear: x * z * z,
        };
        self.strain(x * x + z * z, stress)
    }

    /// Strain under a load of 1 N per mm that drags the surface along +x.
    pub(crate) fn dragged(self, x_mm: f64, depth_mm: f64) -> Strain {
        let (x, z) = (x_mm, depth_mm);
        let stress = Stress {
            along_x: x * x * x,
            along_z: x * z * z,
            shear: x * x * z,
        };
        self.strain(x * x + z * z, stress)
    }

    /// Hooke's law at the squared distance `r2` from the load.
    fn strain(self, r2: f64, stress: Stress) -> Strain {
        let scale = 2.0 / (core::f64::consts::PI * r2 * r2 * self.modulus_mpa);
        Strain {
            normal: scale * (stress.along_z - self.poisson * stress.along_x),
            shear: scale * 2.0 * (1.0 + self.poisson) * stress.shear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU};

    const SOFT: Material = Material {
        modulus_mpa: 1.7,
        poisson: 0.5,
    };

    /// Flamant in polar coordinates: the only stress is the radial one, -2 (Fz cos + Fx sin) / (pi
    /// r).
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
                for (got, wanted) in [
                    (SOFT.pressed(x, z), polar(x, z, 1.0, 0.0)),
                    (SOFT.dragged(x, z), polar(x, z, 0.0, 1.0)),
                ] {
                    assert!(
                        (got.normal - wanted.normal).abs() < 1e-12,
                        "{x} {z} {got:?} {wanted:?}"
                    );
                    assert!(
                        (got.shear - wanted.shear).abs() < 1e-12,
                        "{x} {z} {got:?} {wanted:?}"
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

    #[test]
    fn a_wave_of_pressure_fades_with_depth_as_the_closed_form_says() {
        // Pressure cos(k x): the stresses are (1 + k z) exp(-k z) along z, (1 - k z) exp(-k z)
        // along x, and k z exp(-k z) of shear, a quarter of a turn away; under a drag k z, 2 - k z
        // and 1 - k z.
        for period in [2.6, 3.6, 4.1, 20.0] {
            let (k, z) = (TAU / period, 1.3);
            let kz = k * z;
            let wave = |f: &dyn Fn(f64) -> f64, quarter: f64| {
                (-200_000..200_000)
                    .map(|i| f64::from(i) * 0.01 + 0.005)
                    .map(|x| f(x) * (k * x - quarter).cos() * 0.01)
                    .sum::<f64>()
            };
            let fade = (-kz).exp() / 1.7;
            let cases = [
                (
                    wave(&|x| SOFT.pressed(x, z).normal, 0.0),
                    ((1.0 + kz) - 0.5 * (1.0 - kz)) * fade,
                ),
                (
                    wave(&|x| SOFT.pressed(x, z).shear, PI / 2.0),
                    3.0 * kz * fade,
                ),
                (
                    wave(&|x| SOFT.dragged(x, z).normal, PI / 2.0),
                    (kz - 0.5 * (2.0 - kz)) * fade,
                ),
                (
                    wave(&|x| SOFT.dragged(x, z).shear, 0.0),
                    3.0 * (1.0 - kz) * fade,
                ),
            ];
            for (case, (got, wanted)) in cases.into_iter().enumerate() {
                assert!(
                    (got - wanted).abs() < 1e-3,
                    "period {period}, case {case}: {got} instead of {wanted}"
                );
            }
        }
    }
}
