//! A square display that keeps nothing, against [`Matching`], which `matching.rs` compares with a
//! reference in f64.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_display::{Grid, Matching, Pressing, Quantity, Square};

const SENSORS: usize = 16;

fn display(side: usize) -> Square {
    let spacing_mm = 3.6 / side as f32;
    Square {
        side,
        spacing_mm,
        sensor_spacing_mm: 1.15,
        depth_mm: 1.5,
        poisson: 0.5,
        regularisation: 0.01,
        pivots_max: 20,
        multiply_adds_max: u32::MAX,
    }
}

/// All pins press: an even load, as stress matching would have it, on sensors far above the pins'
/// spacing.
fn all(side: usize) -> Pressing {
    let mut pressing = Pressing::new();
    let one = Square {
        depth_mm: 0.5,
        regularisation: 10.0,
        ..display(side)
    };
    one.forces(
        &mut vec![0.0; Square::floats(side)],
        &[1.0; SENSORS],
        &mut pressing,
    )
    .expect("forces");
    pressing
}

fn images() -> impl Iterator<Item = [f32; SENSORS]> {
    let mut draw = ChaCha8Rng::seed_from_u64(5);
    (0..40)
        .map(move |_| core::array::from_fn(|_| (draw.next_u32() >> 8) as f32 / 16_777_216.0 - 0.3))
}

#[test]
fn forces_are_those_of_a_matching_that_keeps_its_factors() {
    for side in [1, 2, 4, 5, 7, 10] {
        let display = display(side);
        let sensors = Grid::new(4, 4, display.sensor_spacing_mm.into()).expect("a grid");
        let pins = Grid::new(side, side, display.spacing_mm.into()).expect("a grid");
        let map = sensors
            .map(&pins, 1.5, 0.5, Quantity::Strain)
            .expect("a map");
        let mut factors = vec![0.0; Matching::floats(pins.count(), SENSORS)];
        let mut matching =
            Matching::new(&mut factors, pins.count(), SENSORS, 0.01, map).expect("a display");
        let mut memory = vec![f32::NAN; Square::floats(side)];
        let mut before = Pressing::new();
        for wanted in images() {
            let expected = matching.forces(&wanted).expect("forces");
            // Where a frame begins must not count: from no pin, from those of the frame before,
            // from all.
            let mut all = all(side);
            for begin in [&mut Pressing::new(), &mut before, &mut all] {
                let found = display.forces(&mut memory, &wanted, begin);
                let found = found.expect("forces");
                assert!(found.is_optimal && expected.is_optimal);
                let most = expected.forces.iter().fold(0.0f32, |most, n| most.max(*n));
                for (pin, (found, expected)) in found.forces.iter().zip(expected.forces).enumerate()
                {
                    assert!(
                        *found >= 0.0 && (found - expected).abs() <= 2e-3 * most,
                        "{side} {pin}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// What is mirrored gives mirrored forces.
#[test]
fn an_image_in_a_mirror_gives_forces_in_a_mirror() {
    let (mut memory, mut other) = (vec![0.0; Square::floats(6)], vec![0.0; Square::floats(6)]);
    for wanted in images() {
        let mirrored = core::array::from_fn(|n| wanted[n / 4 * 4 + 3 - n % 4]);
        let forces = display(6)
            .forces(&mut memory, &wanted, &mut Pressing::new())
            .expect("forces")
            .forces;
        let others = display(6)
            .forces(&mut other, &mirrored, &mut Pressing::new())
            .expect("forces")
            .forces;
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
    assert!(
        display(10)
            .forces(&mut memory, &wanted, &mut Pressing::new())
            .is_some()
    );
    assert!(
        display(10)
            .forces(&mut memory[1..], &wanted, &mut Pressing::new())
            .is_none()
    );
    assert!(
        display(0)
            .forces(&mut memory, &wanted, &mut Pressing::new())
            .is_none()
    );
    let mut large = vec![0.0; Square::floats(12)];
    assert!(
        display(11)
            .forces(&mut large, &wanted, &mut Pressing::new())
            .is_none()
    );
    for wrong in [f32::NAN, f32::INFINITY, f32::MAX] {
        wanted[5] = wrong;
        let forces = display(10).forces(&mut memory, &wanted, &mut Pressing::new());
        assert!(
            forces.is_none_or(|found| found.forces.iter().all(|n| n.is_finite())),
            "{wrong}"
        );
    }
    wanted[5] = f32::NAN;
    assert!(
        display(10)
            .forces(&mut memory, &wanted, &mut Pressing::new())
            .is_none()
    );
}

/// A bump moves over the sensors, and a frame may solve few systems: its strains are hardly farther
/// from the wanted ones than the best.
#[test]
fn few_systems_a_frame_are_enough_while_something_moves() {
    let display = |pivots_max| Square {
        pivots_max,
        depth_mm: 2.0,
        spacing_mm: 1.0,
        ..display(10)
    };
    let sensors = Grid::new(4, 4, 1.15).expect("a grid");
    let map = sensors
        .map(
            &Grid::new(10, 10, 1.0).expect("a grid"),
            2.0,
            0.5,
            Quantity::Strain,
        )
        .expect("a map");
    let mut memory = vec![0.0; Square::floats(10)];
    let (mut few, mut many) = (Pressing::new(), Pressing::new());
    let (mut worst, mut optimal) = (0.0f32, 0);
    for frame in 0..80 {
        let wanted: [f32; SENSORS] = core::array::from_fn(|n| {
            let (x, y) = sensors.place_mm(n);
            (-((x + 4.0 - 0.1 * f64::from(frame)).powi(2) + y * y)).exp() as f32
        });
        let mut off = |pivots_max, pressing: &mut Pressing| {
            let found = display(pivots_max)
                .forces(&mut memory, &wanted, pressing)
                .expect("forces");
            let felt = |n: usize| {
                found
                    .forces
                    .iter()
                    .enumerate()
                    .map(|(pin, force)| map(n, pin) * force)
                    .sum::<f32>()
            };
            let square: f32 = wanted
                .iter()
                .enumerate()
                .map(|(n, wanted)| (felt(n) - wanted).powi(2))
                .sum();
            ((square / SENSORS as f32).sqrt(), found.is_optimal)
        };
        let ((found, is_optimal), (best, _)) = (off(3, &mut few), off(1000, &mut many));
        (worst, optimal) = (worst.max(found - best), optimal + u32::from(is_optimal));
    }
    println!("{optimal} of 80 frames are optimal; at most {worst} more than the best");
    assert!(worst < 0.02 && optimal > 70, "{optimal} of 80, {worst}");
}

/// A bump that goes round fast, and noise: the forces of eight systems a frame beside the best
/// ones.
#[test]
fn eight_systems_a_frame_give_nearly_always_the_best_forces() {
    let display = |pivots_max| Square {
        pivots_max,
        depth_mm: 2.0,
        spacing_mm: 1.0,
        ..display(10)
    };
    let sensors = Grid::new(4, 4, 1.15).expect("a grid");
    let mut draw = ChaCha8Rng::seed_from_u64(9);
    let mut memory = vec![0.0; Square::floats(10)];
    for (what, noise, step) in [("fast", 0.0, 1.0), ("noise", 0.02, 0.2)] {
        let (mut few, mut many) = (Pressing::new(), Pressing::new());
        let (mut square, mut optimal) = (0.0f32, 0);
        for frame in 0..400 {
            let along = step * f64::from(frame);
            let (x0, y0) = (2.0 * (0.7 * along).sin(), 1.5 * (0.9 * along).cos());
            let wanted: [f32; SENSORS] = core::array::from_fn(|n| {
                let (x, y) = sensors.place_mm(n);
                let drawn = (draw.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5;
                (-(x - x0).powi(2) - (y - y0).powi(2)).exp() as f32 + noise * drawn
            });
            let best = display(1000)
                .forces(&mut memory, &wanted, &mut many)
                .expect("forces")
                .forces
                .to_vec();
            let found = display(8)
                .forces(&mut memory, &wanted, &mut few)
                .expect("forces");
            let most = best.iter().fold(0.0f32, |most, n| most.max(*n));
            let off = found
                .forces
                .iter()
                .zip(&best)
                .map(|(n, best)| (n - best).abs())
                .fold(0.0, f32::max)
                / most;
            (square, optimal) = (square + off * off, optimal + u32::from(found.is_optimal));
            // What is optimal is the same from wherever it began.
            assert!(!found.is_optimal || off < 2e-3, "{what} {frame}: {off}");
        }
        let rms = (square / 400.0).sqrt();
        println!(
            "{what}: {optimal} of 400 frames are optimal; the worst pin is off by {rms} of the greatest, rms"
        );
        assert!(
            optimal >= 320 && rms < 0.03,
            "{what}: {optimal} of 400, {rms}"
        );
    }
}

/// The time of a frame has a bound: by the systems, and by the multiplications behind which none is
/// begun.
#[test]
fn a_frame_ends_when_its_multiplications_are_used_up() {
    let [least, greatest] = Square::multiply_adds(10);
    let mut memory = vec![0.0; Square::floats(10)];
    let mut ended = 0;
    for multiply_adds_max in [0, 3 * greatest, u32::MAX] {
        let display = Square {
            multiply_adds_max,
            ..display(10)
        };
        let mut before = Pressing::new();
        for wanted in images() {
            let found = display
                .forces(&mut memory, &wanted, &mut before)
                .expect("forces");
            assert!(
                (found.pivots * least..=found.pivots * greatest).contains(&found.multiply_adds),
                "{found:?}"
            );
            assert!(
                found.multiply_adds <= multiply_adds_max.saturating_add(greatest),
                "{found:?}"
            );
            // It ends for one of three reasons.
            let is_used_up = found.multiply_adds > multiply_adds_max;
            assert!(
                found.is_optimal || is_used_up || found.pivots == display.pivots_max,
                "{found:?}"
            );
            assert!(multiply_adds_max > 0 || found.pivots == 1, "{found:?}");
            ended += u32::from(is_used_up && !found.is_optimal);
        }
    }
    assert!(ended > 40, "{ended}");
}
