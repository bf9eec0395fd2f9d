//! The fit against the truth of made windows, and its statuses.

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
            let tone = Tone {
                frequency,
                frames,
                harmonics,
                noise: 100.0,
                seed,
                ..Tone::default()
            };
            let values = tone.values();
            let fit = fit_whole(&values, harmonics as u8);
            // One cycle may be a single bump.
            let expected = if frequency * frames as f64 > 1.4 {
                Status::Good
            } else {
                Status::Ambiguous
            };
            assert_eq!(fit.status, expected, "{tone:?} {fit:?}");
            assert_eq!(fit.harmonics as usize, harmonics, "{tone:?}");
            let off = (fit.frequency as f64 - frequency).abs() / fit.sigma as f64;
            assert!(off < 4.5, "{tone:?}: {off} sigma from the truth");
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
            let tone = Tone {
                frequency,
                frames,
                noise,
                harmonics: 3,
                seed,
                ..Tone::default()
            };
            let fit = fit_whole(&tone.values(), 3);
            let off = (fit.frequency as f64 - frequency) / fit.sigma as f64;
            sum += off * off;
        }
        // The root of a chi-square of 300 stays within 12 % (three of its own standard deviations).
        let spread = (sum / runs as f64).sqrt();
        assert!(
            (0.88..1.12).contains(&spread),
            "{frequency} {frames}: {spread}"
        );
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
        assert!(
            (channel.amplitude as f64 - truth.amplitude).abs() < 1.0,
            "{c}: {channel:?} {truth:?}"
        );
        assert!(
            (channel.offset as f64 - truth.offset).abs() < 1.0,
            "{c}: {channel:?} {truth:?}"
        );
        let apart = (channel.phase_rad as f64 - truth.phase_rad) / std::f64::consts::TAU;
        assert!(
            (apart - apart.round()).abs() < 1e-3,
            "{c}: {channel:?} {truth:?}"
        );
        assert!((0.8..1.2).contains(&channel.residual), "{c}: {channel:?}");
    }
}

#[test]
fn noise_alone_is_no_tone() {
    for frames in [48, 241, 965] {
        let found = (0..200)
            .filter(|seed| {
                let noise = Tone {
                    frames,
                    amplitude: 0.0,
                    noise: 50.0,
                    seed: *seed,
                    ..Tone::default()
                };
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
            let tone = Tone {
                frequency: 2.0 / 60.0,
                frames: 60,
                noise: 1000.0 / 20f64.sqrt(),
                seed: *seed,
                ..Tone::default()
            };
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
        let tone = Tone {
            frequency: 0.3 / 241.0,
            noise: 10.0,
            seed,
            ..Tone::default()
        };
        let fit = fit_whole(&tone.values(), 1);
        assert!(
            matches!(
                fit.status,
                Status::TooShort | Status::NoTone | Status::Ambiguous
            ),
            "{fit:?}"
        );
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
            assert_eq!(fit.status, Status::Good, "{tone:?} {fit:?}");
            assert!(
                (fit.frequency as f64 - tone.frequency).abs() < 5.0 * fit.sigma as f64,
                "{tone:?} {fit:?}"
            );
        }
    }
}

#[test]
fn bad_channels_do_not_hurt() {
    let tone = Tone {
        noise: 100.0,
        ..Tone::default()
    };
    let clean = fit_whole(&tone.values(), 1);
    let mut values = tone.values();
    let loud = Tone {
        amplitude: 0.0,
        noise: 1e6,
        seed: 77,
        ..Tone::default()
    }
    .values();
    for (frame, loud) in values.iter_mut().zip(&loud) {
        frame[3] = loud[3];
        frame[9] = 8_388_607.0;
    }
    // Taxel 12 was at the rail for an eighth of the window, taxel 13 for three frames.
    let mut valid = vec![u16::MAX; values.len()];
    valid[40..70].fill(!(1 << 12));
    valid[90..93].fill(!(1 << 13));
    let fit = fit(&values, &valid, 1);
    assert_eq!(fit.status, Status::Good);
    assert_eq!(fit.usable, !(1 << 9 | 1 << 12));
    assert_eq!(fit.frames, 238);
    // Thirteen channels instead of sixteen.
    let expected = (16f32 / 13.0).sqrt();
    assert!(
        (fit.sigma / clean.sigma / expected - 1.0).abs() < 0.1,
        "{} {}",
        fit.sigma,
        clean.sigma
    );
    assert!((fit.frequency as f64 - tone.frequency).abs() < 4.0 * fit.sigma as f64);
}

#[test]
fn missing_frames_and_drift_do_not_bias() {
    for seed in 0..20 {
        let tone = Tone {
            noise: 50.0,
            seed,
            ..Tone::default()
        };
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
        assert_eq!(fit.status, Status::Good, "{fit:?}");
        assert_eq!(
            fit.frames as usize,
            valid.iter().filter(|v| **v != 0).count()
        );
        assert!(
            (fit.frequency as f64 - tone.frequency).abs() < 4.0 * fit.sigma as f64,
            "{fit:?}"
        );
    }
}

/// Across a gap the lines of a comb can be large and cancel each other: a comb at a third of the
/// tone must not be taken for one.
#[test]
fn a_gap_makes_no_subharmonic() {
    for (frequency, frames, gap) in [
        (4.3 / 121.0, 121, 30..70),
        (4.3 / 121.0, 121, 40..90),
        (3.3 / 241.0, 241, 80..170),
    ] {
        for seed in 0..20 {
            let tone = Tone {
                frequency,
                frames,
                noise: 100.0,
                seed,
                ..Tone::default()
            };
            let mut valid = vec![u16::MAX; frames];
            valid[gap.clone()].fill(0);
            let fit = fit(&tone.values(), &valid, 4);
            let off = (fit.frequency as f64 - frequency).abs();
            assert!(
                fit.status != Status::Good || off < 6.0 * fit.sigma as f64,
                "{tone:?} {fit:?}"
            );
        }
    }
}

/// Two frames, each without another taxel, are left out; the taxels stay.
#[test]
fn half_a_frame_is_left_out() {
    let tone = Tone::default();
    let mut valid = vec![u16::MAX; tone.frames];
    valid[50] = 0x00ff;
    valid[60] = 0xff00;
    let fit = fit(&tone.values(), &valid, 1);
    assert_eq!(
        (fit.status, fit.usable, fit.frames),
        (Status::Good, u16::MAX, 239)
    );
}

/// A drift that outweighs a fast tone hides it from the search on means, not from the frames'.
#[test]
fn a_fast_tone_on_a_drift_is_found() {
    let tone = Tone {
        frequency: 35.0 / 241.14,
        frames: 241,
        amplitude: 300.0,
        noise: 20.0,
        ..Tone::default()
    };
    let mut values = tone.values();
    for (n, frame) in values.iter_mut().enumerate() {
        let drift = 1400.0 * (-(n as f32) / 80.0).exp();
        frame.iter_mut().for_each(|value| *value += drift.round());
    }
    let fit = fit_whole(&values, 4);
    assert_eq!(fit.status, Status::Good, "{fit:?}");
    assert!(
        (fit.frequency as f64 / tone.frequency - 1.0).abs() < 1e-3,
        "{fit:?}"
    );
}
