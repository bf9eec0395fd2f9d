//! Tests any number of channels, any unit and any frame rate.

use ridgetone_tone::{
    Fit, Fitter, FrameSource, FrameSpan, Frames, Overwritten, Scene, Status, Table,
};

mod common;

#[allow(dead_code, reason = "its main is for cargo run --example")]
#[path = "../examples/eight_channels.rs"]
mod eight_channels;

const FREQUENCY_HZ: f32 = 23.4;

/// Frames at 500 Hz: a tone, and as noise a disturbance at much higher frequencies.
fn frames(channels: usize, count: usize, unit: f32) -> Vec<f32> {
    let sample = |i: usize| {
        let (t_s, channel) = ((i / channels) as f32 / 500.0, i % channels);
        let noise = ((i * 7919 + channel * 104_729) % 1000) as f32 / 1000.0 - 0.5;
        let tone = (core::f32::consts::TAU * FREQUENCY_HZ * t_s + channel as f32).sin();
        ((1000.0 * (1.5 + 0.2 * tone + 0.02 * noise)).round() + 100.0 * channel as f32) * unit
    };
    (0..channels * count).map(sample).collect()
}

fn fit(values: &[f32], channels: usize) -> Fit {
    common::fit_scene(values, channels, &Scene::with_harmonics(3), |span| {
        span.with_frame_rate(500.0)
    })
}

fn assert_tone(fit: &Fit, channels: usize) {
    assert_eq!(fit.status, Status::Good, "{channels} channels");
    assert_eq!(fit.usable.count_ones() as usize, channels);
    assert!(
        (fit.frequency - FREQUENCY_HZ).abs() < 5.0 * fit.sigma,
        "{} +- {} Hz",
        fit.frequency,
        fit.sigma
    );
    assert!(fit.sigma < 0.05, "{} Hz", fit.sigma);
}

#[test]
fn the_example_finds_its_tone_in_hertz() {
    let fit = eight_channels::fit(&frames(8, 400, 1e-3)).unwrap();
    assert_tone(&fit, 8);
    assert!((fit.channels[7].amplitude - 0.2).abs() < 0.01);
}

#[test]
fn from_one_channel_to_sixteen() {
    for channels in 1..=16 {
        assert_tone(&fit(&frames(channels, 400, 1.0), channels), channels);
    }
    assert!(Frames::new(&[], 0).is_none() && Frames::new(&[], 17).is_none());
}

#[test]
fn another_unit_gives_the_same_frequency_to_the_last_bit() {
    // Scaling by a power of two is exact.
    for unit in [2f32.powi(-30), 2f32.powi(10)] {
        let (of_unit, of_one) = (fit(&frames(8, 300, unit), 8), fit(&frames(8, 300, 1.0), 8));
        assert_eq!(
            (of_unit.frequency, of_unit.sigma),
            (of_one.frequency, of_one.sigma)
        );
        assert_eq!(
            of_unit.channels[3].amplitude,
            of_one.channels[3].amplitude * unit
        );
    }
}

#[test]
fn a_value_that_is_not_finite_is_a_gap() {
    let mut values = frames(4, 400, 1.0);
    values[4 * 17 + 2] = f32::NAN;
    let with_gap = fit(&values, 4);
    assert_tone(&with_gap, 4);
    assert_eq!(with_gap.frames, 399);
}

#[test]
fn frames_and_a_table_give_the_same_fit() {
    let values = frames(16, 300, 1.0);
    let table: Vec<[f32; 16]> = values.as_chunks().0.to_vec();
    let mut table = Table {
        values: &table,
        valid: &[u16::MAX; 300],
    };
    let of_table = Fitter::new()
        .fit(
            &mut FrameSpan::new(&mut table, 0, 300).with_frame_rate(500.0),
            &Scene::with_harmonics(3),
        )
        .unwrap();
    assert_eq!(of_table.frequency, fit(&values, 16).frequency);
}

#[test]
fn frames_that_are_gone_are_an_error() {
    let mut frames = Frames::new(&[1.0; 40], 4).unwrap();
    assert_eq!(
        frames.read(10, 1, &mut |_, _| panic!("nothing to show")),
        Err(Overwritten)
    );
    assert_eq!(
        Fitter::new()
            .fit(
                &mut FrameSpan::new(&mut frames, 0, 20),
                &Scene::with_harmonics(3)
            )
            .map(|_| ()),
        Err(Overwritten)
    );
    assert_eq!(
        Overwritten.to_string(),
        "newer frames have overwritten those of the window"
    );
}

/// Returns eight channels of a tone and noise at 500 Hz; `shared` is the gain of a common
/// disturbance.
fn noisy(frequency_hz: f32, count: usize, seed: u64, shared: f32) -> Vec<f32> {
    let mut normal = common::normal(seed);
    let mut normal = || normal() as f32;
    let mut out = Vec::new();
    for i in 0..count {
        let disturbance = shared * normal();
        for channel in 0..8 {
            let turns = frequency_hz * i as f32 / 500.0;
            let tone = 10.0 * (core::f32::consts::TAU * turns + 2.4 * channel as f32).sin();
            out.push(tone + normal() + (1.0 + 0.1 * channel as f32) * disturbance);
        }
    }
    out
}

/// Least squares weights an impulse of twenty standard deviations like four hundred values: with
/// one in a hundred the error would be 2.2 times as large. In a tone at a third of the frame rate,
/// third differences are as large as those of impulses of thirty standard deviations.
#[test]
fn impulses_change_little() {
    for (frequency_hz, count, square_max, own_range) in [
        (FREQUENCY_HZ, 400, 0.15, 0.6..1.6),
        (170.0, 96, 0.2, 0.5..1.6),
    ] {
        let (mut squares, mut own) = (0.0, 0.0);
        for seed in 0..40 {
            let clean = noisy(frequency_hz, count, seed, 0.0);
            let mut hit = clean.clone();
            for i in (seed as usize % 97..hit.len()).step_by(97) {
                hit[i] += if i % 2 == 0 { 20.0 } else { -20.0 };
            }
            let (clean, hit) = (fit(&clean, 8), fit(&hit, 8));
            squares += ((hit.frequency - clean.frequency) / clean.sigma).powi(2) / 40.0;
            own += ((clean.frequency - frequency_hz) / clean.sigma).powi(2) / 40.0;
            if frequency_hz == FREQUENCY_HZ {
                assert_tone(&hit, 8);
                for (hit, clean) in hit.channels.iter().zip(&clean.channels).take(8) {
                    let is_near = (hit.amplitude - clean.amplitude).abs() < 0.15;
                    let residual = hit.residual / clean.residual;
                    assert!(
                        is_near && (0.85..1.15).contains(&residual),
                        "{hit:?} {clean:?}"
                    );
                }
            }
        }
        println!("{frequency_hz} Hz: {squares:.2} {own:.2}");
        assert!(
            squares < square_max && own_range.contains(&own),
            "{squares} {own}"
        );
    }
}

/// Even a large step must not be taken for an impulse.
#[test]
fn what_is_no_impulse_is_left() {
    let mut stepped = noisy(FREQUENCY_HZ, 400, 1, 0.0);
    stepped
        .iter_mut()
        .skip(8 * 200)
        .for_each(|value| *value += 60.0);
    let fit = fit(&stepped, 8);
    let is_left = fit
        .channels
        .iter()
        .take(8)
        .all(|channel| channel.residual > 5.0);
    assert!(is_left || !fit.status.has_tone(), "{fit:?}");
}

/// A common disturbance is three times as strong as the noise. With channels treated as
/// independent, all of it would remain in the error.
#[test]
fn what_channels_share_is_taken_out() {
    let (mut alone, mut shared, mut sigma, mut good) = (0.0, 0.0, 0.0, 0);
    for seed in 0..40 {
        let mut off = |gain: f32| {
            let fit = fit(&noisy(FREQUENCY_HZ, 400, seed, gain), 8);
            good += u32::from(fit.status == Status::Good);
            (
                (fit.frequency - FREQUENCY_HZ).powi(2) / 40.0,
                fit.sigma.powi(2) / 40.0,
            )
        };
        alone += off(0.0).0;
        let (square, variance) = off(3.0);
        (shared, sigma) = (shared + square, sigma + variance);
    }
    // Projecting out one of eight directions costs an eighth of the information, and estimating it
    // costs another eighth.
    assert!(shared < 2.0 * alone, "{shared} {alone}");
    // The common disturbance inflates sigma up to twice the error.
    assert!((0.2..1.5).contains(&(shared / sigma)), "{shared} {sigma}");
    // The noise is not white, so a line of a hundredth of the tone's power stands out now and then.
    assert!(good >= 72, "{good} of 80");
}
