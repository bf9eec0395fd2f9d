//! Compares the fit and its status with the truth of synthetic windows.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod reference;

use reference::Tone;
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status, Table};

fn fit(values: &[[f32; 16]], valid: &[u16], harmonics: u8) -> Fit {
    let mut table = Table { values, valid };
    let mut fitter = Box::new(Fitter::new());
    fitter
        .fit(
            &mut FrameSpan::new(&mut table, 0, values.len() as u32).with_quantization(1.0),
            &Scene::with_harmonics(harmonics),
        )
        .unwrap()
}

fn fit_whole(values: &[[f32; 16]], harmonics: u8) -> Fit {
    fit(values, &vec![u16::MAX; values.len()], harmonics)
}

/// Error of a fit's frequency, in its own standard deviations.
fn off(fit: &Fit, truth: f64) -> f64 {
    (f64::from(fit.frequency) - truth) / f64::from(fit.sigma)
}

/// Asserts that a fit is good, and within `sigmas` of its standard deviations from the truth.
#[track_caller]
fn assert_good(fit: &Fit, truth: f64, sigmas: f64) {
    assert_eq!(fit.status, Status::Good, "{truth}: {fit:?}");
    assert!(off(fit, truth).abs() < sigmas, "{truth}: {fit:?}");
}

#[test]
fn the_estimate_is_right() {
    // Cycles per frame, frames, harmonics: from one cycle in the window to 0.45 of the frame rate.
    for (frequency, frames, harmonics) in [
        (0.02, 50, 1),
        (0.0152, 145, 1),
        (0.0346, 241, 1),
        (0.0346, 241, 4),
        (0.0765, 48, 3),
        (0.0152, 885, 4),
        (0.45, 241, 1),
    ] {
        for seed in 0..5 {
            let mut tone = Tone::new(frequency, frames, 100.0, seed);
            tone.harmonics = harmonics;
            let fit = fit_whole(&tone.values(), harmonics as u8);
            // About one cycle may be a single bump, so the fit is ambiguous.
            let is_bump = frequency * frames as f64 <= 1.4;
            let expected = if is_bump {
                Status::Ambiguous
            } else {
                Status::Good
            };
            assert_eq!(fit.status, expected, "{tone:?} {fit:?}");
            assert_eq!(fit.harmonics as usize, harmonics, "{tone:?}");
            let off = off(&fit, frequency);
            assert!(off.abs() < 4.5, "{tone:?}: {off} sigma from the truth");
        }
    }
}

#[test]
fn sigma_is_the_spread_of_the_estimates() {
    for (frequency, frames, noise) in [
        (0.0346, 241, 450.0),
        (0.0346, 241, 14.0),
        (0.0152, 73, 140.0),
    ] {
        let mut sum = 0.0;
        let runs = 300;
        for seed in 0..runs {
            let mut tone = Tone::new(frequency, frames, noise, seed);
            tone.harmonics = 3;
            sum += off(&fit_whole(&tone.values(), 3), frequency).powi(2);
        }
        // The RMS of 300 normal deviates stays within 12 % of one (three of its standard
        // deviations).
        let spread = (sum / runs as f64).sqrt();
        let is_one = (0.88..1.12).contains(&spread);
        assert!(is_one, "{frequency} {frames}: {spread}");
    }
}

#[test]
fn amplitudes_offsets_and_phases_are_those_of_the_scene() {
    let tone = Tone {
        noise: 1.0,
        harmonics: 3,
        ..Tone::default()
    };
    let fit = fit_whole(&tone.values(), 3);
    for (c, channel) in fit.channels.iter().enumerate() {
        let truth = tone.channel(c);
        let what = format!("{c}: {channel:?} {truth:?}");
        assert!(
            (channel.amplitude as f64 - truth.amplitude).abs() < 1.0,
            "{what}"
        );
        assert!((channel.offset as f64 - truth.offset).abs() < 1.0, "{what}");
        let apart = (channel.phase_rad as f64 - truth.phase_rad) / std::f64::consts::TAU;
        assert!((apart - apart.round()).abs() < 1e-3, "{what}");
        assert!((0.8..1.2).contains(&channel.residual), "{what}");
    }
}

#[test]
fn noise_alone_is_no_tone() {
    for frames in [48, 241, 965] {
        let found = (0..200)
            .filter(|seed| {
                let mut noise = Tone::new(0.0346, frames, 50.0, *seed);
                noise.amplitude = 0.0;
                fit_whole(&noise.values(), 4).status != Status::NoTone
            })
            .count();
        // At most 1 %, with a margin for 200 trials.
        assert!(found <= 5, "{found} of 200 windows of {frames} frames");
    }
}

#[test]
fn a_tone_at_10_db_and_two_cycles_is_found() {
    // 10 dB: A^2 / 2 = 10 sigma^2.
    let missed = (0..200)
        .filter(|seed| {
            let tone = Tone::new(2.0 / 60.0, 60, 1000.0 / 20f64.sqrt(), *seed);
            fit_whole(&tone.values(), 4).status != Status::Good
        })
        .count();
    assert!(missed <= 2, "{missed} of 200");
}

#[test]
fn nothing_to_fit_says_so() {
    let flat = vec![[7.0; 16]; 241];
    assert_eq!(fit_whole(&flat, 3).status, Status::Nothing);
    let tone = Tone::default().values();
    assert_eq!(fit(&tone, &vec![0; tone.len()], 3).status, Status::Nothing);
    assert_eq!(fit_whole(&tone[..10], 3).status, Status::TooShort);
}

#[test]
fn too_little_of_a_cycle_says_so() {
    for seed in 0..20 {
        let fit = fit_whole(&Tone::new(0.3 / 241.0, 241, 10.0, seed).values(), 1);
        let unsure = [Status::TooShort, Status::NoTone, Status::Ambiguous];
        assert!(unsure.contains(&fit.status), "{fit:?}");
    }
}

#[test]
fn the_fundamental_is_found_below_a_stronger_harmonic() {
    for (overtones, noise) in [
        ([2.0, 0.3, 0.2], 100.0),
        ([0.8, 1.6, 0.3], 100.0),
        ([2.0, 0.0, 0.0], 20.0),
    ] {
        for seed in 0..10 {
            let tone = Tone {
                harmonics: 4,
                overtones,
                noise,
                seed,
                ..Tone::default()
            };
            let fit = fit_whole(&tone.values(), 5);
            assert_good(&fit, tone.frequency, 5.0);
        }
    }
}

#[test]
fn bad_channels_do_not_hurt() {
    let tone = Tone::default();
    let clean = fit_whole(&tone.values(), 1);
    let mut values = tone.values();
    let mut loud = Tone::new(tone.frequency, tone.frames, 1e6, 77);
    loud.amplitude = 0.0;
    for (frame, loud) in values.iter_mut().zip(loud.values()) {
        frame[3] = loud[3];
        frame[9] = 8_388_607.0;
    }
    // Taxel 12 was at the rail for an eighth of the window, taxel 13 for three frames.
    let mut valid = vec![u16::MAX; values.len()];
    valid[40..70].fill(!(1 << 12));
    valid[90..93].fill(!(1 << 13));
    let fit = fit(&values, &valid, 1);
    assert_good(&fit, tone.frequency, 4.0);
    assert_eq!(fit.usable, !(1 << 9 | 1 << 12));
    assert_eq!(fit.frames, 238);
    // Thirteen channels remain of sixteen.
    let ratio = fit.sigma / clean.sigma / (16f32 / 13.0).sqrt();
    assert!((ratio - 1.0).abs() < 0.1, "{fit:?} {clean:?}");
}

#[test]
fn missing_frames_and_drift_do_not_bias() {
    for seed in 0..20 {
        let tone = Tone::new(0.0346, 241, 50.0, seed);
        let mut values = tone.values();
        let mut valid = vec![u16::MAX; values.len()];
        for (n, frame) in values.iter_mut().enumerate() {
            for (c, value) in frame.iter_mut().enumerate() {
                *value += (n as f32 * (c as f32 - 5.0)).round();
            }
            if n % 17 == 5 || (100..130).contains(&n) {
                valid[n] = 0;
                *frame = [0.0; 16];
            }
        }
        let fit = fit(&values, &valid, 1);
        assert_good(&fit, tone.frequency, 4.0);
        let there = valid.iter().filter(|v| **v != 0).count();
        assert_eq!(fit.frames as usize, there);
    }
}

/// Across a gap, strong lines of a harmonic comb can cancel each other. A comb at a third of the
/// tone's frequency must not be taken for the tone.
#[test]
fn a_gap_makes_no_subharmonic() {
    for (frequency, frames, gap) in [
        (4.3 / 121.0, 121, 30..70),
        (4.3 / 121.0, 121, 40..90),
        (3.3 / 241.0, 241, 80..170),
    ] {
        for seed in 0..20 {
            let tone = Tone::new(frequency, frames, 100.0, seed);
            let mut valid = vec![u16::MAX; frames];
            valid[gap.clone()].fill(0);
            let fit = fit(&tone.values(), &valid, 4);
            let is_right = off(&fit, frequency).abs() < 6.0;
            assert!(fit.status != Status::Good || is_right, "{tone:?} {fit:?}");
        }
    }
}

/// Two frames that each lack some taxels are left out; all taxels are kept.
#[test]
fn half_a_frame_is_left_out() {
    let tone = Tone::default();
    let mut valid = vec![u16::MAX; tone.frames];
    valid[50] = 0x00ff;
    valid[60] = 0xff00;
    let fit = fit(&tone.values(), &valid, 1);
    let found = (fit.status, fit.usable, fit.frames);
    assert_eq!(found, (Status::Good, u16::MAX, 239));
}

/// A drift stronger than a fast tone hides the tone from the search on means, but not from the
/// search on frames.
#[test]
fn a_fast_tone_on_a_drift_is_found() {
    let mut tone = Tone::new(35.0 / 241.14, 241, 20.0, 1);
    tone.amplitude = 300.0;
    let mut values = tone.values();
    for (n, frame) in values.iter_mut().enumerate() {
        let drift = 1400.0 * (-(n as f32) / 80.0).exp();
        frame.iter_mut().for_each(|value| *value += drift.round());
    }
    let fit = fit_whole(&values, 4);
    assert_eq!(fit.status, Status::Good, "{fit:?}");
    let off = fit.frequency as f64 / tone.frequency - 1.0;
    assert!(off.abs() < 1e-3, "{fit:?}");
}
