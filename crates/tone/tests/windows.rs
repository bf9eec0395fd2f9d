//! Tests the whole estimator on synthetic windows.

use ridgetone_tone::{Band, Fit, Fitter, FrameSpan, Frames, Scene, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;

/// Uniform random numbers from 0 to 1, the same on every platform.
struct Even(u64);

impl Even {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a nearly normal number, the sum of twelve uniform ones.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// Returns frames with a tone of `cycles` cycles and overtones, 20 dB above white noise; no tone if
/// `cycles` is zero.
fn window(frames: usize, channels: usize, cycles: f64, seed: u64) -> Vec<f32> {
    with_overtones(1.0, frames, channels, cycles, seed)
}

fn with_overtones(
    overtones: f64,
    frames: usize,
    channels: usize,
    cycles: f64,
    seed: u64,
) -> Vec<f32> {
    let mut even = Even(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let phases: Vec<[f64; 3]> = (0..channels)
        .map(|_| [0, 1, 2].map(|_| even.next()))
        .collect();
    let mut values = Vec::new();
    for n in 0..frames {
        let turns = cycles * (n as f64 + 0.5) / frames as f64;
        for phases in &phases {
            let wave = |h: usize, amplitude: f64| {
                amplitude * (TAU * (h as f64 * turns + phases[h - 1])).cos()
            };
            let tone = wave(1, 1.0) + overtones * (wave(2, 0.4) + wave(3, 0.2));
            let tone = if cycles > 0.0 { tone } else { 0.0 };
            values.push((5.0 + 10.0 * tone + 0.7 * even.normal()) as f32);
        }
    }
    values
}

fn fit(values: &[f32], channels: usize, scene: &Scene) -> Fit {
    let mut frames = Frames::new(values, channels).expect("1 to 16 channels");
    let count = frames.count();
    let mut span = FrameSpan::new(&mut frames, 0, count).with_frame_rate(count as f32);
    Fitter::new()
        .fit(&mut span, scene)
        .expect("its frames are there")
}

/// A `static` takes no space in flash only if all its bytes are zero.
#[test]
fn a_fresh_fitter_is_all_zeros() {
    let fitter = Box::new(Fitter::new());
    let text = format!("{fitter:?}");
    let is_zero = |word: &str| word.parse::<f64>().is_ok_and(|number| number == 0.0);
    let numbers = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '.' && c != '-');
    let words = numbers.filter(|word| word.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    let mut count = 0;
    for word in words {
        assert!(is_zero(word), "{word}");
        count += 1;
    }
    assert!(count > 5_000 && !text.contains("true"), "{count}");
}

#[test]
fn tones_in_white_noise_are_good_and_their_intervals_hold() {
    for (scene, overtones) in [(Scene::DEFAULT, 1.0), (Scene::LEAN, 0.0)] {
        let (mut good, mut held) = (0, 0);
        for seed in 0..40 {
            let cycles = 2.0 + 0.4 * seed as f64;
            let values = with_overtones(overtones, 240, CHANNELS, cycles, seed);
            let fit = fit(&values, CHANNELS, &scene);
            let error = (f64::from(fit.frequency) - cycles).abs();
            assert!(
                !fit.status.has_tone() || error < 0.02 * cycles,
                "{overtones} {cycles}: {fit:?}"
            );
            good += u32::from(fit.status == Status::Good);
            held += u32::from(error <= 1.96 * f64::from(fit.sigma));
        }
        assert!(
            good >= 38 && held >= 34,
            "{overtones}: {good} good, {held} held"
        );
    }
}

#[test]
fn noise_alone_is_no_tone() {
    for channels in [1, 4, 16] {
        for seed in 0..40 {
            let fit = fit(&window(240, channels, 0.0, seed), channels, &Scene::DEFAULT);
            assert_ne!(
                fit.status,
                Status::Good,
                "{channels} channels, {seed}: {fit:?}"
            );
        }
    }
}

#[test]
fn channels_that_are_constant_ramps_or_not_finite_are_left_out() {
    let mut values = window(240, 6, 7.0, 3);
    for (n, frame) in values.chunks_exact_mut(6).enumerate() {
        frame[0] = 3.0;
        frame[1] = 0.25 * n as f32;
        frame[2] = f32::NAN;
    }
    let fit = fit(&values, 6, &Scene::DEFAULT);
    assert_eq!((fit.status, fit.usable), (Status::Good, 0b11_1000));
    assert!((fit.frequency - 7.0).abs() < 0.02, "{fit:?}");
}

#[test]
fn few_frames_are_too_short_and_values_without_any_change_are_nothing() {
    assert_eq!(
        fit(&[1.0; 16 * 100], 16, &Scene::DEFAULT).status,
        Status::Nothing
    );
    let short = window(23, 4, 3.0, 1);
    assert_eq!(fit(&short, 4, &Scene::DEFAULT).status, Status::TooShort);
    let none = vec![f32::NAN; 400];
    assert_eq!(fit(&none, 4, &Scene::DEFAULT).status, Status::Nothing);
}

/// Scattered missing frames are left out, and must only widen the interval.
#[test]
fn gaps_widen_the_interval_and_do_no_more() {
    let mut even = Even(7);
    let whole = window(240, 8, 9.3, 5);
    let mut gaps = whole.clone();
    for frame in gaps.chunks_exact_mut(8) {
        if even.next() < 0.25 {
            frame.fill(f32::NAN);
        }
    }
    let (whole, gaps) = (
        fit(&whole, 8, &Scene::DEFAULT),
        fit(&gaps, 8, &Scene::DEFAULT),
    );
    assert_eq!(
        (whole.status, gaps.status),
        (Status::Good, Status::Good),
        "{gaps:?}"
    );
    assert!((gaps.frequency - 9.3).abs() < 0.02, "{gaps:?}");
    assert!(gaps.frames < 200 && gaps.sigma > whole.sigma, "{gaps:?}");
}

/// Along a path at varying speed, the frequency must be in cycles per unit of path.
#[test]
fn along_a_path_the_frequency_is_in_cycles_per_its_unit() {
    let mut even = Even(3);
    let place = |frame: u32| {
        let t = frame as f64 / 300.0;
        20.0 * t + 3.0 * (TAU * t).sin()
    };
    let mut values = Vec::new();
    for n in 0..300 {
        for channel in 0..8 {
            let turns = 0.5 * place(n) + 0.13 * f64::from(channel);
            values.push((10.0 * (TAU * turns).cos() + even.normal()) as f32);
        }
    }
    let mut frames = Frames::new(&values, 8).expect("eight channels");
    let place = |frame: u32| place(frame) as f32;
    let mut span = FrameSpan::new(&mut frames, 0, 300)
        .along(&place)
        .expect("a path");
    let fit = Fitter::new()
        .fit(&mut span, &Scene::DEFAULT)
        .expect("its frames are there");
    assert_eq!(fit.status, Status::Good, "{fit:?}");
    assert!(
        (fit.frequency - 0.5).abs() < 4.0 * fit.sigma && fit.sigma < 1e-3,
        "{fit:?}"
    );
}

/// A tone must be common to the channels. If each has a different one, the fit is not good.
#[test]
fn channels_with_a_tone_of_their_own_share_none() {
    let mut even = Even(11);
    for number in 0..20 {
        let cycles = [3.0, 7.7, 12.4, 21.3].map(|cycles| cycles + 1.5 * even.next());
        let mut values = Vec::new();
        for n in 0..240 {
            for cycles in cycles {
                let turns = cycles * n as f64 / 240.0;
                values.push((14.0 * (TAU * turns).cos() + even.normal()) as f32);
            }
        }
        let fit = fit(&values, 4, &Scene::DEFAULT);
        assert_eq!(fit.status, Status::Ambiguous, "{number}: {fit:?}");
        assert!(fit.other_tone.is_some(), "{number}: {fit:?}");
    }
}

/// The mains hum is 0.5 Hz off the declared frequency, with three times the tone's amplitude.
#[test]
fn mains_hum_is_found_and_taken_out() {
    let mut even = Even(13);
    let rate = 241.14;
    let mut values = Vec::new();
    for n in 0..241 {
        let t = n as f64 / rate;
        for channel in 0..8 {
            let (tone, hum) = (TAU * (8.3 * t + 0.1 * channel as f64), TAU * (49.5 * t));
            values.push((14.0 * tone.cos() + 42.0 * hum.cos() + even.normal()) as f32);
        }
    }
    let mut frames = Frames::new(&values, 8).expect("eight channels");
    let span = FrameSpan::new(&mut frames, 0, 241).with_frame_rate(rate as f32);
    let mut span = span.with_interferer((50.0 / rate) as f32);
    let fit = Fitter::new()
        .fit(&mut span, &Scene::DEFAULT)
        .expect("its frames are there");
    assert_eq!(fit.status, Status::Good, "{fit:?}");
    assert!(
        (fit.frequency - 8.3).abs() < 4.0 * fit.sigma && fit.sigma < 0.02,
        "{fit:?}"
    );
    let hum = f64::from(fit.interferer.expect("hum")) * rate;
    assert!((hum - 49.5).abs() < 0.02, "{hum}");
}

/// One value in a hundred is off by twenty standard deviations.
#[test]
fn impulses_are_replaced() {
    let mut even = Even(17);
    for seed in 0..10u32 {
        let cycles = 3.0 + f64::from(seed);
        let mut values = window(96, 8, cycles, u64::from(seed));
        for value in &mut values {
            if even.next() < 0.01 {
                *value += 14.0;
            }
        }
        let fit = fit(&values, 8, &Scene::DEFAULT);
        assert_eq!(fit.status, Status::Good, "{cycles}: {fit:?}");
        assert!(
            (f64::from(fit.frequency) - cycles).abs() < 4.0 * f64::from(fit.sigma),
            "{fit:?}"
        );
    }
}

/// If a band is declared, a line outside it must not be taken for a fundamental.
#[test]
fn a_tone_is_looked_for_in_the_band_alone() {
    let mut even = Even(11);
    let mut values = Vec::new();
    for n in 0..240 {
        for channel in 0..8 {
            let line = |cycles: f64| {
                (TAU * (cycles * f64::from(n) / 240.0 + 0.13 * f64::from(channel))).cos()
            };
            values.push((line(20.0) + 2.0 * line(8.0) + 0.05 * (even.next() - 0.5)) as f32);
        }
    }
    for (min, max, cycles) in [(7.2, 9.5, 8.0), (15.0, 30.0, 20.0)] {
        let scene = Scene {
            band: Band {
                min: min / 240.0,
                max: max / 240.0,
            },
            ..Scene::DEFAULT
        };
        let mut frames = Frames::new(&values, 8).expect("eight channels");
        let mut span = FrameSpan::new(&mut frames, 0, 240);
        let found = Fitter::new()
            .fit(&mut span, &scene)
            .expect("its frames are there");
        assert!((240.0 * found.frequency - cycles).abs() < 0.1, "{found:?}");
    }
}

/// Any unit works within the range of f32.
#[test]
fn huge_and_tiny_values_are_fitted() {
    let whole = window(240, 8, 9.3, 5);
    for unit in [1e-30, 1e30] {
        let values: Vec<f32> = whole.iter().map(|value| value * unit).collect();
        let found = fit(&values, 8, &Scene::DEFAULT);
        assert_eq!(found.status, Status::Good, "{found:?}");
        assert!((found.frequency - 9.3).abs() < 0.02, "{found:?}");
    }
}

/// In white noise, the lean scene's errors must match sigma, and its intervals must cover.
#[test]
fn a_lean_scene_finds_a_sine_in_white_noise() {
    let (mut held, mut squares) = (0, 0.0);
    for seed in 0..40 {
        let cycles = 6.3 + 0.7 * seed as f64;
        let values = with_overtones(0.0, 241, CHANNELS, cycles, seed);
        let found = fit(&values, CHANNELS, &Scene::LEAN);
        assert_eq!(found.status, Status::Good, "{cycles}: {found:?}");
        let off = (f64::from(found.frequency) - cycles) / f64::from(found.sigma);
        held += usize::from(off.abs() < 1.96);
        squares += off * off / 40.0;
    }
    assert!(
        held >= 34 && (0.5..1.6).contains(&squares),
        "{held} {squares}"
    );
}
