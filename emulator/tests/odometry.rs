//! A robot streams its place 250 times a second while the chip scans and its finger goes to and
//! fro: nothing is lost.

mod common;

use common::{Run, estimates, health, hello};
use hal_mock::{Hand, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Start};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::odometry::{Odometry, Reading};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Abscissa, Status};
use std::f64::consts::TAU;

/// From one message to the next, seconds.
const STEP_S: f64 = 0.004;

/// Runs a hand over a grating with a plan, with or without a robot; gives the load of its busiest
/// second.
fn run_plan(name: &str, plan: Plan, hand: Hand, period_mm: f64, streams: bool) -> f32 {
    let scene = SlidingScene::new(Sliding {
        period_mm,
        hand: Some(hand),
        ..Sliding::default()
    })
    .expect("a scene");
    let truth = scene.truth();
    let mut run = Run::new(Board::FeatherF405, scene, Start::default());
    run.run_to(1.0, hello);
    // A fit along a way takes longer than the default stride, and where it is slower than the ring its
    // frames are gone.
    let defaults = Settings::DEFAULT.with_plan(plan);
    let settings = if streams {
        Settings {
            window_s: if plan == Plan::PAPER { 1.0 } else { 0.15 },
            stride_s: 0.5,
            ..defaults
        }
    } else {
        defaults
    };
    if settings != Settings::DEFAULT {
        assert_eq!(
            run.command(
                1,
                Command::Set {
                    settings,
                    keep: false
                }
            ),
            Outcome::Done
        );
    }
    let zero_ns = run.emulator.adc().scene_zero_ns().expect("the chip scans");
    let mut sent = 0u32;
    loop {
        let t_s = (run.emulator.now_ns() - zero_ns) as f64 * 1e-9;
        if t_s > truth.end_s - 0.2 {
            break;
        }
        if streams {
            let since_s = (t_s - truth.slide_start_s).clamp(0.0, hand.swings / hand.swing_hz);
            let mm = hand.peak_mm_s / (TAU * hand.swing_hz)
                * (1.0 - (TAU * hand.swing_hz * since_s).cos());
            // A clock of its own, slower by 100 ppm.
            let t_us = (4.29e9 + t_s * 1e6 * (1.0 - 100e-6)) as u64 as u32;
            let reading = Reading::Place((mm * 1e4).round() as i32);
            run.emulator.send(
                &Odometry {
                    number: sent as u16,
                    t_us,
                    reading,
                }
                .encode(),
            );
            sent += 1;
        }
        run.run_s(STEP_S);
        run.emulator.take_readings();
    }
    run.run_s(1.1);
    run.assert_rules();
    let healths: Vec<_> = run.events.iter().filter_map(health).collect();
    let last = *healths.last().expect("health");
    let most = healths
        .iter()
        .fold(0f32, |most, health| most.max(health.load));
    let fits = estimates(&run.events);
    let (mut by_place, mut good, mut worst) = (0, 0, 0f64);
    for fit in &fits {
        by_place += u32::from(fit.abscissa == Abscissa::Place);
        if (fit.abscissa, fit.status) == (Abscissa::Place, Status::Good) {
            good += 1;
            worst = worst.max((1.0 / (f64::from(fit.frequency) * period_mm) - 1.0).abs());
        }
    }
    println!(
        "{name}, {sent} messages: load {:.1} % in its busiest second, stack {} of {} bytes; {by_place} of {} windows by place, \
         {good} good, {:.2} % off at most; {:?}",
        100.0 * most,
        last.stack_used_bytes,
        last.stack_bytes,
        fits.len(),
        100.0 * worst,
        last.odometry
    );
    assert_eq!(
        (last.conversions_lost, last.messages_dropped),
        (0, 0),
        "{name}: {last:?}"
    );
    println!("{name}: {} overruns", last.overruns);
    // The fit of a whole slide may take the place of a window.
    assert!(
        last.overruns <= if streams { 2 } else { 1 },
        "{name}: {last:?}"
    );
    assert_eq!(
        (last.requests_damaged, last.bytes_overrun),
        (0, 0),
        "{name}: {last:?}"
    );
    assert!(
        last.stack_used_bytes + 1024 <= last.stack_bytes,
        "{name}: {last:?}"
    );
    let counts = last.odometry;
    assert_eq!(
        (counts.received, counts.lost, counts.late, counts.doubled),
        (sent, 0, 0, 0),
        "{name}"
    );
    if streams {
        assert_eq!(
            (counts.windows_by_time, by_place as usize),
            (0, fits.len()),
            "{name}"
        );
        assert!(good >= 5 && worst < 0.01, "{name}: {good} good, {worst}");
    } else {
        assert_eq!(by_place, 0, "{name}");
    }
    most
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_robot_costs_no_conversion_and_with_a_stride_of_half_a_second_hardly_a_window() {
    let slow = Hand {
        peak_mm_s: 60.0,
        swing_hz: 0.8,
        swings: 4.0,
    };
    for (name, plan, hand, period_mm) in [
        ("paper", Plan::PAPER, slow, 2.6),
        ("hand", Plan::HAND, Hand::default(), 1.0),
    ] {
        let without = run_plan(name, plan, hand, period_mm, false);
        let with = run_plan(name, plan, hand, period_mm, true);
        println!(
            "{name}: load {:.1} % without a robot, {:.1} % with one",
            100.0 * without,
            100.0 * with
        );
    }
}
