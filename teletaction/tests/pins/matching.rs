//! Tests `Matching`: its forces satisfy the optimality (KKT) conditions, and known forces are
//! recovered.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_teletaction::pins::{Error, Grid, Layer, Matching, Quantity};
use std::f64::consts::PI;

struct Draw(ChaCha8Rng);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn even(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * f64::from(self.0.next_u32()) / 4_294_967_296.0
    }
}

const STRAIN: Layer = Layer {
    depth_mm: 1.5,
    poisson: 0.5,
    quantity: Quantity::Strain,
};

/// Strains such as an object produces: a few bumps, plus noise.
fn pressed(draw: &mut Draw, grid: &Grid) -> Vec<f64> {
    let bumps: Vec<[f64; 4]> = (0..3)
        .map(|_| {
            [
                draw.even(-4.0, 4.0),
                draw.even(-4.0, 4.0),
                draw.even(0.5, 4.0),
                draw.even(0.0, 1.0),
            ]
        })
        .collect();
    (0..grid.count())
        .map(|n| {
            let (x, y) = grid.position_mm(n);
            let bump = |[x0, y0, width, high]: &[f64; 4]| {
                let r = f64::hypot(x - x0, y - y0) / width;
                high * (-r * r).exp()
            };
            bumps.iter().map(bump).sum::<f64>() + draw.even(-0.05, 0.05)
        })
        .collect()
}

/// In unrelated frames of noise and of objects' strains, the forces must satisfy the
/// Karush-Kuhn-Tucker conditions after few pivots.
#[test]
fn forces_are_the_optimum() {
    let cases = [
        (4, 4, 4, 4, 1.5, 0.01),
        (4, 4, 10, 10, 1.0, 0.03),
        (10, 10, 10, 10, 1.0, 0.01),
        (10, 10, 10, 10, 1.0, 0.001),
        (20, 1, 12, 1, 1.0, 0.001),
    ];
    let quantities = [
        Quantity::Strain,
        Quantity::HalfSpaceStrain,
        Quantity::Stress,
    ];
    for (case, quantity) in cases.iter().flat_map(|case| quantities.map(|q| (case, q))) {
        let (columns, rows, pin_columns, pin_rows, spacing_mm, regularisation) = *case;
        let sensors = Grid::new(columns, rows, spacing_mm).expect("a grid");
        let pins = Grid::new(pin_columns, pin_rows, spacing_mm).expect("a grid");
        let layer = Layer { quantity, ..STRAIN };
        let mut matching =
            Matching::new(&sensors, &pins, &layer, regularisation).expect("a display");
        let response = |sensor: usize, pin: usize| {
            let ((x, y), (a, b)) = (sensors.position_mm(sensor), pins.position_mm(pin));
            layer.response((x - a).hypot(y - b))
        };
        let map: Vec<Vec<f64>> = (0..pins.count())
            .map(|pin| (0..sensors.count()).map(|n| response(n, pin)).collect())
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mean = map.iter().map(|row| dot(row, row)).sum::<f64>() / map.len() as f64;
        let mut draw = Draw::new(7);
        for frame in 0..110 {
            let wanted = match frame % 2 {
                0 => pressed(&mut draw, &sensors),
                _ => (0..sensors.count()).map(|_| draw.even(-1.0, 1.0)).collect(),
            };
            let solution = matching.forces(&wanted).expect("forces");
            assert!(solution.is_optimal && solution.pivots <= 12, "{solution:?}");
            let off: Vec<f64> = (0..sensors.count())
                .map(|n| {
                    let felt = map.iter().zip(solution.forces).map(|(row, x)| row[n] * x);
                    felt.sum::<f64>() - wanted[n]
                })
                .collect();
            let largest = map
                .iter()
                .map(|row| dot(row, &wanted).abs())
                .fold(0.0, f64::max);
            // x >= 0, gradient >= 0, and one of the two is 0.
            for (pin, (x, row)) in solution.forces.iter().zip(&map).enumerate() {
                let slope = dot(row, &off) + regularisation * mean * x;
                let is_flat = if *x == 0.0 {
                    slope > -1e-7 * largest
                } else {
                    slope.abs() < 1e-7 * largest
                };
                assert!(
                    *x >= 0.0 && is_flat,
                    "{frame} {pin}: {x} {slope} of {largest}"
                );
            }
        }
    }
}

/// Without noise, forces that press must be recovered (equations 9 to 11).
#[test]
fn forces_that_made_the_strain_come_back() {
    let pins = Grid::new(5, 5, 2.0).expect("a grid");
    let sensors = Grid::new(9, 9, 1.0).expect("a grid");
    let mut matching = Matching::new(&sensors, &pins, &STRAIN, 1e-7).expect("a display");
    let mut draw = Draw::new(3);
    for _ in 0..50 {
        let pressed: Vec<f32> = (0..25)
            .map(|_| draw.even(-1.0, 1.0).max(0.0) as f32)
            .collect();
        let wanted = matching.felt(&pressed);
        let solution = matching.forces(&wanted).expect("forces");
        for (found, pressed) in solution.forces.iter().zip(&pressed) {
            let off = (found - f64::from(*pressed)).abs();
            assert!(off < 1e-3, "{found} {pressed}");
        }
    }
}

/// An even touch on two long columns of pins. By the paper's equations 1 and 3, two equal line
/// loads, each above a sensor, share the strain.
#[test]
fn an_even_touch_takes_the_papers_forces() {
    let (spacing_mm, depth_mm, poisson) = (1.25, 2.0, 0.5);
    let pins = Grid::new(2, 50, spacing_mm).expect("a grid");
    // A pressure of 1 N per pin. It strains a wide slice half as much.
    let wanted = [0.5 / (spacing_mm * spacing_mm); 100];
    let middle_n = |quantity| {
        let layer = Layer {
            depth_mm,
            poisson,
            quantity,
        };
        let mut matching = Matching::new(&pins, &pins, &layer, 0.001).expect("a display");
        let solution = matching.forces(&wanted).expect("forces");
        assert!(solution.is_optimal);
        solution.forces[50]
    };
    let line = |x_mm: f64| {
        let r2 = x_mm * x_mm + depth_mm * depth_mm;
        2.0 * depth_mm * (depth_mm * depth_mm - poisson * x_mm * x_mm) / (PI * r2 * r2)
    };
    let paper_n = wanted[0] / (line(0.0) + line(spacing_mm)) * spacing_mm;
    let (slices_n, half_space_n) = (
        middle_n(Quantity::Strain),
        middle_n(Quantity::HalfSpaceStrain),
    );
    assert!(
        (slices_n / paper_n - 1.0).abs() < 0.01,
        "{slices_n} {paper_n}"
    );
    assert!(half_space_n > 1.3 * paper_n, "{half_space_n} {paper_n}");
}

#[test]
fn impossible_settings_and_strains_are_refused() {
    let grid = Grid::new(3, 1, 1.0).expect("a grid");
    let many = Grid::new(101, 1, 1.0).expect("a grid");
    let (depth_mm, poisson) = (0.0, 0.51);
    let (shallow, soft) = (Layer { depth_mm, ..STRAIN }, Layer { poisson, ..STRAIN });
    for (pins, layer, regularisation, name) in [
        (&many, STRAIN, 0.1, "pins"),
        (&grid, STRAIN, -0.1, "regularisation"),
        (&grid, STRAIN, 0.0, "regularisation"),
        (&grid, STRAIN, 11.0, "regularisation"),
        (&grid, STRAIN, f64::NAN, "regularisation"),
        (&grid, shallow, 0.1, "depth_mm"),
        (&grid, soft, 0.1, "poisson"),
    ] {
        let refused = Matching::new(&grid, pins, &layer, regularisation);
        assert!(matches!(refused, Err(Error::Setting(error)) if error.name == name));
    }
    let spacings = [(0, 1.0), (1001, 1.0), (1, f64::NAN), (1, 0.0)];
    for (count, spacing_mm) in spacings {
        assert!(
            Grid::new(count, 1, spacing_mm).is_err() && Grid::new(1, count, spacing_mm).is_err()
        );
    }
    let mut matching = Matching::new(&grid, &grid, &STRAIN, 0.1).expect("a display");
    let wanted = [0.1, 0.2, 0.1];
    let before = matching.forces(&wanted).expect("forces").forces.to_vec();
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(
            matching.forces(&[0.1, bad, 0.1]),
            Err(Error::NotFinite {
                what: "wanted strain",
                index: 1
            })
        );
    }
    assert_eq!(matching.forces(&wanted).expect("forces").forces, before);
}
