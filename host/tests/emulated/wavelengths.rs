//! Gratings under a hand's speed and a hand's swings with the plan `hand`, in the emulator and by
//! the library on this PC: the same answers, bit for bit. What docs/results/papers-runs.md measures with
//! the library is so what the image measures.

use hal_mock::{Finger, Hand, Sliding, SlidingScene};
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::Input;
use ridgetone_host::odometry::{Stream, message};
use ridgetone_proto::odometry::{FRAME_BYTES, WIRE_BYTES};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Abscissa, Estimate, Event, Packet, Span, Status};
use std::f64::consts::TAU;

/// The mean of a hand's speed (Okamoto et al., section IV-A), mm/s.
const SPEED_MM_S: f64 = 125.4;

/// A conversion takes 197 us with the default plan and 43 us with `hand`.
const QUICK_US: u32 = 100;

fn estimate(event: &Event) -> Option<Estimate> {
    // The device's time begins with its first conversion, which is another on the PC.
    if let Event::Estimate(estimate) = event {
        Some(Estimate {
            t_us: 0,
            ..estimate.clone()
        })
    } else {
        None
    }
}

/// Messages of the robot in a second (section III-C), how long one is on the line, seconds, and how
/// late the finger feels a place: the bridges' low-pass of 0.41 ms and half of the converter's
/// filter of 0.04 ms. All as `cargo xtask reproduce --wavelengths` has them.
const MESSAGES_HZ: f64 = 250.0;
const ON_THE_LINE_S: f64 = WIRE_BYTES as f64 * 10.0 / 921_600.0;
const FELT_LATE_S: f64 = 0.5 * 820e-6 + 64.0 * 5.0 / 15_728_640.0;

/// When the robot begins to stream, seconds of scene time: the settings are in force.
const ROBOT_FROM_S: f64 = 0.9;

/// A grating with ridges as wide as its grooves, under a skin with ridges of a width, or with none.
fn grating(period_mm: f64, skin_ridge_mm: f64) -> Sliding {
    let (ridge_mm, hold_before_s, hold_after_s) = (0.5 * period_mm, 0.6, 0.5);
    let finger = Some(Finger {
        skin_ridge_mm,
        ..Finger::default()
    });
    Sliding {
        period_mm,
        ridge_mm,
        hold_before_s,
        hold_after_s,
        finger,
        ..Sliding::physical()
    }
}

/// The image's estimates. They are those of the library from the same conversions and messages, but
/// for one at most that the image had no time for: it leaves that out and counts it.
fn as_on_the_pc(scene: Sliding, settings: Settings, odometry: &Stream) -> Vec<Estimate> {
    let elf = emulator::image::find().expect("an image");
    let input = Input {
        scene,
        ..Input::default()
    };
    let (mut on_chip, mut skipped) = (Vec::new(), 0);
    let mut sink = |packet: &Packet| {
        on_chip.extend(estimate(&packet.event));
        if let Event::Health(health) = &packet.event {
            skipped = health.overruns;
        }
        Ok(())
    };
    let options = Options {
        settings,
        odometry,
        keep_conversions: true,
        ..Options::new(&elf)
    };
    let opened = input.open_in(&Plan::HAND).expect("an input");
    let outcome = emulator::run(opened, options, &mut sink, &mut |_, _| {}).expect("a run");
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0)
    );
    assert_eq!(outcome.heard.len(), odometry.len());
    // The very conversions, from where the plan is in force: the image begins with the default
    // plan, whose conversions last longer.
    let is_quick = |pair: &[TimedConversion]| pair[1].t_us.wrapping_sub(pair[0].t_us) < QUICK_US;
    let first = outcome
        .conversions
        .windows(2)
        .position(is_quick)
        .expect("the plan's conversions");
    let in_force_s =
        f64::from(outcome.conversions[first].t_us) * 1e-6 - outcome.start_us as f64 * 1e-6;
    assert!(
        odometry.is_empty() || in_force_s < ROBOT_FROM_S - 0.1,
        "{in_force_s} s"
    );
    let (mut pipeline, mut on_pc) = (Box::new(Pipeline::new(settings)), Vec::new());
    let mut heard = outcome
        .heard
        .into_iter()
        .map(|(at_us, frame)| (at_us + outcome.start_us, frame))
        .peekable();
    for timed in &outcome.conversions[first..] {
        while let Some((at_us, mut frame)) = heard.next_if(|(at_us, _)| *at_us < timed.t_us.into())
        {
            pipeline.hear(&mut frame, at_us as u32);
        }
        pipeline.push(*timed, &mut |event| on_pc.extend(estimate(&event)));
    }
    pipeline.finish(&mut |event| on_pc.extend(estimate(&event)));
    let mut others = on_pc.iter();
    assert!(
        on_chip.iter().all(|one| others.any(|other| one == other)),
        "{on_chip:?} {on_pc:?}"
    );
    assert_eq!(
        on_pc.len() - on_chip.len(),
        skipped as usize,
        "{on_chip:?} {on_pc:?}"
    );
    assert!(skipped <= 1, "{skipped}");
    on_chip
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn gratings_under_a_hands_speed_are_those_of_the_pc_bit_for_bit() {
    // Windows of the paper's length, and those that an accuracy of 0.5 % needs; a smooth skin, and
    // one with ridges.
    for (wavelength_mm, skin_ridge_mm, window_s, accuracy) in [
        (0.8, 0.0, 0.128, 0.005),
        (1.6, 0.0, 0.032, 0.0),
        (2.5, 0.0, 0.128, 0.005),
        (1.4, 0.6, 0.032, 0.0),
    ] {
        let scene = Sliding {
            speed_mm_s: SPEED_MM_S,
            slide_mm: 300.0,
            ..grating(wavelength_mm, skin_ridge_mm)
        };
        let harmonics = if skin_ridge_mm > 0.0 { 4 } else { 2 };
        let settings = Settings {
            window_s,
            harmonics,
            accuracy,
            ..Settings::DEFAULT.with_plan(Plan::HAND)
        };
        let on_chip = as_on_the_pc(scene, settings, &Stream::new());

        let frequency_hz = SPEED_MM_S / wavelength_mm;
        let windows = on_chip
            .iter()
            .filter(|one| one.span == Span::Window && one.status == Status::Good)
            // Where the hand starts and stops its speed is another.
            .filter(|one| one.movement.wander < 0.05);
        // Windows of two cycles have a standard deviation of 3 %.
        let good = windows.inspect(|one| {
            let off_hz = (f64::from(one.frequency) - frequency_hz).abs();
            let min_hz = 0.015 * frequency_hz;
            assert!(off_hz < min_hz.max(3.0 * f64::from(one.sigma)), "{one:?}")
        });
        assert!(good.count() >= 5, "{wavelength_mm} mm: {on_chip:?}");
    }
}

/// The places of a hand as a robot streams them, those that the finger feels at the stamps.
fn places(scene: &Sliding, hand: Hand) -> Stream {
    let truth = SlidingScene::new(scene.clone()).expect("a scene").truth();
    let lasts_s = truth.slide_end_s - truth.slide_start_s;
    let message_at = |number: usize| {
        let t_s = number as f64 / MESSAGES_HZ;
        let since_s = (t_s - FELT_LATE_S - truth.slide_start_s).clamp(0.0, lasts_s);
        let mm =
            hand.peak_mm_s / (TAU * hand.swing_hz) * (1.0 - (TAU * hand.swing_hz * since_s).cos());
        let frame = message(number, t_s, mm, true).encode()[..FRAME_BYTES].to_vec();
        (((t_s + ON_THE_LINE_S) * 1e6).round() as u64, frame)
    };
    // The settings come by the same line, whose bytes would be mixed with theirs. The last ones
    // have to be complete before the scene's end.
    let numbers =
        (ROBOT_FROM_S * MESSAGES_HZ) as usize..((truth.end_s - 0.1) * MESSAGES_HZ) as usize;
    numbers.map(message_at).collect()
}

/// The stride is twice the plan's own: by place the image may leave one of the first windows out. Where a window's length follows from the estimate before it, the next
/// one then is another than on the PC.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn gratings_under_a_hands_swings_are_those_of_the_pc_bit_for_bit() {
    let hand = Hand::default();
    for (wavelength_mm, skin_ridge_mm, window_s, accuracy) in [
        (1.0, 0.0, 0.128, 0.005),
        (2.0, 0.0, 0.032, 0.0),
        (1.4, 0.6, 0.032, 0.0),
    ] {
        let scene = Sliding {
            hand: Some(hand),
            idle_s: 1.0,
            ..grating(wavelength_mm, skin_ridge_mm)
        };
        let stream = places(&scene, hand);
        let harmonics = if skin_ridge_mm > 0.0 { 4 } else { 2 };
        let settings = Settings {
            window_s,
            stride_s: 0.3,
            harmonics,
            accuracy,
            ..Settings::DEFAULT.with_plan(Plan::HAND)
        };
        let on_chip = as_on_the_pc(scene, settings, &stream);

        assert!(
            on_chip.iter().all(|one| one.abscissa == Abscissa::Place),
            "{wavelength_mm} mm: {on_chip:?}"
        );
        let windows: Vec<_> = on_chip
            .iter()
            .filter(|one| one.span == Span::Window)
            .collect();
        let good = windows.iter().filter(|one| one.status == Status::Good);
        let off = |one: &Estimate| (1.0 / (f64::from(one.frequency) * wavelength_mm) - 1.0).abs();
        let good = good
            .inspect(|one| assert!(off(one) < 0.02, "{one:?}"))
            .count();
        println!(
            "{wavelength_mm} mm: {good} of {} windows are good",
            windows.len()
        );
        // Where the hand turns, a window has no frequency that it can promise.
        assert!(2 * good >= windows.len(), "{wavelength_mm} mm: {on_chip:?}");
    }
}
