//! Matching against a reference in f64 that shares no code with it, and against the conditions of
//! an optimum.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_teletaction::display::{Error, Grid, Matching, Quantity};
use std::f64::consts::PI;

struct Draw(ChaCha8Rng);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn even(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * (self.0.next_u32() >> 8) as f32 / 16_777_216.0
    }
}

struct Reference {
    gram: Vec<Vec<f64>>,
    b: Vec<f64>,
}

impl Reference {
    fn new(
        map: &dyn Fn(usize, usize) -> f32,
        pins: usize,
        regularisation: f64,
        wanted: &[f32],
    ) -> Self {
        let column = |pin: usize| (0..wanted.len()).map(move |sensor| f64::from(map(sensor, pin)));
        let dot = |a: usize, b: usize| column(a).zip(column(b)).map(|(a, b)| a * b).sum::<f64>();
        let mean = (0..pins).map(|pin| dot(pin, pin)).sum::<f64>() / pins as f64;
        let gram = (0..pins).map(|i| {
            (0..pins)
                .map(|j| dot(i, j) + if i == j { regularisation * mean } else { 0.0 })
                .collect()
        });
        let b = (0..pins).map(|pin| {
            column(pin)
                .zip(wanted)
                .map(|(a, w)| a * f64::from(*w))
                .sum()
        });
        Self {
            gram: gram.collect(),
            b: b.collect(),
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

/// An image of strains as an object makes it: a few pressed places, and noise.
fn image(draw: &mut Draw, grid: &Grid) -> Vec<f32> {
    let bumps: Vec<[f32; 4]> = (0..3)
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
            let (x, y) = grid.place_mm(n);
            let bump = |[x0, y0, width, high]: &[f32; 4]| {
                let r = f32::hypot(x as f32 - x0, y as f32 - y0) / width;
                high * (-r * r).exp()
            };
            bumps.iter().map(bump).sum::<f32>() + draw.even(-0.05, 0.05)
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
            let map = sensors.map(&pins, 1.5, 0.5, quantity).expect("a map");
            let mut memory = vec![f32::NAN; Matching::floats(pins.count(), sensors.count())];
            let mut matching = Matching::new(
                &mut memory,
                pins.count(),
                sensors.count(),
                regularisation,
                &map,
            )
            .expect("a display");
            let mut draw = Draw::new(7);
            for frame in 0..12 {
                let wanted = image(&mut draw, &sensors);
                let solution = matching.forces(&wanted).expect("forces");
                assert!(solution.is_optimal && solution.pivots <= 12, "{solution:?}");
                let x: Vec<f64> = solution.forces.iter().map(|x| f64::from(*x)).collect();
                let reference =
                    Reference::new(&map, pins.count(), f64::from(regularisation), &wanted);
                // The conditions of Karush, Kuhn and Tucker, in f64: x >= 0, gradient >= 0, and one
                // of them is 0.
                let largest =
                    |values: &[f64]| values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
                let (most_x, most_b) = (largest(&x), largest(&reference.b));
                for (pin, (x, y)) in x.iter().zip(reference.gradient(&x)).enumerate() {
                    assert!(*x >= 0.0 && y > -1e-3 * most_b, "{frame} {pin}: {x} {y}");
                    assert!(
                        *x == 0.0 || y.abs() < 1e-3 * most_b,
                        "{frame} {pin}: {x} {y} of {most_b}"
                    );
                }
                // The optimum itself is unique.
                for (pin, (x, wanted)) in x.iter().zip(reference.solve()).enumerate() {
                    assert!(
                        (x - wanted).abs() < 2e-3 * most_x,
                        "{frame} {pin}: {x} {wanted} of {most_x}"
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
    let mut memory = vec![0.0; Matching::floats(25, 81)];
    let map = sensors
        .map(&pins, 1.5, 0.5, Quantity::Strain)
        .expect("a map");
    let mut matching = Matching::new(&mut memory, 25, 81, 0.0, map).expect("a display");
    let mut draw = Draw::new(3);
    for _ in 0..50 {
        let pressed: Vec<f32> = (0..25).map(|_| draw.even(-1.0, 1.0).max(0.0)).collect();
        let mut wanted = vec![0.0; 81];
        matching.felt(&pressed, &mut wanted).expect("strains");
        let solution = matching.forces(&wanted).expect("forces");
        for (found, pressed) in solution.forces.iter().zip(&pressed) {
            assert!((found - pressed).abs() < 1e-3, "{found} {pressed}");
        }
    }
}

/// Multiplications in a tenth of a frame of 20 ms on a Cortex-M4 at 168 MHz: about three
/// instructions for one with an addition.
const TENTH_OF_FRAME: u32 = 112_000;

/// Few sensors under many pins: in slices each pin reaches more of them than in a half space, and more
/// pins begin or cease to press from frame to frame.
#[test]
fn a_frame_takes_few_multiplications() {
    for (quantity, pins, sensors, most) in [
        (Quantity::HalfSpaceStrain, (4, 4), (4, 4), 1_000),
        (Quantity::HalfSpaceStrain, (10, 10), (4, 4), 20_000),
        (Quantity::HalfSpaceStrain, (10, 10), (10, 10), 100_000),
        (Quantity::Strain, (4, 4), (4, 4), 1_000),
        (Quantity::Strain, (10, 10), (4, 4), TENTH_OF_FRAME),
        (Quantity::Strain, (10, 10), (10, 10), 100_000),
    ] {
        let pins = Grid::new(pins.0, pins.1, 1.0).expect("a grid");
        let sensors =
            Grid::new(sensors.0, sensors.1, 9.0 / (sensors.0 - 1) as f64).expect("a grid");
        let mut memory = vec![0.0; Matching::floats(pins.count(), sensors.count())];
        let map = sensors.map(&pins, 1.5, 0.5, quantity).expect("a map");
        let mut matching = Matching::new(&mut memory, pins.count(), sensors.count(), 0.01, map)
            .expect("a display");
        // A bump moves over the sensors at 0.2 mm a frame.
        let mut greatest = 0;
        for frame in 0..80 {
            let x0 = -8.0 + 0.2 * f64::from(frame);
            let wanted: Vec<f32> = (0..sensors.count())
                .map(|n| {
                    let (x, y) = sensors.place_mm(n);
                    (-((x - x0).powi(2) + y * y) / 4.0).exp() as f32
                })
                .collect();
            let solution = matching.forces(&wanted).expect("forces");
            assert!(solution.is_optimal);
            greatest = greatest.max(solution.multiply_adds);
        }
        println!(
            "{quantity:?}, {} pins, {} sensors: at most {greatest}",
            pins.count(),
            sensors.count()
        );
        assert!(
            greatest < most,
            "{} pins, {} sensors: {greatest}",
            pins.count(),
            sensors.count()
        );
    }
}

/// An even touch on two long columns of pins. By the paper's equations 1 and 3 two line loads that
/// are alike, each under its own sensor, share the strain.
#[test]
fn an_even_touch_takes_the_papers_forces() {
    let (spacing_mm, depth_mm, poisson) = (1.25, 2.0, 0.5);
    let pins = Grid::new(2, 50, spacing_mm).expect("a grid");
    // A pressure of 1 N a pin, which strains a wide slice as by half of it.
    let wanted = [(0.5 / (spacing_mm * spacing_mm)) as f32; 100];
    let middle_n = |quantity| {
        let map = pins.map(&pins, depth_mm, poisson, quantity).expect("a map");
        let mut memory = vec![0.0; Matching::floats(100, 100)];
        let mut matching = Matching::new(&mut memory, 100, 100, 0.001, map).expect("a display");
        let solution = matching.forces(&wanted).expect("forces");
        assert!(solution.is_optimal);
        f64::from(solution.forces[50])
    };
    let line = |x_mm: f64| {
        let r2 = x_mm * x_mm + depth_mm * depth_mm;
        2.0 * depth_mm * (depth_mm * depth_mm - poisson * x_mm * x_mm) / (PI * r2 * r2)
    };
    let paper_n = f64::from(wanted[0]) / (line(0.0) + line(spacing_mm)) * spacing_mm;
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
fn what_cannot_be_matched_is_refused() {
    let grid = Grid::new(3, 1, 1.0).expect("a grid");
    let map = || grid.map(&grid, 1.5, 0.5, Quantity::Strain).expect("a map");
    let mut memory = [0.0; Matching::floats(3, 3)];
    let short = Matching::floats(3, 3) - 1;
    let refused = |memory: &mut [f32], pins, sensors, regularisation| {
        Matching::new(memory, pins, sensors, regularisation, map()).err()
    };
    assert!(matches!(
        refused(&mut memory[..short], 3, 3, 0.1),
        Some(Error::Length { what: "memory", .. })
    ));
    for (pins, sensors, regularisation, setting) in [
        (0, 3, 0.1, "pins"),
        (101, 3, 0.1, "pins"),
        (3, 0, 0.1, "sensors"),
        (3, 3, -0.1, "regularisation"),
        (3, 3, f32::NAN, "regularisation"),
    ] {
        let Some(Error::Setting { name, .. }) = refused(&mut memory, pins, sensors, regularisation)
        else {
            panic!("{setting}")
        };
        assert_eq!(name, setting);
    }
    // Two pins at one place, and more pins than sensors.
    assert_eq!(
        Matching::new(&mut memory, 2, 3, 0.0, |sensor, _| map()(sensor, 0)).err(),
        Some(Error::Singular { pin: 1 })
    );
    assert!(matches!(
        Matching::new(&mut memory, 3, 2, 0.0, map()).err(),
        Some(Error::Singular { pin: 2 })
    ));
    let nan = Matching::new(&mut memory, 2, 3, 0.0, |sensor, pin| {
        if (sensor, pin) == (1, 1) {
            f32::NAN
        } else {
            1.0
        }
    });
    assert!(matches!(nan.err(), Some(Error::NotFinite { index: 4, .. })));
    assert!(matches!(
        grid.map(&grid, 0.0, 0.5, Quantity::Strain).err(),
        Some(Error::Setting {
            name: "depth_mm",
            ..
        })
    ));
    assert!(matches!(
        grid.map(&grid, 1.0, 0.51, Quantity::Strain).err(),
        Some(Error::Setting {
            name: "poisson",
            ..
        })
    ));
    for (columns, rows, spacing_mm) in [
        (0, 1, 1.0),
        (1, 0, 1.0),
        (1001, 1, 1.0),
        (1, 1, f64::NAN),
        (1, 1, 0.0),
    ] {
        assert!(matches!(
            Grid::new(columns, rows, spacing_mm),
            Err(Error::Setting { .. })
        ));
    }

    let mut matching = Matching::new(&mut memory, 3, 3, 0.1, map()).expect("a display");
    let before = matching
        .forces(&[0.1, 0.2, 0.1])
        .expect("forces")
        .forces
        .to_vec();
    assert_eq!(
        matching.forces(&[0.1, f32::NAN, 0.1]),
        Err(Error::NotFinite {
            what: "wanted strain",
            index: 1
        })
    );
    assert!(matching.forces(&[f32::MAX; 3]).is_err());
    assert!(matches!(
        matching.forces(&[0.1; 2]),
        Err(Error::Length { .. })
    ));
    assert_eq!(
        matching.forces(&[0.1, 0.2, 0.1]).expect("forces").forces,
        before
    );

    // Solved by the sensors, which are fewer.
    let pins = Grid::new(8, 1, 0.5).expect("a grid");
    let map = grid.map(&pins, 1.5, 0.5, Quantity::Strain).expect("a map");
    let mut memory = vec![0.0; Matching::floats(8, 3)];
    assert!(matches!(
        Matching::new(&mut memory, 8, 3, 0.0, &map).err(),
        Some(Error::Singular { pin: 3 })
    ));
    let mut matching = Matching::new(&mut memory, 8, 3, 0.1, &map).expect("a display");
    let before = matching
        .forces(&[0.1, 0.2, 0.1])
        .expect("forces")
        .forces
        .to_vec();
    assert!(
        matching.forces(&[f32::INFINITY, 0.0, 0.0]).is_err()
            && matching.forces(&[f32::MAX; 3]).is_err()
    );
    assert_eq!(
        matching.forces(&[0.1, 0.2, 0.1]).expect("forces").forces,
        before
    );
}

/// Noise, and images of objects.
#[test]
fn pivots_are_few_whatever_is_wanted() {
    let (most, greatest) = pivots(Quantity::HalfSpaceStrain);
    assert!(most <= 10 && greatest < 150_000, "{most} {greatest}");
    let (most, greatest) = pivots(Quantity::Strain);
    assert!(
        most <= 12 && greatest < 2 * TENTH_OF_FRAME,
        "{most} {greatest}"
    );
    assert!((1_900..2_000).contains(&Matching::floats(100, 16)));
}

/// The most pivots and multiplications of a frame among frames that have nothing to do with the ones
/// before.
fn pivots(quantity: Quantity) -> (u32, u32) {
    let (mut most, mut greatest) = (0, 0);
    for (side, pin_side, regularisation) in
        [(4, 4, 0.01), (4, 10, 0.01), (10, 10, 0.01), (10, 10, 0.001)]
    {
        let sensors = Grid::new(side, side, 9.0 / (side - 1) as f64).expect("a grid");
        let pins = Grid::new(pin_side, pin_side, 1.0).expect("a grid");
        let map = sensors.map(&pins, 1.5, 0.5, quantity).expect("a map");
        let mut memory = vec![0.0; Matching::floats(pins.count(), sensors.count())];
        let mut matching = Matching::new(
            &mut memory,
            pins.count(),
            sensors.count(),
            regularisation,
            map,
        )
        .expect("a display");
        let mut draw = Draw::new(11);
        for frame in 0..1000 {
            let wanted = match frame % 2 {
                0 => image(&mut draw, &sensors),
                _ => (0..sensors.count()).map(|_| draw.even(-1.0, 1.0)).collect(),
            };
            let solution = matching.forces(&wanted).expect("forces");
            assert!(
                solution.is_optimal,
                "{side} {pin_side} {frame}: {solution:?}"
            );
            (most, greatest) = (
                most.max(solution.pivots),
                greatest.max(solution.multiply_adds),
            );
        }
    }
    println!("{quantity:?}: {most} pivots, {greatest} multiplications");
    (most, greatest)
}
