//! Tests which windows of the default scene need no more than the lean path: windows that contain
//! only lines in white noise. A window that contains more must be fitted with all that the scene
//! may contain.

mod common;

use common::{even, fit_scene, normal};
use ridgetone_tone::{CHANNELS_MAX, Scene, Status};
use std::f64::consts::TAU;

const FRAMES: usize = 241;
const CYCLES: f64 = 8.3;
const WINDOWS: u64 = 40;

/// What a window contains besides a tone of amplitude 1 with an overtone, and white noise with a
/// standard deviation of 0.1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Beside {
    Nothing,
    /// One value is an outlier.
    Impulse,
    /// Values above 0.8 are cut off, in one channel.
    Clipping,
    /// Each channel's noise is autoregressive.
    Colour,
    /// Half of the noise power is the same in all channels.
    Sharing,
    /// The frequency rises by 0.4 cycles per window.
    Chirp,
    /// The amplitude falls to half.
    Fading,
    /// A line at half the frequency: the tone is a second harmonic.
    Half,
    /// The levels relax.
    Relaxation,
}

fn values(beside: Beside, seed: u64) -> Vec<f32> {
    let (mut even, mut normal) = (even(seed), normal(seed + 1));
    let phases: [f64; CHANNELS_MAX] = std::array::from_fn(|_| TAU * even());
    let mut before = [0.0; CHANNELS_MAX];
    let mut values = Vec::new();
    for n in 0..FRAMES {
        let u = 2.0 * (n as f64 + 0.5) / FRAMES as f64 - 1.0;
        let shared = normal();
        for (c, before) in before.iter_mut().enumerate() {
            let mut noise = normal();
            if beside == Beside::Colour {
                noise = 0.5 * *before + 0.75f64.sqrt() * noise;
                *before = noise;
            }
            if beside == Beside::Sharing {
                noise = 0.5f64.sqrt() * (noise + shared);
            }
            let chirp = if beside == Beside::Chirp {
                0.1 * u * u
            } else {
                0.0
            };
            let turns = 0.5 * CYCLES * u + chirp;
            let size = if beside == Beside::Fading {
                0.75 - 0.25 * u
            } else {
                1.0
            };
            let line = |order: f64| (TAU * order * turns + phases[c]).cos();
            let mut value = size * (line(1.0) + 0.2 * line(2.0)) + 0.1 * noise;
            match beside {
                Beside::Half => value += 0.1 * line(0.5),
                Beside::Impulse if (n, c) == (100, 3) => value += 1.5,
                Beside::Clipping if c == 3 => value = value.min(0.8),
                Beside::Relaxation => value += 3.0 * (-3.0 * (u + 1.0)).exp(),
                _ => {}
            }
            values.push(value as f32);
        }
    }
    values
}

/// True if the fit took the lean path: its sigma is then that of the lean scene with as many
/// harmonics, to the bit, and smaller than that of the whole fit.
fn is_plain(values: &[f32]) -> bool {
    let lean = Scene {
        harmonics: 4,
        ..Scene::LEAN
    };
    let [fit, lean] =
        [Scene::DEFAULT, lean].map(|scene| fit_scene(values, CHANNELS_MAX, &scene, |span| span));
    fit.status == Status::Good && fit.sigma.to_bits() == lean.sigma.to_bits()
}

#[test]
fn only_windows_of_lines_in_white_noise_take_the_lean_path() {
    for (beside, expected) in [
        // By chance, one window of 25 fails a test.
        (Beside::Nothing, 35..=40),
        (Beside::Impulse, 0..=0),
        (Beside::Clipping, 0..=0),
        (Beside::Colour, 0..=0),
        (Beside::Sharing, 0..=0),
        (Beside::Chirp, 0..=0),
        (Beside::Fading, 0..=0),
        (Beside::Half, 0..=0),
        (Beside::Relaxation, 0..=0),
    ] {
        let plain = (0..WINDOWS)
            .filter(|seed| is_plain(&values(beside, 1000 * seed + 77)))
            .count();
        assert!(
            expected.contains(&plain),
            "{beside:?}: {plain} of {WINDOWS}"
        );
    }
}
