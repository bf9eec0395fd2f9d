//! A square display that keeps nothing, against [`Matching`], which `matching.rs` compares with a reference in f64.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_display::{Grid, Matching, Quantity, Square};

const SENSORS: usize = 16;

fn display(side: usize) -> Square {
    let spacing_mm = 3.6 / side as f32;
    Square { side, spacing_mm, sensor_spacing_mm: 1.15, depth_mm: 1.5, poisson: 0.5, regularisation: 0.01 }
}

fn images() -> impl Iterator<Item = [f32; SENSORS]> {
    let mut draw = ChaCha8Rng::seed_from_u64(5);
    (0..40).map(move |_| core::array::from_fn(|_| (draw.next_u32() >> 8) as f32 / 16_777_216.0 - 0.3))
}

#[test]
fn forces_are_those_of_a_matching_that_keeps_its_factors() {
    for side in [1, 2, 4, 5, 7, 10] {
        let display = display(side);
        let sensors = Grid::new(4, 4, display.sensor_spacing_mm.into()).expect("a grid");
        let pins = Grid::new(side, side, display.spacing_mm.into()).expect("a grid");
        let map = sensors.map(&pins, 1.5, 0.5, Quantity::Strain).expect("a map");
        let mut factors = vec![0.0; Matching::floats(pins.count(), SENSORS)];
        let mut matching = Matching::new(&mut factors, pins.count(), SENSORS, 0.01, map).expect("a display");
        let mut memory = vec![f32::NAN; Square::floats(side)];
        let mut before = vec![0.0; pins.count()];
        for wanted in images() {
            let expected = matching.forces(&wanted).expect("forces");
            // Where a frame begins must not count: from nothing, from the frame before, from all.
            for begin in 0..3 {
                let found = display.forces(&mut memory, &wanted, &|pin| begin > 1 || begin > 0 && before[pin] > 0.0);
                let found = found.expect("forces");
                assert!(found.is_optimal && expected.is_optimal);
                let most = expected.forces.iter().fold(0.0f32, |most, n| most.max(*n));
                for (pin, (found, expected)) in found.forces.iter().zip(expected.forces).enumerate() {
                    assert!(
                        *found >= 0.0 && (found - expected).abs() <= 2e-3 * most,
                        "{side} {pin}: {found} {expected}"
                    );
                }
            }
            before.copy_from_slice(expected.forces);
        }
    }
}

/// What is mirrored gives mirrored forces.
#[test]
fn an_image_in_a_mirror_gives_forces_in_a_mirror() {
    let (mut memory, mut other) = (vec![0.0; Square::floats(6)], vec![0.0; Square::floats(6)]);
    for wanted in images() {
        let mirrored = core::array::from_fn(|n| wanted[n / 4 * 4 + 3 - n % 4]);
        let forces = display(6).forces(&mut memory, &wanted, &|_| false).expect("forces").forces;
        let others = display(6).forces(&mut other, &mirrored, &|_| false).expect("forces").forces;
        let most = forces.iter().fold(0.0f32, |most, n| most.max(*n));
        for (pin, n) in forces.iter().enumerate() {
            assert!((n - others[pin / 6 * 6 + 5 - pin % 6]).abs() <= 1e-3 * most);
        }
    }
}

#[test]
fn what_is_impossible_has_no_forces() {
    let mut memory = vec![0.0; Square::floats(10)];
    let mut wanted = [0.1; SENSORS];
    assert!(display(10).forces(&mut memory, &wanted, &|_| false).is_some());
    assert!(display(10).forces(&mut memory[1..], &wanted, &|_| false).is_none());
    assert!(display(0).forces(&mut memory, &wanted, &|_| false).is_none());
    let mut large = vec![0.0; Square::floats(12)];
    assert!(display(11).forces(&mut large, &wanted, &|_| false).is_none());
    for wrong in [f32::NAN, f32::INFINITY, f32::MAX] {
        wanted[5] = wrong;
        let forces = display(10).forces(&mut memory, &wanted, &|_| false);
        assert!(forces.is_none_or(|found| found.forces.iter().all(|n| n.is_finite())), "{wrong}");
    }
    wanted[5] = f32::NAN;
    assert!(display(10).forces(&mut memory, &wanted, &|_| false).is_none());
}
