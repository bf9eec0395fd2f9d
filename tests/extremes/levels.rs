//! Unusual levels and channels: rails, full scale, a millionth of it, stuck, clipped, dead.

use crate::case::Case;
use crate::reference::{Noise, Tone, codes};
use ridgetone_tone::Status;
use std::f64::consts::TAU;

/// Greatest code that the chip does not clip.
const RAIL: f64 = 8_388_606.0;
const FREQUENCY: f64 = 0.0346;
const FRAMES: usize = 241;

/// Tone on an offset, in noise; `channel` returns amplitude, offset and noise of a channel.
fn window(seed: u64, channel: impl Fn(usize) -> (f64, f64, f64)) -> Vec<[f32; 16]> {
    let mut noise = Noise::new(seed);
    codes(FRAMES, |c, t| {
        let (amplitude, offset, sigma) = channel(c);
        (offset + amplitude * (TAU * FREQUENCY * t + c as f64).sin() + sigma * noise.next())
            .clamp(-RAIL, RAIL)
    })
}

#[test]
fn ten_codes_at_the_rail() {
    for seed in 0..10 {
        let offset = |c| if c % 2 == 0 { RAIL - 20.0 } else { 20.0 - RAIL };
        let values = window(seed, |c| (10.0, offset(c), 2.0));
        Case::new(values).assert_good("ten codes", FREQUENCY);
    }
}

#[test]
fn full_scale() {
    for snr_db in [10, 20, 40, 50] {
        let noise = RAIL * (0.5 / 10f64.powf(0.1 * snr_db as f64)).sqrt();
        for seed in 0..5 {
            // Strong noise is clipped at the rail, and harmonics fit part of the tone's distortion.
            let values = window(seed, |_| (RAIL, 0.0, noise));
            Case::new(values).assert_good(&format!("full scale, {snr_db} dB"), FREQUENCY);
        }
    }
}

/// Function that returns amplitude, offset and noise of a channel.
type Kind<'a> = &'a dyn Fn(usize) -> (f64, f64, f64);

/// From 60 dB on, the Cramer-Rao bound is near the resolution of f32. The frequency must be right
/// to that resolution, and sigma must show it. If one channel has nearly all of the information,
/// its noise is estimated from few bins, so sigma scatters.
#[test]
fn what_f32_cannot_hold_is_reported() {
    let strongest = |c: usize| 4e6 * 1e-6f64.powf(c as f64 / 15.0);
    let kinds: [(&str, Kind); 4] = [
        ("60 dB", &|_| (RAIL, 0.0, 6000.0)),
        ("92 dB in one channel", &|c| {
            (strongest(c), 1000.0 * c as f64, 100.0)
        }),
        ("120 dB", &|_| (RAIL, 0.0, 6.0)),
        ("no noise", &|_| (RAIL, 0.0, 0.0)),
    ];
    for (what, channel) in kinds {
        let mut sigmas = Vec::new();
        for seed in 0..21 {
            let fit = Case::new(window(seed, channel)).fit();
            assert_eq!(fit.status, Status::Good, "{what}: {fit:?}");
            let off = (f64::from(fit.frequency) - FREQUENCY).abs() / FREQUENCY;
            let sigma = f64::from(fit.sigma) / FREQUENCY;
            assert!(off < 4.0 * sigma, "{what}: {off} {sigma}");
            sigmas.push(sigma);
        }
        sigmas.sort_by(f64::total_cmp);
        assert!(sigmas[10] < 2e-6, "{what}: {sigmas:?}");
    }
}

#[test]
fn amplitudes_a_million_apart() {
    let amplitude = |c: usize| 4e6 * 1e-6f64.powf(c as f64 / 15.0);
    for seed in 0..5 {
        // First with equal SNR in all channels, then with equal noise.
        let noise = |c| (0.1 * amplitude(c)).max(0.5);
        let values = window(seed, |c| (amplitude(c), 1000.0 * c as f64, noise(c)));
        Case::new(values).assert_good("each in its own noise", FREQUENCY);
        let values = window(seed, |c| (amplitude(15 - c), 1000.0 * c as f64, 40_000.0));
        Case::new(values).assert_good("all in the same noise", FREQUENCY);
    }
}

#[test]
fn all_zero_is_nothing() {
    for value in [0.0, 1.0, RAIL as f32] {
        let fit = Case::new(vec![[value; 16]; FRAMES]).fit();
        assert_eq!((fit.status, fit.usable), (Status::Nothing, 0));
    }
}

#[test]
fn stuck_clipped_at_the_rail() {
    for seed in 0..5 {
        let tone = Tone::new(0.0346, 241, 50.0, seed);
        let mut case = Case::new(tone.values());
        let offset = tone.channel(7).offset as f32;
        let held = case.values[100][11];
        for (n, frame) in case.values.iter_mut().enumerate() {
            frame[3] = -1234.0;
            frame[7] = frame[7].clamp(offset - 500.0, offset + 500.0);
            frame[9] = RAIL as f32 + 1.0;
            // Stuck for the rest of the window.
            if n > 100 {
                frame[11] = held;
            }
        }
        // The chip marks a taxel at the rail as invalid, but a table has no such mark.
        for invalid in [0, 1 << 9] {
            case.valid.fill(!invalid);
            let fit = case.fit();
            // Sigma covers the loss of the broken channels.
            assert_eq!(fit.status, Status::Good, "{fit:?}");
            // Taxel 7 is clipped by its own tone in a third of the frames, and is still fitted.
            assert_eq!(fit.usable, !(1 << 3 | 1 << 9));
            let off = (fit.frequency as f64 - tone.frequency).abs();
            assert!(off < 5.0 * fit.sigma as f64, "{fit:?}");
        }
    }
}

#[test]
fn one_channel_is_left() {
    for seed in 0..5 {
        for (what, noise) in [("constant", 0.0), ("noise", 100.0)] {
            let values = window(seed, |c| {
                if c == 6 {
                    (1000.0, 5e6, 100.0)
                } else {
                    (0.0, -3e6, noise)
                }
            });
            let case = Case::new(values);
            let fit = case.assert_good(what, FREQUENCY);
            assert_eq!(fit.usable, if noise > 0.0 { u16::MAX } else { 1 << 6 });
            let off = (fit.frequency as f64 - FREQUENCY).abs();
            assert!(off < 5.0 * fit.sigma as f64, "{what}: {fit:?}");
        }
        // All other channels are marked invalid.
        let mut case = Case::new(window(seed, |_| (1000.0, 5e6, 100.0)));
        case.valid.fill(1 << 6);
        assert_eq!(case.assert_good("one valid", FREQUENCY).usable, 1 << 6);
    }
}
