//! Tones of less than one cycle, close to half the frame rate, on bins and between them, and in
//! short and long windows.

use crate::case::{Case, GoodFits};
use crate::reference::Tone;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_tone::Status;

/// Tone of `cycles` cycles in `frames` frames.
fn tone(cycles: f64, frames: usize, noise: f64, seed: u64) -> Tone {
    Tone::new(cycles / frames as f64, frames, noise, seed)
}

/// Case of a tone, with at most `harmonics` harmonics in the fit.
fn case(tone: &Tone, harmonics: u8) -> Case {
    let mut case = Case::new(tone.values());
    case.harmonics = harmonics;
    case
}

/// Fewer cycles than the minimum are never good, because half a cycle resembles a curved baseline.
/// From 0.9 cycles on the frequency is right, except for what the baseline absorbs.
#[test]
fn half_a_cycle_to_one() {
    for cycles in [0.5, 0.55, 0.6, 0.65, 0.7, 0.73, 0.8, 0.9, 1.0, 1.1] {
        for noise in [10.0, 100.0] {
            for seed in 0..10 {
                let tone = tone(cycles, 241, noise, seed);
                let fit = case(&tone, 1).fit();
                let what = format!("{tone:?} {fit:?}");
                let unsure = [Status::Ambiguous, Status::NoTone, Status::TooShort];
                assert!(unsure.contains(&fit.status), "{what}");
                if cycles > 0.85 {
                    let off = f64::from(fit.frequency) / tone.frequency - 1.0;
                    assert!(fit.status.has_tone() && off.abs() < 0.1, "{what}");
                }
            }
        }
    }
}

/// A tone must be as far from half the frame rate as from zero, because closer it overlaps its
/// alias.
#[test]
fn next_to_half_the_frame_rate() {
    for frequency in [0.45, 0.47, 0.49, 0.494, 0.496, 0.498, 0.499, 0.4995, 0.4999] {
        for seed in 0..10 {
            let tone = Tone::new(frequency, 241, 50.0, seed);
            let case = case(&tone, 1);
            let fit = case.fit();
            if (0.5 - frequency) * tone.frames as f64 > 1.15 {
                assert_eq!(fit.status, Status::Good, "{tone:?} {fit:?}");
                case.assert_right_and_sure(&format!("{tone:?}"), &fit, frequency);
            } else {
                assert_ne!(fit.status, Status::Good, "{tone:?} {fit:?}");
            }
        }
    }
}

#[test]
fn on_a_bin_and_between_two() {
    let mut fits = GoodFits::default();
    for frames in [64usize, 128, 241, 256, 512] {
        // Whole and half cycles per window, and per transform, whose length is a power of two.
        for cycles in [4.0, 4.5, 7.0, 7.5, 20.0, 20.5] {
            let bins = (2 * frames).next_power_of_two() as f64 / 2.0;
            for (seed, bins) in [0, 1]
                .into_iter()
                .flat_map(|s| [(s, frames as f64), (s, bins)])
            {
                let tone = Tone::new(cycles / bins, frames, 200.0, seed);
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
        let mut settings = Settings::DEFAULT;
        settings.window_s = window_s;
        settings.validate().is_ok()
    };
    let (shortest, longest) = (0.1, 3.9);
    assert!(accepts(shortest) && !accepts(0.99 * shortest));
    assert!(accepts(longest) && !accepts(1.01 * longest));
    // `min` is the minimum fraction of good windows: low where a good fit cannot be expected, as
    // with 24 frames for fifteen unknowns.
    for (window_s, cycles, carried, max, min) in [
        (shortest, 1.0, 1, 1, 0.0),
        (shortest, 1.3, 1, 4, 0.95),
        (shortest, 2.4, 2, 5, 0.5),
        (shortest, 4.3, 1, 5, 0.9),
        (shortest, 9.7, 1, 5, 0.95),
        (longest, 1.2, 1, 4, 0.0),
        (longest, 1.5, 1, 4, 0.95),
        (longest, 3.3, 4, 5, 0.95),
        (longest, 59.4, 4, 5, 0.95),
        (longest, 411.7, 1, 5, 0.95),
    ] {
        let mut good = 0;
        for seed in 0..20 {
            let mut tone = tone(cycles, frames_of(window_s), 50.0, seed);
            tone.harmonics = carried;
            let case = case(&tone, max);
            let fit = case.fit();
            if fit.status == Status::Good {
                good += 1;
                assert!(cycles > 1.15, "{tone:?} {fit:?}");
                case.assert_right(&format!("{tone:?}"), &fit, tone.frequency);
                assert_eq!(fit.harmonics as usize, carried, "{tone:?} {fit:?}");
            }
        }
        assert!(
            f64::from(good) >= 20.0 * min,
            "{window_s} s, {cycles} cycles: {good} of 20 are good"
        );
    }
}
