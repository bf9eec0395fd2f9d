//! Tests the firmware image in the emulator. `cargo xtask test` builds the image and runs these
//! tests.

mod common;
#[path = "emulated/live.rs"]
mod live;
#[path = "emulated/overflows.rs"]
mod overflows;
#[path = "emulated/requests.rs"]
mod requests;
#[path = "common/steady.rs"]
mod steady;
#[path = "emulated/wavelengths.rs"]
mod wavelengths;

use hal_mock::{Sliding, SlidingScene, TABLE_2, Truth, load_scene, write_csv};
use ridgetone_finger::Pipeline;
use ridgetone_host::demo;
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::frames::{Frames, Reading};
use ridgetone_host::input::{Input, SLOT_S, demo_scene, frame_rate_hz};
use ridgetone_host::names::name;
use ridgetone_host::samples::Samples;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Direction, Event, Hold, Packet, Span, Status, TravelStatus};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

fn emulate(input: &Input) -> (Outcome, Vec<Packet>) {
    let elf = emulator::image::find().expect("an image");
    let options = Options {
        keep_conversions: true,
        keep_serial: true,
        ..Options::new(&elf)
    };
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet, _| {
        packets.push(packet.clone());
        Ok(())
    };
    let input = input.open().expect("an input");
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    (outcome, packets)
}

/// Runs the library on this PC with the conversions that the board read, and returns its events.
fn on_pc(outcome: &Outcome) -> Vec<Event> {
    let (mut pipeline, mut events) = (Box::new(Pipeline::new(Settings::DEFAULT)), Vec::new());
    for timed in &outcome.conversions {
        pipeline.push(*timed, &mut |event| events.push(event));
    }
    events
}

fn events(packets: &[Packet]) -> Vec<Event> {
    packets.iter().map(|packet| packet.event.clone()).collect()
}

/// Groups events by kind, in order. Removes the processor's load and stack, the converter and the
/// greeting, which a pipeline on a PC does not have. The order between kinds may differ, because a
/// fit takes time only on the chip.
fn by_kind(events: Vec<Event>) -> BTreeMap<&'static str, Vec<Event>> {
    let mut kinds = BTreeMap::new();
    for mut event in events {
        if matches!(event, Event::Converter(_) | Event::Hello(_)) {
            continue;
        }
        if let Event::Health(health) = &mut event {
            (health.load, health.stack_used_bytes, health.stack_bytes) = (0.0, 0, 0);
        }
        let of_kind: &mut Vec<Event> = kinds.entry(name(&event)).or_default();
        of_kind.push(event);
    }
    kinds
}

/// Asserts the requirements of every run over the paper's Table 2.
fn assert_within_bars(what: &str, packets: &[Packet], outcome: &Outcome, truth: &Truth) {
    // Scene time begins when the board starts the chip, device time with the first result.
    let zero_s = (outcome.first_edge_us - outcome.start_us) as f64 / 1e6;
    let scene_s = |t_us: u64| t_us as f64 / 1e6 + zero_s;
    let (mut contacts, mut slides, mut estimates, mut holds) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for packet in packets {
        match &packet.event {
            Event::Contact(contact) => contacts.push(scene_s(contact.t_us)),
            Event::Slide(slide) => slides.extend(
                slide
                    .end_us
                    .map(|end| (scene_s(slide.start_us), scene_s(end))),
            ),
            Event::Estimate(fit) if fit.span == Span::Slide => estimates.push(fit),
            Event::Image(image) => holds.push(image.hold),
            _ => {}
        }
    }
    assert_eq!(contacts.len(), 1, "{what}: {contacts:?}");
    assert!(
        (contacts[0] - truth.contact_s).abs() < 0.020,
        "{what}: contact at {contacts:?}, {truth:?}"
    );
    assert_eq!(slides.len(), 1, "{what}: {slides:?}");
    assert!(
        (slides[0].0 - truth.slide_start_s).abs() < 0.020,
        "{what}: {slides:?}, {truth:?}"
    );
    assert!(
        (slides[0].1 - truth.slide_end_s).abs() < 0.020,
        "{what}: {slides:?}, {truth:?}"
    );
    assert_eq!(holds, [Hold::BeforeSlide, Hold::AfterSlide], "{what}");
    assert_eq!(estimates.len(), 1, "{what}: {estimates:?}");
    let off = f64::from(estimates[0].frequency) / truth.frequency_hz - 1.0;
    assert_eq!(estimates[0].status, Status::Good, "{what}");
    assert!(
        off.abs() < 0.002,
        "{what}: {} Hz, {truth:?}",
        estimates[0].frequency
    );
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0),
        "{what}"
    );
}

/// Runs `test` on all `inputs`, two at a time.
fn for_all<T: Sync>(inputs: &[T], test: impl Fn(&T) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(input) = inputs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    test(input);
                }
            });
        }
    });
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn all_of_table_2_within_its_bars_and_as_on_the_pc() {
    let scenes: Vec<Sliding> = TABLE_2
        .iter()
        .enumerate()
        .flat_map(|(number, &(speed_mm_s, period_mm))| {
            let seeds = 1..=4;
            seeds.map(move |seed| Sliding {
                speed_mm_s,
                period_mm,
                snr_db: Some(20.0),
                seed: 100 * number as u64 + seed,
                ..Sliding::default()
            })
        })
        .collect();
    assert_eq!(scenes.len(), 40);
    for_all(&scenes, |scene| {
        let what = format!(
            "{} mm/s, {} mm, seed {}",
            scene.speed_mm_s, scene.period_mm, scene.seed
        );
        let truth = SlidingScene::new(scene.clone()).expect("a scene").truth();
        let input = Input {
            scene: scene.clone(),
            seed: scene.seed,
        };
        let (outcome, packets) = emulate(&input);
        assert_within_bars(&what, &packets, &outcome, &truth);
        assert_eq!(
            by_kind(events(&packets)),
            by_kind(on_pc(&outcome)),
            "{what}: the PC gives other numbers"
        );
    });
}

/// The paper's gratings on the physical finger, with an SNR of 20 dB, windows of 1 s and no
/// declared speed: period within 1 %, speed within 1.5 %, direction never wrong. The tests for two
/// lines between those of the comb have false-alarm rates of 0.1 % each, and a false alarm affects
/// up to four overlapping windows, so four of about 170 may be ambiguous.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn period_speed_and_direction_of_table_2_without_a_given_speed() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hal-mock/scenes");
    let all: Vec<_> = (1..=10)
        .flat_map(|number| [(number, false), (number, true)])
        .collect();
    let [seen, unclear] = [const { AtomicU32::new(0) }; 2];
    for_all(&all, |&(number, reverse)| {
        let scene =
            load_scene(scenes.join(format!("c{number}.toml")), frame_rate_hz()).expect("a scene");
        let seed = 500 + 2 * number + u64::from(reverse);
        let scene = Sliding {
            snr_db: Some(20.0),
            seed,
            reverse,
            ..scene
        };
        let input = Input {
            scene: scene.clone(),
            seed,
        };
        let (outcome, packets) = emulate(&input);
        let towards = if reverse {
            Direction::Backward
        } else {
            Direction::Forward
        };
        let mut windows = 0;
        for packet in &packets {
            let Event::Estimate(fit) = &packet.event else {
                continue;
            };
            let (travel, what) = (fit.travel, format!("c{number}, reverse {reverse}: {fit:?}"));
            seen.fetch_add(1, Ordering::Relaxed);
            windows += u32::from(fit.span == Span::Window);
            if fit.status == Status::Ambiguous {
                unclear.fetch_add(1, Ordering::Relaxed);
                continue;
            }
            // The finger is not calibrated here. It is in `tests/travel.rs`, where the direction is
            // therefore known.
            assert_eq!(travel.status, TravelStatus::Uncalibrated, "{what}");
            assert!(
                [towards, Direction::Unknown].contains(&travel.direction),
                "{what}"
            );
            assert!(
                (f64::from(travel.spatial_period_mm) / scene.period_mm - 1.0).abs() < 0.01,
                "{what}"
            );
            assert!(
                (f64::from(travel.speed_mm_s) / scene.speed_mm_s - 1.0).abs() < 0.015,
                "{what}"
            );
        }
        assert!(
            windows > 0
                && (
                    outcome.counts.missing,
                    outcome.counts.damaged,
                    outcome.chip.lost
                ) == (0, 0, 0)
        );
        let kinds = by_kind(events(&packets));
        let Some(Event::Texture(texture)) = kinds.get("Texture").and_then(|found| found.first())
        else {
            panic!("c{number}: no texture")
        };
        assert!(
            (f64::from(texture.period_mm) / scene.period_mm - 1.0).abs() < 0.01,
            "c{number}: {texture:?}"
        );
        assert_eq!(
            by_kind(events(&packets)),
            by_kind(on_pc(&outcome)),
            "c{number}: the PC gives other numbers"
        );
    });
    let [seen, unclear] = [seen, unclear].map(AtomicU32::into_inner);
    assert!(
        seen > 150 && unclear <= 4,
        "{unclear} of {seen} are ambiguous"
    );
}

/// The plain scenes as tables, and a scene with a slide longer than the maximum window, of which
/// the latest part is fitted. The emulated board adds its converter's noise, which is far below the
/// scene's.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_scene_s_table_agrees_with_the_emulated_board_within_a_third_of_sigma() {
    let folder = common::directory();
    let combinations = [&TABLE_2[..], &[(12.0, 3.1)]].concat();
    let scenes: Vec<_> = combinations
        .iter()
        .zip(200..)
        .map(|(&(speed_mm_s, period_mm), seed)| Sliding {
            speed_mm_s,
            period_mm,
            seed,
            ..Sliding::default()
        })
        .collect();
    for_all(&scenes, |scene| {
        let path = folder.path().join(format!("{}.csv", scene.seed));
        let mut made = SlidingScene::new(scene.clone()).expect("a scene");
        let file = std::fs::File::create(&path).expect("a file");
        write_csv(&mut made, frame_rate_hz(), SLOT_S, file).expect("a trace");
        let what = path.display().to_string();
        let (outcome, packets) = emulate(&Input::of(scene.clone()));
        assert_within_bars(&what, &packets, &outcome, &made.truth());
        let samples = Samples::file(&path).expect("a file");
        let frames = Frames::open(&samples, Reading::default()).expect("frames");
        let mut of_table = Vec::new();
        let mut sink = |packet: &Packet| {
            of_table.push(packet.clone());
            Ok(())
        };
        frames
            .run(&frames.settings, false, &mut sink, &mut |_, _| {})
            .expect("a run");
        let [of_table, of_board] = [&of_table, &packets].map(|packets| {
            let estimate = |packet: &Packet| match &packet.event {
                Event::Estimate(estimate) => Some(estimate.clone()),
                _ => None,
            };
            packets.iter().filter_map(estimate).collect::<Vec<_>>()
        });
        assert_eq!(of_table.len(), of_board.len(), "{what}");
        for (found, of_board) in of_table.iter().zip(&of_board) {
            let off = (found.frequency - of_board.frequency).abs() / of_board.sigma;
            assert!(off < 0.3, "{what}: {off} sigma: {found:?}\n{of_board:?}");
        }
    });
}

/// A physical finger, whose skin creeps. With only the chip's noise, the end of a slide is known to
/// a frame.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_physical_finger_is_the_same_on_the_chip_and_on_the_pc() {
    for_all(&[1, 2, 7], |number| {
        let what = format!("C{number}");
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(format!("../hal-mock/scenes/c{number}.toml"));
        let sliding = load_scene(file, frame_rate_hz()).expect("a scene");
        let truth = SlidingScene::new(sliding.clone()).expect("a scene").truth();
        let input = Input {
            scene: sliding,
            ..Input::default()
        };
        let (outcome, packets) = emulate(&input);
        assert_within_bars(&what, &packets, &outcome, &truth);
        assert_eq!(
            by_kind(events(&packets)),
            by_kind(on_pc(&outcome)),
            "{what}: the PC gives other numbers"
        );
        let end_us = packets.iter().find_map(|packet| match &packet.event {
            Event::Slide(slide) => slide.end_us,
            _ => None,
        });
        let end_s =
            (end_us.expect("an end") + outcome.first_edge_us - outcome.start_us) as f64 / 1e6;
        assert!(
            (end_s - truth.slide_end_s).abs() < 0.005,
            "{what}: the slide ends at {end_s} s, {truth:?}"
        );
    });
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn two_runs_give_the_same_bytes() {
    let (first, packets) = emulate(&Input::default());
    let (second, _) = emulate(&Input::default());
    assert!(!first.serial.is_empty());
    assert_eq!(first.serial, second.serial);
    assert!(matches!(packets[0].event, Event::Hello(_)));
    assert_eq!(
        (first.counts.missing, first.counts.damaged, first.chip.lost),
        (0, 0, 0)
    );
    assert_eq!(first.counts.received, packets.len() as u64);
    assert_eq!(first.conversions.len() as u64, first.conversions_served);
}

/// `emulator/tests/long.rs` tests longer runs of touches.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_minute_of_touches_is_as_right_at_its_end_as_at_its_beginning() {
    steady::run(60.0);
}

/// The README's picture and figures must match `cargo xtask demo`. With `RIDGETONE_OVERWRITE=1` the
/// picture is redrawn instead, and the figures must be copied by hand.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_readme_shows_what_the_demo_gives() {
    let elf = emulator::image::find().expect("an image");
    let scene = demo_scene().expect("a scene");
    let demo = demo::run(scene, Options::new(&elf), &mut |_, _| {}).expect("a demo");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let picture = root.join("docs/demo.svg");
    if std::env::var_os("RIDGETONE_OVERWRITE").is_some() {
        std::fs::write(&picture, demo.svg()).expect("docs/demo.svg");
    }
    assert!(
        std::fs::read_to_string(&picture).expect("docs/demo.svg") == demo.svg(),
        "docs/demo.svg is not the demo's"
    );
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let (_, shown) = readme.split_once("```text\n").expect("the output");
    let (shown, _) = shown.split_once("...\n").expect("a part of it");
    assert!(
        demo.to_string().starts_with(shown),
        "README.md: {shown}\n{demo}"
    );
    let load = demo.sliding_load().expect("a report during the slide");
    assert!((0.15..0.30).contains(&load), "load {load}");
}
