//! Frequencies and windows: less than a cycle, next to half the frame rate, on and between bins,
//! short and long.

use crate::case::{Case, GoodFits};
use crate::reference::Tone;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_tone::Status;

/// A frequency of `cycles` cycles in `frames` frames.
fn tone(cycles: f64, frames: usize, noise: f64, seed: u64) -> Tone {
    Tone {
        frequency: cycles / frames as f64,
        frames,
        noise,
        seed,
        ..Tone::default()
    }
}

/// From 0.6 cycles on there is a frequency if the noise allows; below, the status is too short.
/// None is good.
#[test]
fn half_a_cycle_to_one() {
    let (mut ambiguous, mut too_short, mut wrong) = (0, 0, 0);
    for cycles in [0.5, 0.55, 0.6, 0.65, 0.7, 0.73, 0.8, 0.9, 1.0] {
        for noise in [10.0, 100.0] {
            for seed in 0..4 {
                let tone = tone(cycles, 241, noise, seed);
                let mut case = Case::new(tone.values());
                case.harmonics = 1;
                let fit = case.fit();
                match fit.status {
                    Status::Ambiguous => {
                        ambiguous += 1;
                        if cycles > 0.95 {
                            case.assert_right(&format!("{tone:?}"), &fit, tone.frequency);
                        }
                    }
                    Status::TooShort | Status::NoTone => too_short += 1,
                    other => panic!("{other:?}: {tone:?}"),
                }
                assert!(
                    cycles < 0.8 || noise > 50.0 || fit.status.has_tone(),
                    "{tone:?} {fit:?}"
                );
                // Below a cycle an ambiguous answer may be another one: a tone with as many
                // unknowns, or a drift.
                let off = (fit.frequency as f64 - tone.frequency).abs();
                let is_right = off < 5.0 * fit.sigma as f64;
                wrong += u32::from(fit.status.has_tone() && !is_right);
                assert!(
                    !fit.status.has_tone() || is_right || cycles < 0.95,
                    "{tone:?} {fit:?}"
                );
            }
        }
    }
    let counts = format!("{ambiguous} ambiguous, {wrong} of them wrong, {too_short} too short");
    assert!(
        ambiguous >= 40 && too_short >= 8 && 7 * wrong <= ambiguous,
        "{counts}"
    );
}

#[test]
fn next_to_half_the_frame_rate() {
    for frequency in [0.45, 0.47, 0.49, 0.495, 0.498, 0.499, 0.4995, 0.4999] {
        for seed in 0..4 {
            let tone = Tone {
                frequency,
                noise: 50.0,
                seed,
                ..Tone::default()
            };
            let mut case = Case::new(tone.values());
            case.harmonics = 1;
            let fit = case.fit();
            // Less than half a cycle from half the frame rate a tone is its own mirror image.
            if (0.5 - frequency) * tone.frames as f64 > 1.0 {
                assert_eq!(fit.status, Status::Good, "{tone:?} {fit:?}");
            }
            if fit.status.has_tone() {
                case.assert_right_and_sure(&format!("{tone:?}"), &fit, frequency);
            }
        }
    }
}

#[test]
fn on_a_bin_and_between_two() {
    let mut fits = GoodFits::default();
    for frames in [64, 128, 241, 256, 512] {
        // Cycles per window, and cycles per transform, which has a power of two points.
        for cycles in [4.0, 4.5, 7.0, 7.5, 20.0, 20.5] {
            for seed in 0..2 {
                let tone = tone(cycles, frames, 200.0, seed);
                let case = Case::new(tone.values());
                fits.add(&case, &format!("{tone:?}"), tone.frequency);
                let bins = (2 * frames).next_power_of_two() as f64 / 2.0;
                let tone = Tone {
                    frequency: cycles / bins,
                    ..tone
                };
                let case = Case::new(tone.values());
                fits.add(&case, &format!("{tone:?}"), tone.frequency);
            }
        }
    }
    fits.assert_sure();
}

#[test]
fn the_shortest_window_and_the_longest() {
    let frames_of = |window_s: f32| (window_s * FRAME_RATE_HZ).round() as usize;
    let accepts = |window_s| {
        Settings {
            window_s,
            ..Settings::DEFAULT
        }
        .validate()
        .is_ok()
    };
    let (shortest, longest) = (0.1, 3.9);
    assert!(
        accepts(shortest)
            && !accepts(0.99 * shortest)
            && accepts(longest)
            && !accepts(1.01 * longest)
    );
    for (window_s, cycles, carried, most) in [
        (shortest, 1.0, 1, 1),
        (shortest, 1.3, 1, 4),
        (shortest, 2.4, 2, 5),
        (shortest, 4.3, 1, 5),
        (shortest, 9.7, 1, 5),
        (longest, 1.2, 1, 4),
        (longest, 3.3, 4, 5),
        (longest, 59.4, 4, 5),
        (longest, 411.7, 1, 5),
    ] {
        for seed in 0..4 {
            let tone = Tone {
                harmonics: carried,
                ..tone(cycles, frames_of(window_s), 50.0, seed)
            };
            let case = Case {
                harmonics: most,
                ..Case::new(tone.values())
            };
            let fit = case.fit();
            // So few cycles may be a single bump, though the channels have it in different phases.
            let expected = if cycles < 1.15 {
                Status::Ambiguous
            } else {
                Status::Good
            };
            assert_eq!(fit.status, expected, "{tone:?} {fit:?}");
            case.assert_right(&format!("{tone:?}"), &fit, tone.frequency);
            assert_eq!(fit.harmonics as usize, carried, "{tone:?} {fit:?}");
        }
    }
}
