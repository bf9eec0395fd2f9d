//! Tests fits along a path: channels read one after another are at different positions, and where
//! the path turns, friction changes its sign.

mod common;

use ridgetone_tone::{CHANNELS_MAX, Delays, Fit, Fitter, FrameSpan, Frames, Scene, Status};
use std::f64::consts::TAU;

const COUNT: usize = 240;
const PERIOD_MM: f64 = 2.0;

/// Delay of each channel, frames. The first channels have the largest amplitudes, so errors do not
/// cancel.
fn later(channel: usize) -> f64 {
    (channel as f64 - 7.5) / 16.0
}

/// Disturbances of a window, and whether the fit knows the delays.
#[derive(Clone, Copy, Default)]
struct Recipe {
    /// Amount by which the level is higher while the path goes back.
    way: f64,
    /// Amplitude of a third harmonic, which is not fitted.
    third: f64,
    noise: f64,
    seed: u64,
    is_lateness_unknown: bool,
}

/// Fits cos(TAU x / period) along the path `x_mm`, a function of the frame number, which may be
/// fractional.
fn fit(x_mm: &dyn Fn(f64) -> f64, recipe: Recipe) -> Fit {
    let mut noise = common::normal(recipe.seed);
    let mut values = Vec::new();
    for frame in 0..COUNT {
        for channel in 0..CHANNELS_MAX {
            let at = frame as f64 + later(channel);
            let is_back = x_mm(at + 0.01) < x_mm(at);
            let level = if is_back { recipe.way } else { 0.0 };
            let gain = 1.0 - 0.05 * channel as f64;
            let turns = x_mm(at) / PERIOD_MM + 0.3 * channel as f64;
            let wave = (TAU * turns).cos() + recipe.third * (3.0 * TAU * turns).cos();
            values.push((gain * wave + level + recipe.noise * noise()) as f32);
        }
    }
    let mut frames = Frames::new(&values, CHANNELS_MAX).expect("sixteen channels");
    let place = |frame: u32| x_mm(f64::from(frame)) as f32;
    let frames_late = |channel| match recipe.is_lateness_unknown {
        true => 0.0,
        false => later(channel) as f32,
    };
    let delays = Delays {
        frames: std::array::from_fn(frames_late),
        low_pass: 0.0,
    };
    let span = FrameSpan::new(&mut frames, 0, COUNT as u32);
    let mut span = span.along(&place).expect("it moves");
    Fitter::new()
        .fit_delayed(&mut span, &Scene::with_harmonics(1), &delays)
        .expect("its frames are there")
}

/// Position of a finger that accelerates from 0.02 to 0.18 mm per frame.
fn faster(frame: f64) -> f64 {
    0.02 * frame + 0.5 * frame * frame * 0.16 / COUNT as f64
}

/// A channel that is read t frames late is v t further along the path. At the speed v = v0 + a n,
/// that is a t n more than at the start, a mean error of a t n / x of the wavelength. Weighted by
/// squared amplitude, the channels are 0.1 frames early. With a mean speed of 0.1 mm per frame and
/// a = 0.16 / 240 mm per frame, the mean error is 0.1 x 0.00067 / 0.1 = 0.07 %, and more if the fit
/// takes the delay for phase modulation.
#[test]
fn channels_that_are_late_do_not_bend_the_wavelength() {
    let (mut known, mut unknown) = (0.0, 0.0);
    for seed in 1..=20 {
        let off = |fit: &Fit| 1.0 / f64::from(fit.frequency) / PERIOD_MM - 1.0;
        let recipe = Recipe {
            noise: 2e-3,
            seed,
            ..Recipe::default()
        };
        let fit_known = fit(&faster, recipe);
        assert_eq!(fit_known.status, Status::Good, "{seed}");
        let sigma = f64::from(fit_known.sigma / fit_known.frequency);
        assert!(off(&fit_known).abs() < 5.0 * sigma, "{seed}: {fit_known:?}");
        known += off(&fit_known).powi(2) / 20.0;
        let recipe = Recipe {
            is_lateness_unknown: true,
            ..recipe
        };
        unknown += off(&fit(&faster, recipe)).powi(2) / 20.0;
    }
    let (known, unknown) = (known.sqrt(), unknown.sqrt());
    println!(
        "off by {known:.1e} of the wavelength where the lateness is known, by {unknown:.1e} where it is not"
    );
    assert!(unknown > 0.0002 && known < 0.1 * unknown);
}

/// A path that turns must be as good as a straight one. If the level differs between the two
/// directions, no good fit may be wrong, because a step in level is not a tone.
#[test]
fn ways_that_differ_are_not_good_and_wrong() {
    let turning = |frame: f64| 0.1 * (frame - frame * frame / 320.0);
    // The path turns within the first stride of the path length's measurement.
    let turned = |frame: f64| 0.0005 * (frame - 4.0) * (frame - 4.0);
    let paths: [&dyn Fn(f64) -> f64; 2] = [&turning, &turned];
    let (mut good, mut held) = (0, 0);
    for (seed, path) in (1..=50).flat_map(|seed| paths.map(|path| (seed, path))) {
        let recipe = Recipe {
            noise: 0.1,
            seed,
            ..Recipe::default()
        };
        assert_eq!(fit(path, recipe).status, Status::Good, "{seed}");
        for way in [0.3, 0.7, 1.0] {
            let unlike = fit(path, Recipe { way, ..recipe });
            if unlike.status == Status::Good {
                let off = f64::from(unlike.frequency) - 1.0 / PERIOD_MM;
                good += 1;
                held += u32::from(off.abs() < 1.96 * f64::from(unlike.sigma));
                assert!(off.abs() < 0.05 / PERIOD_MM, "{seed}, {way}: {unlike:?}");
            }
        }
    }
    println!("good {good} of 300, of which {held} hold");
    assert!(held * 100 >= good * 92, "{held} of {good}");
}

/// As in real recordings, a stage stalls and slips back by 1 % of its path, and there are overtones
/// that are not fitted. The level does not depend on the direction.
#[test]
fn a_stage_that_slips_back_on_its_way_is_steady() {
    let slips = |frame: f64| 0.08 * (frame - 14.0 * ((frame - 120.0) / 11.0).tanh());
    for seed in 1..=20 {
        let recipe = Recipe {
            third: 0.05,
            noise: 0.005,
            seed,
            ..Recipe::default()
        };
        assert_eq!(fit(&slips, recipe).status, Status::Good, "{seed}");
    }
}

/// Time constant of the bridges' low-pass at 1,840 frames a second, frames.
const LOW_PASS: f64 = 0.75;

/// Fits a wave and a second harmonic of half its amplitude after a first-order low-pass, along
/// positions delayed by the low-pass's time constant. Integrates with the trapezoidal rule.
fn fit_filtered(x_mm: &dyn Fn(f64) -> f64, channels: usize, low_pass: f64) -> Fit {
    const STEPS: usize = 50;
    let signal = |at: f64, channel: usize| {
        let turns = x_mm(at) / PERIOD_MM + 0.3 * channel as f64;
        (TAU * turns).cos() + 0.5 * (2.0 * TAU * turns).cos()
    };
    let (decay, settles) = (0.5 / STEPS as f64 / LOW_PASS, 20 * STEPS);
    let mut values = vec![0.0; COUNT * channels];
    let mut noise = common::normal(1);
    for channel in 0..channels {
        let mut out = 0.0;
        for step in 0..settles + COUNT * STEPS {
            let at = |step: usize| (step as f64 - settles as f64) / STEPS as f64;
            if step >= settles && (step - settles).is_multiple_of(STEPS) {
                let frame = (step - settles) / STEPS;
                values[frame * channels + channel] = (out + 2e-3 * noise()) as f32;
            }
            let both = signal(at(step), channel) + signal(at(step + 1), channel);
            out = ((1.0 - decay) * out + decay * both) / (1.0 + decay);
        }
    }
    let mut frames = Frames::new(&values, channels).expect("channels");
    let position = |frame: u32| x_mm(f64::from(frame) - LOW_PASS) as f32;
    let mut span = FrameSpan::new(&mut frames, 0, COUNT as u32)
        .along(&position)
        .expect("it moves");
    let delays = Delays {
        low_pass: low_pass as f32,
        ..Delays::default()
    };
    Fitter::new()
        .fit_delayed(&mut span, &Scene::with_harmonics(2), &delays)
        .expect("its frames are there")
}

/// A low-pass delays a tone of f hertz by atan(2 pi f t) / (2 pi f). Where the path is fast, tones
/// therefore lead the delayed positions: here by up to 0.19 rad, and second harmonics by up to 0.8
/// rad.
#[test]
fn a_low_pass_does_not_bend_the_wavelength() {
    let slower = |frame: f64| 0.4 * frame - 0.5 * frame * frame * 0.3 / COUNT as f64;
    let quicker = |frame: f64| 0.1 * frame + 0.5 * frame * frame * 0.3 / COUNT as f64;
    let turning = |frame: f64| 0.3 * (frame - frame * frame / 320.0);
    let paths: [(&str, &dyn Fn(f64) -> f64); 3] = [
        ("slower", &slower),
        ("quicker", &quicker),
        ("turning", &turning),
    ];
    for ((name, path), channels) in paths.iter().flat_map(|path| [(path, 16), (path, 1)]) {
        let off = |low_pass: f64| {
            let found = fit_filtered(path, channels, low_pass);
            assert_eq!(found.status, Status::Good, "{name}: {found:?}");
            let sigma = f64::from(found.sigma / found.frequency);
            (1.0 / f64::from(found.frequency) / PERIOD_MM - 1.0, sigma)
        };
        let ((known, sigma), (unknown, _)) = (off(LOW_PASS), off(0.0));
        println!("{name}, {channels} channels: {known:.1e} +- {sigma:.1e}, unknown {unknown:.1e}");
        assert!(
            unknown.abs() > 2e-4 && known.abs() < 0.1 * unknown.abs(),
            "{name}, {channels} channels: {known:.1e} {unknown:.1e}"
        );
    }
}
