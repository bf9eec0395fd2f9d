//! Matching against a reference that shares no code with it, and against the conditions of an
//! optimum.

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

struct Reference {
    gram: Vec<Vec<f64>>,
    b: Vec<f64>,
}

impl Reference {
    fn new(
        sensors: &Grid,
        pins: &Grid,
        layer: &Layer,
        regularisation: f64,
        wanted: &[f64],
    ) -> Self {
        let response = |sensor: usize, pin: usize| {
            let ((x, y), (a, b)) = (sensors.position_mm(sensor), pins.position_mm(pin));
            layer.response((x - a).hypot(y - b))
        };
        let column = |pin: usize| (0..wanted.len()).map(move |sensor| response(sensor, pin));
        let dot = |a: usize, b: usize| column(a).zip(column(b)).map(|(a, b)| a * b).sum::<f64>();
        let count = pins.count();
        let mean = (0..count).map(|pin| dot(pin, pin)).sum::<f64>() / count as f64;
        let element =
            |i: usize, j: usize| dot(i, j) + if i == j { regularisation * mean } else { 0.0 };
        Self {
            gram: (0..count)
                .map(|i| (0..count).map(|j| element(i, j)).collect())
                .collect(),
            b: (0..count)
                .map(|pin| column(pin).zip(wanted).map(|(a, w)| a * w).sum())
                .collect(),
        }
    }

    fn gradient(&self, x: &[f64]) -> Vec<f64> {
        self.gram
            .iter()
            .zip(&self.b)
            .map(|(row, b)| row.iter().zip(x).map(|(g, x)| g * x).sum::<f64>() - b)
            .collect()
    }

    /// By cyclic coordinate descent, until nothing moves.
    fn solve(&self) -> Vec<f64> {
        let mut x = vec![0.0f64; self.b.len()];
        for _ in 0..200_000 {
            let mut moved = 0.0f64;
            for i in 0..x.len() {
                let slope: f64 =
                    self.gram[i].iter().zip(&x).map(|(g, x)| g * x).sum::<f64>() - self.b[i];
                let new = (x[i] - slope / self.gram[i][i]).max(0.0);
                moved = moved.max((new - x[i]).abs());
                x[i] = new;
            }
            if moved < 1e-13 {
                break;
            }
        }
        x
    }
}

/// Strains as an object makes them: a few pressed positions, and noise.
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

#[test]
fn forces_are_the_optimum() {
    let cases = [
        (4, 4, 4, 4, 1.5, 0.01),
        (4, 4, 10, 10, 1.0, 0.03),
        (10, 10, 10, 10, 1.0, 0.01),
        (20, 1, 12, 1, 1.0, 0.001),
    ];
    for (columns, rows, pin_columns, pin_rows, spacing_mm, regularisation) in cases {
        for quantity in [
            Quantity::Strain,
            Quantity::HalfSpaceStrain,
            Quantity::Stress,
        ] {
            let sensors = Grid::new(columns, rows, spacing_mm).expect("a grid");
            let pins = Grid::new(pin_columns, pin_rows, spacing_mm).expect("a grid");
            let layer = Layer { quantity, ..STRAIN };
            let mut matching =
                Matching::new(&sensors, &pins, &layer, regularisation).expect("a display");
            let mut draw = Draw::new(7);
            for frame in 0..4 {
                let wanted = pressed(&mut draw, &sensors);
                let solution = matching.forces(&wanted).expect("forces");
                assert!(solution.is_optimal && solution.pivots <= 12, "{solution:?}");
                let x = solution.forces.to_vec();
                let reference = Reference::new(&sensors, &pins, &layer, regularisation, &wanted);
                // The conditions of Karush, Kuhn and Tucker: x >= 0, gradient >= 0, and one of them
                // is 0.
                let largest =
                    |values: &[f64]| values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
                let (max_x, max_b) = (largest(&x), largest(&reference.b));
                for (pin, (x, y)) in x.iter().zip(reference.gradient(&x)).enumerate() {
                    assert!(*x >= 0.0 && y > -1e-7 * max_b, "{frame} {pin}: {x} {y}");
                    assert!(
                        *x == 0.0 || y.abs() < 1e-7 * max_b,
                        "{frame} {pin}: {x} {y} of {max_b}"
                    );
                }
                // The optimum itself is unique.
                for (pin, (x, wanted)) in x.iter().zip(reference.solve()).enumerate() {
                    assert!(
                        (x - wanted).abs() < 1e-5 * max_x,
                        "{frame} {pin}: {x} {wanted} of {max_x}"
                    );
                }
            }
        }
    }
}

/// Without noise, and with forces that press, the forces come back (equations 9 to 11).
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
            assert!(
                (found - f64::from(*pressed)).abs() < 1e-3,
                "{found} {pressed}"
            );
        }
    }
}

/// An even touch on two long columns of pins. By the paper's equations 1 and 3 two line loads that
/// are alike, each under its own sensor, share the strain.
#[test]
fn an_even_touch_takes_the_papers_forces() {
    let (spacing_mm, depth_mm, poisson) = (1.25, 2.0, 0.5);
    let pins = Grid::new(2, 50, spacing_mm).expect("a grid");
    // A pressure of 1 N a pin, which strains a wide slice as by half of it.
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
    let refused = |pins: &Grid, layer: Layer, regularisation| match Matching::new(
        &grid,
        pins,
        &layer,
        regularisation,
    )
    .err()
    {
        Some(Error::Setting(error)) => error.name,
        other => panic!("{other:?}"),
    };
    let many = Grid::new(101, 1, 1.0).expect("a grid");
    assert_eq!(refused(&many, STRAIN, 0.1), "pins");
    for regularisation in [-0.1, 0.0, 11.0, f64::NAN] {
        assert_eq!(refused(&grid, STRAIN, regularisation), "regularisation");
    }
    let (depth_mm, poisson) = (0.0, 0.51);
    assert_eq!(
        refused(&grid, Layer { depth_mm, ..STRAIN }, 0.1),
        "depth_mm"
    );
    assert_eq!(refused(&grid, Layer { poisson, ..STRAIN }, 0.1), "poisson");
    for (columns, rows, spacing_mm) in [
        (0, 1, 1.0),
        (1, 0, 1.0),
        (1001, 1, 1.0),
        (1, 1, f64::NAN),
        (1, 1, 0.0),
    ] {
        assert!(matches!(
            Grid::new(columns, rows, spacing_mm),
            Err(Error::Setting(_))
        ));
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

/// Noise, and strains of objects, in frames that have nothing to do with the frames before.
#[test]
fn pivots_are_few_whatever_is_wanted() {
    for quantity in [Quantity::Strain, Quantity::HalfSpaceStrain] {
        let mut most = 0;
        for (side, pin_side, regularisation) in
            [(4, 4, 0.01), (4, 10, 0.01), (10, 10, 0.01), (10, 10, 0.001)]
        {
            let sensors = Grid::new(side, side, 9.0 / (side - 1) as f64).expect("a grid");
            let pins = Grid::new(pin_side, pin_side, 1.0).expect("a grid");
            let layer = Layer { quantity, ..STRAIN };
            let mut matching =
                Matching::new(&sensors, &pins, &layer, regularisation).expect("a display");
            let mut draw = Draw::new(11);
            for frame in 0..200 {
                let wanted = match frame % 2 {
                    0 => pressed(&mut draw, &sensors),
                    _ => (0..sensors.count()).map(|_| draw.even(-1.0, 1.0)).collect(),
                };
                let solution = matching.forces(&wanted).expect("forces");
                assert!(
                    solution.is_optimal,
                    "{side} {pin_side} {frame}: {solution:?}"
                );
                most = most.max(solution.pivots);
            }
        }
        println!("{quantity:?}: {most} pivots");
        assert!(most <= 12, "{quantity:?}: {most}");
    }
}
