//! Tests every scan plan on the register model. Each is set by a request, with its default windows
//! and four harmonics, and runs for three touches with a slide each.

mod common;

use common::{BOARDS, Run, health, hello};
use hal_mock::{Repeated, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Start};
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Health, Span, Status};

/// Time with a plan: three touches of [`scene`], of which the first begins within a second.
const SECONDS: u32 = 20;

/// A stroke of 60 mm at 200 mm/s over a grating: 200 Hz for 0.3 s, and 400 Hz where the overtones
/// do not alias.
fn scene(plan: &Plan) -> Sliding {
    match *plan {
        Plan::PAPER => Sliding::default(),
        Plan::HAND => Sliding {
            speed_mm_s: 200.0,
            period_mm: 1.0,
            ..Sliding::default()
        },
        _ => Sliding {
            speed_mm_s: 200.0,
            period_mm: 0.5,
            ..Sliding::default()
        },
    }
}

struct Did {
    last: Health,
    loads: Vec<f32>,
    good: usize,
    slides: usize,
    missing: u32,
}

fn run_plan(board: Board, plan: Plan, seconds: u32) -> Did {
    let scene = scene(&plan);
    let frequency_hz = scene.speed_mm_s / scene.period_mm;
    let scene = Repeated(SlidingScene::new(scene).expect("a scene"));
    let mut run = Run::new(board, scene, Start::default());
    run.run_to(1.0, hello);
    let settings = Settings::DEFAULT.with_plan(plan);
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
    run.run_s(0.1);
    let before = run.events.len();
    let lost_before = run.emulator.adc().counters().lost;
    for _ in 0..seconds {
        run.run_s(1.0);
        run.emulator.take_readings();
    }
    run.assert_rules();
    assert!(
        run.emulator.resets().is_empty(),
        "{:?}",
        run.emulator.resets()
    );
    let counters = run.emulator.adc().counters();
    assert_eq!(
        counters.lost, lost_before,
        "{board:?}, {plan:?}: {counters:?}"
    );
    let registers = run.emulator.adc().registers();
    assert_eq!(
        registers[..9],
        Ads1258Plan::of(&plan).config().registers().expect("a plan")
    );
    let events = &run.events[before..];
    let healths: Vec<Health> = events.iter().filter_map(health).collect();
    let last = *healths.last().expect("health");
    let loads = healths.iter().map(|health| health.load).collect();
    let (mut good, mut whole, mut slides) = (0, 0, 0);
    for event in events {
        match event {
            Event::Estimate(one) if one.status == Status::Good => {
                let off = (f64::from(one.frequency) - frequency_hz).abs() / f64::from(one.sigma);
                assert!(off < 6.0, "{plan:?}: {frequency_hz} Hz: {one:?}");
                if one.span == Span::Slide {
                    assert_eq!(one.channels.len(), plan.channels(), "{plan:?}");
                    whole += 1;
                }
                good += 1;
            }
            Event::Slide(slide) if slide.end_us.is_some() => slides += 1,
            Event::Fault(fault) => panic!("{plan:?}: {fault:?}"),
            _ => {}
        }
    }
    assert!(whole > 0, "{plan:?}: no whole slide is good");
    Did {
        last,
        loads,
        good,
        slides,
        missing: run.missing(),
    }
}

fn check(board: Board, name: &str, plan: Plan, seconds: u32) {
    let Did {
        last,
        loads,
        good,
        slides,
        missing,
    } = run_plan(board, plan, seconds);
    let mean = loads.iter().sum::<f32>() / loads.len() as f32 * 100.0;
    let max = loads.iter().fold(0.0f32, |max, load| max.max(*load)) * 100.0;
    let stack = (last.stack_used_bytes, last.stack_bytes);
    println!(
        "{board:?}, {name}: load {mean:.1} % on the average, {max:.1} % in its busiest second; {slides} slides, {good} \
         good estimates; stack {stack:?}; {:.2} frames/s",
        last.frame_rate_hz
    );
    assert_eq!(
        (last.conversions_lost, last.messages_dropped, missing),
        (0, 0, 0),
        "{name}: {last:?}"
    );
    // A whole slide that is due ends the fit of a window.
    assert!(last.overruns as usize <= slides, "{name}: {last:?}");
    assert_eq!(
        (last.chip_restarts, last.faults.iter().sum::<u32>()),
        (0, 0),
        "{name}: {last:?}"
    );
    assert!(
        (last.frame_rate_hz / plan.frame_rate_hz() - 1.0).abs() < 1e-3,
        "{name}: {last:?}"
    );
    assert!(
        (last.supply_v - 5.0).abs() < 0.01 && (last.reference_v - 4.096).abs() < 0.01,
        "{name}: {last:?}"
    );
    assert!(
        slides as u32 >= seconds / 7 && good as u32 >= seconds / 7,
        "{name}: {slides} slides, {good} estimates"
    );
    assert!(
        last.stack_used_bytes + 1024 <= last.stack_bytes,
        "{name}: {last:?}"
    );
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn each_plan_finds_a_tone_and_loses_nothing_in_three_touches() {
    // Run each board on a separate core.
    std::thread::scope(|scope| {
        for board in BOARDS {
            scope.spawn(move || {
                Plan::usual(Converters::ADS1258)
                    .for_each(|(name, plan)| check(board, name, plan, SECONDS))
            });
        }
    });
}

/// Returns the kinds of events of the demo's touch with the plan `hand`, without raw frames, the
/// last `health` and the number of missing packets.
fn touch(raw_frames: u32) -> (Vec<&'static str>, Health, u32) {
    let mut run = Run::sliding(Board::FeatherF405);
    run.run_to(1.0, hello);
    let settings = Settings::DEFAULT.with_plan(Plan::HAND);
    let keep = false;
    for (number, command) in [
        (1, Command::Set { settings, keep }),
        (2, Command::Raw { frames: raw_frames }),
    ] {
        assert_eq!(run.command(number, command), Outcome::Done);
    }
    run.run_s(6.5);
    let kinds = run.events.iter().filter_map(|event| match event {
        Event::Contact(_) => Some("contact"),
        Event::Slide(slide) if slide.end_us.is_none() => Some("slide"),
        Event::Slide(_) => Some("slide's end"),
        Event::Estimate(estimate) if estimate.span == Span::Slide => Some("whole slide"),
        Event::Estimate(_) => Some("window"),
        Event::Image(_) => Some("image"),
        Event::Texture(_) => Some("texture"),
        Event::Release(_) => Some("release"),
        _ => None,
    });
    let last = run.events.iter().filter_map(health).next_back();
    (kinds.collect(), last.expect("health"), run.missing())
}

/// The line can carry only some 1,100 of 1,459 frames a second. The excess must be thinned out, and
/// nothing else lost.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn raw_frames_that_do_not_fit_cost_no_event() {
    let (alone, without, _) = touch(0);
    let (beside, with, missing) = touch(u32::MAX);
    assert_eq!(without.frames_thinned, 0);
    assert!(alone.contains(&"release") && alone.contains(&"whole slide"));
    // Windows are skipped if the line takes time from the fit.
    let events = |kinds: &[&'static str]| -> Vec<_> {
        let is_event = |kind: &&&str| !["window", "texture"].contains(*kind);
        kinds.iter().filter(is_event).copied().collect()
    };
    assert_eq!(events(&beside), events(&alone));
    assert_eq!((with.messages_dropped, missing), (0, 0), "{with:?}");
    let thinned = with.frames_thinned as f32 / with.frames as f32;
    assert!((0.1..0.35).contains(&thinned), "{with:?}");
}
