//! Tests gratings at a hand's speed with the plan `hand`: the emulated image and the library on
//! this PC must agree bit for bit. Results of lab/papers/okamoto.py, which uses the library,
//! therefore also apply to the image.

use hal_mock::{Finger, Sliding};
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::Input;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Span, Status};

/// Mean speed of a hand (Okamoto et al., section IV-A), mm/s.
const SPEED_MM_S: f64 = 125.4;

/// Threshold between conversions of the default plan (197 us) and of `hand` (43 us).
const QUICK_US: u32 = 100;

fn estimate(event: &Event) -> Option<Estimate> {
    // Ignore device time: it begins at the first conversion, which differs on the PC.
    if let Event::Estimate(estimate) = event {
        Some(Estimate {
            t_us: 0,
            ..estimate.clone()
        })
    } else {
        None
    }
}

/// Returns a grating whose ridges are as wide as its grooves, under a skin with or without ridges.
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

/// Returns the image's estimates. Asserts that they equal the library's from the same conversions,
/// except for at most one that the image had no time for and counted as an overrun.
fn as_on_the_pc(scene: Sliding, settings: Settings) -> Vec<Estimate> {
    let elf = emulator::image::find().expect("an image");
    let input = Input {
        scene,
        ..Input::default()
    };
    let (mut on_chip, mut skipped) = (Vec::new(), 0);
    let mut sink = |packet: &Packet, _| {
        on_chip.extend(estimate(&packet.event));
        if let Event::Health(health) = &packet.event {
            skipped = health.overruns;
        }
        Ok(())
    };
    let options = Options {
        settings,
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
    // Use the same conversions, but only from the moment when the plan applies: the image starts
    // with the default plan, whose conversions are longer.
    let is_quick = |pair: &[TimedConversion]| pair[1].t_us.wrapping_sub(pair[0].t_us) < QUICK_US;
    let first = outcome
        .conversions
        .windows(2)
        .position(is_quick)
        .expect("the plan's conversions");
    let (mut pipeline, mut on_pc) = (Box::new(Pipeline::new(settings)), Vec::new());
    for timed in &outcome.conversions[first..] {
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
    // Windows of the paper's length, or as long as an accuracy of 0.5 % requires; under a smooth
    // skin or one with ridges.
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
        let on_chip = as_on_the_pc(scene, settings);

        let frequency_hz = SPEED_MM_S / wavelength_mm;
        let windows = on_chip
            .iter()
            .filter(|one| one.span == Span::Window && one.status == Status::Good)
            // Drop windows with the hand's start or stop, where its speed differs.
            .filter(|one| one.movement.wander < 0.05)
            .collect::<Vec<_>>();
        // A short first or last window may include a start or stop too: two cycles do not show it.
        let edge = usize::from(window_s < 0.1);
        let inner = windows.get(edge..windows.len().saturating_sub(edge));
        // Windows of two cycles have a standard deviation of 3 %.
        for one in inner.unwrap_or_default() {
            let off_hz = (f64::from(one.frequency) - frequency_hz).abs();
            let min_hz = 0.015 * frequency_hz;
            assert!(off_hz < min_hz.max(3.0 * f64::from(one.sigma)), "{one:?}");
        }
        assert!(windows.len() >= 5, "{wavelength_mm} mm: {on_chip:?}");
    }
}
