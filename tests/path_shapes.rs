//! Compares the fit along paths of many shapes with the truth.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod reference;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reference::{normal, unit};
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status, Table, Values};
use std::f64::consts::TAU;

const FRAMES: usize = 241;

/// Position in mm, as a function of time in windows.
type Shape = fn(f64) -> f64;

const SHAPES: [(&str, Shape); 6] = [
    ("steady", |t| 30.0 * t),
    ("backwards", |t| -30.0 * t),
    ("speeding up from rest", |t| 30.0 * t * t),
    ("stopping half way", |t| 30.0 * (2.0 * t).min(1.0)),
    ("there and back", |t| 30.0 * (0.5 - 0.5 * (TAU * t).cos())),
    ("to and fro, twice", |t| {
        22.0 * (0.5 - 0.5 * (2.0 * TAU * t).cos())
    }),
];

fn positions(shape: Shape) -> Vec<f64> {
    (0..FRAMES)
        .map(|k| shape(k as f64 / (FRAMES - 1) as f64))
        .collect()
}

/// Simulates sixteen channels; `overtones` are amplitudes relative to the fundamental, from the
/// second harmonic on.
fn scan(
    positions: &[f64],
    period_mm: f64,
    overtones: &[f64],
    noise: f64,
    seed: u64,
) -> Vec<Values> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let phases: [f64; 16] = std::array::from_fn(|_| unit(&mut rng));
    let frame = |position: &f64| {
        std::array::from_fn(|c| {
            let theta = TAU * (position / period_mm + phases[c]);
            let overtone =
                |(h, a): (usize, &f64)| a * ((h + 2) as f64 * theta + (c * h) as f64).cos();
            let wave = theta.cos() + overtones.iter().enumerate().map(overtone).sum::<f64>();
            (1000.0 * wave + noise * normal(&mut rng)).round() as f32
        })
    };
    positions.iter().map(frame).collect()
}

fn fit(values: &[Values], positions: &[f64], harmonics: u8) -> Fit {
    let valid = vec![u16::MAX; values.len()];
    let mut table = Table {
        values,
        valid: &valid,
    };
    let position = |frame: u32| positions[frame as usize] as f32;
    let mut span = FrameSpan::new(&mut table, 0, values.len() as u32)
        .with_quantization(1.0)
        .along(&position)
        .unwrap();
    let mut fitter = Box::new(Fitter::new());
    fitter
        .fit(&mut span, &Scene::with_harmonics(harmonics))
        .unwrap()
}

#[test]
fn along_any_path_it_is_right() {
    for (name, shape) in SHAPES {
        let positions = positions(shape);
        for (period_mm, harmonics) in [(10.0, 1), (4.0, 1), (3.1, 3), (1.7, 1)] {
            let overtones = &[0.5, 0.3][..harmonics - 1];
            let values = scan(&positions, period_mm, overtones, 100.0, 3);
            let fit = fit(&values, &positions, harmonics as u8);
            let what = format!("{name}, {period_mm} mm: {fit:?}");
            let found = (fit.status, fit.harmonics as usize);
            assert_eq!(found, (Status::Good, harmonics), "{what}");
            let off = (fit.frequency as f64 - 1.0 / period_mm) / fit.sigma as f64;
            assert!(off.abs() < 4.5, "{what}: {off} sigma from the truth");
        }
    }
}

#[test]
fn sigma_is_the_spread_of_the_estimates_on_a_path_too() {
    for (name, shape) in SHAPES {
        let positions = positions(shape);
        let (mut sum, runs) = (0.0, 200);
        for seed in 0..runs {
            let fit = fit(&scan(&positions, 3.1, &[0.4], 200.0, seed), &positions, 2);
            sum += ((fit.frequency as f64 - 1.0 / 3.1) / fit.sigma as f64).powi(2);
        }
        // Within three standard deviations of the RMS of 200 normal deviates.
        let spread = (sum / runs as f64).sqrt();
        assert!((0.85..1.15).contains(&spread), "{name}: {spread}");
    }
}

#[test]
fn a_strong_overtone_is_no_octave_error() {
    for (name, shape) in SHAPES {
        let positions = positions(shape);
        for overtones in [[2.5, 0.4], [0.5, 2.5]] {
            let fit = fit(&scan(&positions, 6.2, &overtones, 100.0, 5), &positions, 4);
            let cycles = fit.frequency as f64 * 6.2;
            let is_right = fit.status == Status::Good && (cycles - 1.0).abs() < 0.01;
            assert!(is_right, "{name} {overtones:?}: {cycles} {fit:?}");
        }
    }
}

#[test]
fn noise_on_a_path_is_no_tone() {
    for (name, shape) in SHAPES {
        let positions = positions(shape);
        let noise = |seed| scan(&positions, f64::INFINITY, &[], 100.0, seed);
        let fits = (0..200).map(|seed| fit(&noise(seed), &positions, 4));
        let found = fits.filter(|fit| fit.status.has_tone()).count();
        // At most 1 %, with a margin for 200 trials.
        assert!(found <= 5, "{name}: {found} of 200");
    }
}

/// An encoder quantizes positions, so the finger seems to stand still between two counts.
#[test]
fn the_grains_of_an_encoder_do_no_harm() {
    let exact = positions(|t| 30.0 * t * (0.5 + 0.5 * t));
    let values = scan(&exact, 3.1, &[0.4], 100.0, 3);
    for grain_mm in [0.01, 0.1, 0.3] {
        let grain = |position: &f64| (position / grain_mm).round() * grain_mm;
        let grains: Vec<f64> = exact.iter().map(grain).collect();
        let fit = fit(&values, &grains, 3);
        let off = fit.frequency as f64 * 3.1 - 1.0;
        // Quantization shifts the tone slightly.
        let is_near = fit.status.has_tone() && off.abs() < 0.002;
        assert!(is_near, "{grain_mm} mm: {off} {fit:?}");
    }
}

#[test]
fn a_path_that_is_none_is_refused() {
    let values = vec![[0.0; 16]; FRAMES];
    let valid = vec![u16::MAX; FRAMES];
    for position in [
        |_| 5.0,
        |frame| if frame == 7 { f32::NAN } else { frame as f32 },
        |_| f32::INFINITY,
    ] {
        let position: fn(u32) -> f32 = position;
        let mut table = Table {
            values: &values,
            valid: &valid,
        };
        let span = FrameSpan::new(&mut table, 0, FRAMES as u32);
        assert!(span.along(&position).is_none());
    }
}
