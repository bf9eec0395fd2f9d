//! Windows with gaps, tones that start or stop, second tones, or mains hum.

use crate::case::{Case, GoodFits};
use crate::reference::{Noise, Tone, codes};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const FREQUENCY: f64 = 0.0346;
const FRAMES: usize = 241;

/// Returns true if the frame with this number is missing.
type Gone = fn(usize) -> bool;

#[test]
fn missing_frames() {
    let gaps: [(&str, Gone); 6] = [
        ("every 17th", |n| n % 17 == 3),
        ("every third", |n| n % 3 == 1),
        ("the first fifth", |n| n < 48),
        ("the last fifth", |n| n >= 193),
        ("the middle third", |n| (80..160).contains(&n)),
        ("both ends", |n| !(40..=200).contains(&n)),
    ];
    let mut fits = GoodFits::default();
    for (what, gone) in gaps {
        for seed in 0..5 {
            let tone = Tone::new(FREQUENCY, FRAMES, 100.0, seed);
            let mut case = Case::new(tone.values());
            for n in (0..FRAMES).filter(|n| gone(*n)) {
                (case.valid[n], case.values[n]) = (0, [f32::NAN; 16]);
            }
            let there = case.valid.iter().filter(|valid| **valid != 0).count();
            let fit = fits.add(&case, what, FREQUENCY);
            assert_eq!(fit.frames as usize, there, "{what}");
        }
    }
    fits.assert_sure();
}

#[test]
fn more_holes_than_frames_are_too_short() {
    let mut case = Case::new(Tone::default().values());
    (0..FRAMES)
        .filter(|n| n % 5 > 1)
        .for_each(|n| case.valid[n] = 0);
    assert_eq!(case.fit().status, Status::TooShort);
}

/// Fits windows that have a tone in one part, and noise throughout.
fn partly(
    seeds: std::ops::Range<u64>,
    mut check: impl FnMut(&str, f64, &Fit, f64),
    cycles: &[f64],
) {
    for (from, to) in [
        (0.3, 1.0),
        (0.5, 1.0),
        (0.7, 1.0),
        (0.0, 0.7),
        (0.0, 0.5),
        (0.0, 0.3),
        (0.2, 0.8),
    ] {
        for cycles in cycles {
            for seed in seeds.clone() {
                let frequency = cycles / FRAMES as f64;
                let tone = Tone::new(frequency, FRAMES, 100.0, seed);
                let silence = Tone {
                    amplitude: 0.0,
                    ..tone.clone()
                }
                .values();
                let mut case = Case::new(tone.values());
                for (n, frame) in case.values.iter_mut().enumerate() {
                    if !(from..to).contains(&(n as f64 / FRAMES as f64)) {
                        *frame = silence[n];
                    }
                }
                let what = format!("{cycles} cycles, {from} to {to} of the window, seed {seed}");
                check(&what, to - from, &case.fit(), frequency);
            }
        }
    }
}

/// Error of a fit's frequency, cycles per frame.
fn off(fit: &Fit, frequency: f64) -> f64 {
    (f64::from(fit.frequency) - frequency).abs()
}

/// Asserts that a fit, if good, is within 5 sigma.
#[track_caller]
fn assert_not_good_and_wrong(what: &str, fit: &Fit, off: f64) {
    let is_right = fit.status != Status::Good || off < 5.0 * f64::from(fit.sigma);
    assert!(is_right, "{what}: {fit:?}");
}

/// Fits two tones in noise; `ratio` and `fraction` are the second's frequency and amplitude
/// relative to the first's.
fn two_tones(ratio: f64, fraction: f64, noise_codes: f64, seed: u64) -> Fit {
    let mut noise = Noise::new(seed);
    let values = codes(FRAMES, |c, t| {
        let phase = (c as u64 + 7 * seed) as f64;
        let tones = (TAU * FREQUENCY * t + 1.3 * phase).cos()
            + fraction * (TAU * ratio * FREQUENCY * t + 2.9 * phase).cos();
        1000.0 * tones + noise_codes * noise.next()
    });
    Case::new(values).fit()
}

/// Sigma ignores the tone's ends, yet the frequency must be right to half a bin, or the fit
/// ambiguous. A tone in less than half of the window may be lost in the noise estimated next to it,
/// and must not be good.
#[test]
fn a_tone_that_starts_or_ends_inside_is_found() {
    let check = |what: &str, fraction: f64, fit: &Fit, frequency: f64| {
        if fraction < 0.45 {
            assert_ne!(fit.status, Status::Good, "{what}: {fit:?}");
        } else {
            let off = off(fit, frequency) * FRAMES as f64;
            assert!(fit.status.has_tone(), "{what}: {fit:?}");
            let is_near = off < 0.5 || fit.status == Status::Ambiguous;
            assert!(is_near, "{what}: {off} bins, {fit:?}");
        }
    };
    partly(0..5, check, &[8.34, 20.0]);
}

#[test]
fn a_packet_of_few_cycles_is_no_comb() {
    let check = |what: &str, _: f64, fit: &Fit, frequency: f64| {
        let off = off(fit, frequency) * FRAMES as f64;
        assert!(
            fit.status != Status::Good || off < 0.5,
            "{what}: {off} bins, {fit:?}"
        );
    };
    partly(0..5, check, &[4.3]);
}

/// At most one window in a hundred is an outlier reported as good.
#[test]
fn a_tone_that_starts_or_ends_inside_is_good_only_where_its_interval_holds() {
    let (mut windows, mut wrong) = (0, Vec::new());
    let check = |what: &str, _: f64, fit: &Fit, frequency: f64| {
        windows += 1;
        if fit.status == Status::Good && off(fit, frequency) > 5.0 * fit.sigma as f64 {
            wrong.push(format!("{what}: {} +- {}", fit.frequency, fit.sigma));
        }
    };
    partly(0..20, check, &[4.3, 8.34, 20.0]);
    assert!(100 * wrong.len() <= windows, "{wrong:#?} of {windows}");
}

/// A jump of the reference moves all channels by a fraction of their level. Such a step resembles a
/// tone with overtones, but must not be taken for one.
#[test]
fn a_step_of_the_reference_is_no_tone() {
    const STEP_FRAMES: usize = 438;
    for seed in 0..120u64 {
        let mut noise = Noise::new(seed);
        let part = |step: f64| (seed as f64 * step).fract();
        let cycles = 2.5 + 3.0 * part(0.618);
        let (at, fraction) = (0.1 + 0.8 * part(0.414), 0.03 + 0.17 * part(0.732));
        let tone = cycles / STEP_FRAMES as f64;
        let fit = Case::new(codes(STEP_FRAMES, |c, n| {
            let level = 40_000.0 + 1_500.0 * c as f64;
            let is_before = n < (at - 0.5) * STEP_FRAMES as f64;
            let reference = if is_before { 1.0 } else { 1.0 + fraction };
            let wave = (TAU * tone * n + c as f64 * 0.4).cos();
            (level + 1000.0 * wave) / reference + 50.0 * noise.next()
        }))
        .fit();
        let what = format!("seed {seed}, {cycles} cycles, {fraction} at {at}");
        assert_not_good_and_wrong(&what, &fit, off(&fit, tone));
    }
}

/// Either tone may be found. If one is a harmonic of the other, the lower one must be found.
#[test]
fn two_tones_of_equal_strength() {
    for (ratio, common) in [
        (1.15, None),
        (1.3, None),
        (1.5, None),
        (2.0, Some(1.0)),
        (3.0, Some(1.0)),
        (3.7, None),
    ] {
        for seed in 0..10 {
            let fit = two_tones(ratio, 1.0, 50.0, seed);
            let what = format!("ratio {ratio}, seed {seed}");
            if !fit.status.has_tone() {
                continue;
            }
            // Allow half a bin, because the other tone pulls the estimate.
            let off_of = |of: f64| off(&fit, of * FREQUENCY);
            let min = off_of(1.0).min(off_of(ratio));
            let is_ambiguous = fit.status == Status::Ambiguous;
            assert!(min < 0.5 / FRAMES as f64 || is_ambiguous, "{what}: {fit:?}");
            // The part of the other tone that all channels share is projected out, so the fit is
            // nearer to the truth than the f64 reference, which the other tone pulls.
            assert_not_good_and_wrong(&what, &fit, min);
            if let Some(common) = common {
                let is_right = off_of(common) < 5.0 * fit.sigma as f64;
                assert!(is_ambiguous || is_right, "{what}: {fit:?}");
            }
        }
    }
}

/// A second tone of half, a quarter or an eighth of the amplitude must be reported if it is far
/// from the first and not a multiple of it.
#[test]
fn a_weaker_tone_is_named() {
    for fraction in [0.5, 0.25, 0.125] {
        for ratio in [1.73, 2.37, 3.7] {
            for seed in 0..5 {
                let fit = two_tones(ratio, fraction, 20.0, seed);
                let what = format!("{fraction} at {ratio}, seed {seed}");
                if fit.status.has_tone() {
                    let other = fit.other_tone.unwrap_or_else(|| panic!("{what}: {fit:?}"));
                    let off = (other.frequency as f64 - ratio * FREQUENCY).abs();
                    assert!(off < 0.5 / FRAMES as f64, "{what}: {fit:?}");
                }
            }
        }
    }
}

/// Mains hum ten times as strong as the tone, at a known frequency that may be aliased.
#[test]
fn mains_stronger_than_the_tone() {
    let mut fits = GoodFits::default();
    for (mains_hz, rate_hz) in [(50.0, 241.14), (60.0, 241.14), (60.0, 100.0), (50.0, 70.0)] {
        for frequency in [0.0346, 0.11, 3.2 / FRAMES as f64] {
            for seed in 0..5 {
                let case = beside_mains(frequency, mains_hz / rate_hz, seed);
                let what = format!("{mains_hz} Hz at {rate_hz} Hz, {frequency}, seed {seed}");
                let fit = fits.add(&case, &what, frequency);
                assert_not_good_and_wrong(&what, &fit, off(&fit, frequency));
            }
        }
    }
    fits.assert_sure();
}

/// Mains hum is fitted before the tone. Within four cycles of each other they share energy: the
/// tone is right to two percent, but its sigma is too small.
#[test]
fn mains_folded_next_to_the_tone() {
    for frequency in [0.0346, 3.2 / FRAMES as f64] {
        for seed in 0..10 {
            let fit = beside_mains(frequency, 60.0 / 61.7, seed).fit();
            let off = f64::from(fit.frequency) / frequency - 1.0;
            assert!(
                fit.status.has_tone() && off.abs() < 0.02,
                "{frequency}, seed {seed}: {fit:?}"
            );
        }
    }
}

/// Mains hum that is not declared is taken for the tone.
#[test]
fn mains_missing_in_the_settings_are_the_tone() {
    let mut case = Case::new(Tone::default().values());
    add_mains(&mut case, 50.0 / 241.14);
    case.interferer = None;
    let fit = case.fit();
    // Next to the mains line, the part of the tone that all channels share is projected out. The
    // f64 reference leaves it in, and is less certain.
    assert_eq!(fit.status, Status::Good, "{fit:?}");
    assert_not_good_and_wrong("mains", &fit, off(&fit, 50.0 / 241.14));
}

/// Mains hum aliased to zero is a constant level.
#[test]
fn mains_folded_onto_zero() {
    let mut fits = GoodFits::default();
    for seed in 0..10 {
        fits.add(&beside_mains(FREQUENCY, 1.0, seed), "folded", FREQUENCY);
    }
    fits.assert_sure();
}

/// Mains hum aliased to half the frame rate has only a cosine part. It is not subtracted, so it
/// counts as noise.
#[test]
fn mains_folded_onto_half_the_frame_rate() {
    for seed in 0..10 {
        let fit = beside_mains(FREQUENCY, 0.5, seed).fit();
        let off = (f64::from(fit.frequency) - FREQUENCY).abs();
        assert!(
            fit.status == Status::Good && off < 4.5 * f64::from(fit.sigma),
            "seed {seed}: {fit:?}"
        );
        assert!(f64::from(fit.sigma) < 0.002 * FREQUENCY, "{fit:?}");
    }
}

/// Case of a tone in noise with mains hum at `cycles_per_frame`.
fn beside_mains(frequency: f64, cycles_per_frame: f64, seed: u64) -> Case {
    let tone = Tone::new(frequency, FRAMES, 100.0, seed);
    let mut case = Case::new(tone.values());
    add_mains(&mut case, cycles_per_frame);
    case
}

fn add_mains(case: &mut Case, cycles_per_frame: f64) {
    case.interferer = Some(cycles_per_frame as f32);
    for (n, frame) in case.values.iter_mut().enumerate() {
        for (c, value) in frame.iter_mut().enumerate() {
            let hum = (TAU * cycles_per_frame * n as f64 + c as f64).cos();
            *value += (10_000.0 * hum).round() as f32;
        }
    }
}
