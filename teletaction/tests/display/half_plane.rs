//! Closed forms, transfer functions and the half space, against integrals and against each other.

use ridgetone_teletaction::display::half_plane::{
    Stress, at_angle, normal, normal_wave, strain_without_shear, tangential, tangential_wave,
};
use ridgetone_teletaction::display::{Grid, Quantity, half_space};
use std::f64::consts::{PI, TAU};

/// Flamant's solution in polar coordinates: the only stress is the radial one.
fn polar(x: f64, z: f64, angle: f64) -> Stress {
    let (r, phi) = (x.hypot(z), x.atan2(z));
    let radial = 2.0 * (phi - angle).cos() / (PI * r);
    Stress {
        x: radial * phi.sin().powi(2),
        z: radial * phi.cos().powi(2),
        xz: radial * phi.sin() * phi.cos(),
    }
}

fn near(a: f64, b: f64, most: f64) -> bool {
    (a - b).abs() <= most
}

#[test]
fn line_loads_are_flamants() {
    for x in [-3.0, -0.4, 0.0, 0.7, 5.0] {
        for z in [0.3, 1.5, 4.0] {
            for degrees in [0.0f64, 30.0, 90.0] {
                let (got, wanted) = (
                    at_angle(x, z, degrees.to_radians()),
                    polar(x, z, degrees.to_radians()),
                );
                for (got, wanted) in [(got.x, wanted.x), (got.z, wanted.z), (got.xz, wanted.xz)] {
                    assert!(
                        near(got, wanted, 1e-12),
                        "{x} {z} {degrees}: {got} {wanted}"
                    );
                }
            }
        }
    }
}

/// The transfer function of a response is its integral times a cosine or a sine.
#[test]
fn waves_are_the_transforms_of_lines() {
    for (period_mm, z) in [(2.6, 0.7), (4.0, 2.0), (12.0, 1.3)] {
        let k = TAU / period_mm;
        let transform = |f: &dyn Fn(f64) -> f64, wave: &dyn Fn(f64) -> f64| -> f64 {
            (-200_000..200_000)
                .map(|i| f64::from(i) * 0.01 + 0.005)
                .map(|x| f(x) * wave(k * x) * 0.01)
                .sum()
        };
        let (pressed, dragged) = (normal_wave(k, z), tangential_wave(k, z));
        let cases = [
            (transform(&|x| normal(x, z).z, &f64::cos), pressed.z),
            (transform(&|x| normal(x, z).x, &f64::cos), pressed.x),
            (transform(&|x| normal(x, z).xz, &f64::sin), pressed.xz),
            (transform(&|x| tangential(x, z).z, &f64::sin), dragged.z),
            (transform(&|x| tangential(x, z).x, &f64::sin), dragged.x),
            (transform(&|x| tangential(x, z).xz, &f64::cos), dragged.xz),
            (
                transform(&|x| normal(x, z).strain(0.5), &f64::cos),
                (0.5 + 1.5 * k * z) * (-k * z).exp(),
            ),
        ];
        for (case, (got, wanted)) in cases.into_iter().enumerate() {
            assert!(
                near(got, wanted, 1e-3),
                "{period_mm} {case}: {got} {wanted}"
            );
        }
    }
}

/// Where the shear stress crosses too, two layers are one.
#[test]
fn two_layers_with_shear_are_one() {
    for k in [0.05, 0.4, 1.6, 6.0] {
        let at_interface = normal_wave(k, 1.0);
        let from_normal = normal_wave(k, 1.7).strain(0.5) * at_interface.z;
        // The shear goes as sin(k x); a tangential load sin(k x) makes -cos(k x) of its own sine.
        let from_shear = -tangential_wave(k, 1.7).strain(0.5) * at_interface.xz;
        let whole = normal_wave(k, 2.7).strain(0.5);
        assert!(
            near(from_normal + from_shear, whole, 1e-12),
            "{k}: {from_normal} {from_shear} {whole}"
        );
        assert!(near(
            strain_without_shear(k, 1.0, 1.7, 0.5),
            from_normal,
            1e-15
        ));
    }
}

#[test]
fn a_half_space_carries_the_whole_force() {
    for z in [0.5, 2.0] {
        let over_plane = |f: &dyn Fn(f32) -> f32| -> f64 {
            (0..400_000)
                .map(|i| (f64::from(i) + 0.5) * 0.01)
                .map(|r| f64::from(f(r as f32)) * TAU * r * 0.01)
                .sum()
        };
        assert!(near(over_plane(&|r| half_space::stress(r, z)), 1.0, 1e-3));
        for poisson in [0.0, 0.3, 0.5] {
            let sum = over_plane(&|r| half_space::strain(r, z, poisson));
            let poisson = f64::from(poisson);
            assert!(
                near(sum, 1.0 - poisson - 2.0 * poisson * poisson, 2e-3),
                "{poisson}: {sum}"
            );
        }
    }
}

/// Plane stress and plane strain by Hooke's law, from the stresses of one line load (equation 1):
/// along a long column of points the slices' strain is the one and the half space's the other.
#[test]
fn slices_and_half_space_are_told_apart() {
    let spacing_mm = 0.25;
    let column = Grid::new(1, 1000, spacing_mm).expect("a grid");
    for (x_mm, z_mm) in [(0.0, 1.0), (1.5, 2.0), (4.0, 1.0)] {
        // The two places of this grid are `x_mm` from the column.
        let places = Grid::new(2, 1, 2.0 * f64::max(x_mm, 0.01)).expect("a grid");
        for poisson in [0.0, 0.3, 0.5] {
            let all = |quantity| -> f64 {
                let map = places.map(&column, z_mm, poisson, quantity).expect("a map");
                (0..1000).map(|pin| f64::from(map(0, pin))).sum::<f64>() * spacing_mm
            };
            let line = normal(x_mm, z_mm);
            let across = poisson * (line.x + line.z);
            for (quantity, expected) in [
                (Quantity::Strain, line.z - poisson * line.x),
                (
                    Quantity::HalfSpaceStrain,
                    line.z - poisson * (line.x + across),
                ),
                (Quantity::Stress, line.z),
            ] {
                let found = all(quantity);
                assert!(
                    near(found, expected, 1e-3),
                    "{x_mm} {z_mm} {poisson} {quantity:?}: {found} {expected}"
                );
            }
        }
    }
}

/// Under an even pressure a slice has the same stress along x and z. A half space has twice Poisson's
/// ratio of it along y too, for nothing can give way there.
#[test]
fn an_even_pressure_strains_slices_and_hardly_a_half_space() {
    let pins = Grid::new(1000, 1000, 1.0).expect("a grid");
    let place = Grid::new(1, 1, 1.0).expect("a grid");
    for poisson in [0.0, 0.3, 0.5] {
        let all = |quantity| -> f64 {
            let map = place.map(&pins, 2.0, poisson, quantity).expect("a map");
            (0..pins.count()).map(|pin| f64::from(map(0, pin))).sum()
        };
        let (slices, half_space) = (all(Quantity::Strain), all(Quantity::HalfSpaceStrain));
        assert!(near(slices, 1.0 - poisson, 1e-2), "{poisson}: {slices}");
        assert!(
            near(half_space, 1.0 - poisson - 2.0 * poisson * poisson, 1e-2),
            "{poisson}: {half_space}"
        );
    }
}

/// A row of points is a line: without Poisson's ratio the strain is the stress along z, which is
/// the same in a slice.
#[test]
fn a_line_of_points_is_a_line_load() {
    for (x, z) in [(0.0, 1.0), (1.5, 2.0)] {
        let sum: f64 = (-200_000..200_000)
            .map(|i| f64::from(i) * 0.01)
            .map(|y: f64| {
                f64::from(half_space::strain(f64::hypot(x, y) as f32, z as f32, 0.0)) * 0.01
            })
            .sum();
        assert!(near(sum, normal(x, z).z, 1e-3), "{sum}");
    }
}
