//! The three runs of `cargo xtask test` on all boards: from reset to the greeting, the demo's
//! grating, and the longest command during a scan.

mod common;

use common::{Run, estimates, hello, on_pc, reply_to, request, touches_and_tones};
use hal_mock::{Constant, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_proto::boot::{Oscillator, ResetCause};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::{Array, Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Span, Status};

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn all_boards_start_and_greet_and_lose_nothing() {
    for board in Board::ALL {
        let mut run = Run::new(board, Constant::default(), Start::default());
        let greeting = run.run_to(1.0, hello);
        assert_eq!(
            (greeting.boot.cause, greeting.boot.record),
            (ResetCause::Power, None),
            "{board:?}"
        );
        assert_eq!(greeting.boot.oscillator, Oscillator::External, "{board:?}");
        run.run_s(1.0);
        run.assert_rules();
        assert!(run.emulator.resets().is_empty());
        let seconds = run.emulator.now_ns() as f64 * 1e-9;
        assert!(seconds < 1.5, "{board:?}: {seconds}");
        let (read, counters) = (
            run.emulator.readings().len() as u64,
            run.emulator.adc().counters(),
        );
        assert_eq!(counters.lost, 0, "{board:?}: {counters:?}");
        assert!(
            read > 4000 && counters.conversions - read <= 1,
            "{board:?}: {read} of {counters:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_demo_is_the_same_on_all_boards_and_on_the_pc() {
    for board in Board::ALL {
        let mut run = Run::sliding(board);
        run.run_s(6.0);
        run.assert_rules();
        let there = touches_and_tones(&run.events);
        assert!(there.len() > 8, "{there:?}");
        assert!(
            there == touches_and_tones(&on_pc(&run)),
            "{board:?}: to the bit: {there:?}"
        );
        let whole = estimates(&there)
            .into_iter()
            .find(|one| one.span == Span::Slide);
        let estimate = whole.expect("an estimate of the whole slide");
        assert_eq!(estimate.status, Status::Good);
        // 3.6 mm at 30 mm/s.
        let off = (estimate.frequency - 30.0 / 3.6).abs() / estimate.sigma;
        assert!(off < 4.0, "{estimate:?}");
        println!("{board:?}: {} conversions", run.emulator.readings().len());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_longest_command_arrives_two_hundred_times_while_the_chip_scans() {
    let slide = Slide {
        rule: SlideRule::Protocol,
        delay_s: 1.0,
        speed_mm_s: 30.0,
        length_mm: 55.0,
    };
    let array = Array {
        alike: [0x8001, 0x4002, 0x2004, 0x1008],
        ..Array::DEFAULT
    };
    let set = Command::Set {
        settings: Settings {
            slide,
            array,
            ..Settings::DEFAULT
        },
        keep: false,
    };
    for board in Board::ALL {
        let mut run = Run::at_rest(board);
        let sent = request(u16::MAX, set.clone());
        assert!(sent.len() > 80, "{} bytes", sent.len());
        for number in 1..=200 {
            run.emulator.send(&request(u16::MAX - number, set.clone()));
            let seen = run.events.len();
            run.run_s(0.03);
            let reply = run.events[seen..]
                .iter()
                .find_map(reply_to(u16::MAX - number));
            assert_eq!(reply, Some(Outcome::Done), "{board:?}: request {number}");
        }
        run.assert_rules();
        assert_eq!(run.emulator.received()[..2], [0, 0], "{board:?}: none lost");
    }
}

/// `src/minimal.rs` has no tasks. It loses the conversions made during a fit, and must report this.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_minimal_firmware_prints_a_touch_as_text() {
    let image = Image::built_as("minimal", "ridgetone-minimal.elf").expect("an image");
    let scene = SlidingScene::new(Sliding::default()).expect("a scene");
    let board = Board::NucleoF446re;
    let mut emulator = Emulator::new(board, &image, scene, Start::default()).expect("vectors");
    emulator.run_ns(8_000_000_000).expect("a run");
    let text = String::from_utf8(emulator.take_sent()).expect("text");
    println!("{text}");
    let found = |word: &str| text.lines().position(|line| line == word);
    let (contact, release) = (found("contact"), found("release"));
    assert!(contact.is_some() && contact < release, "{text}");
    // A line such as `Good: 8333 mHz +- 682 uHz`.
    let good = text.lines().filter_map(|line| {
        let (mhz, sigma_uhz) = line.strip_prefix("Good: ")?.split_once(" mHz +- ")?;
        let sigma_uhz: f64 = sigma_uhz.strip_suffix(" uHz")?.parse().ok()?;
        Some((mhz.parse::<f64>().ok()?, sigma_uhz))
    });
    let good: Vec<_> = good.collect();
    assert!(!good.is_empty(), "{text}");
    for (mhz, sigma_uhz) in good {
        // The text is truncated to whole millihertz.
        let off_mhz = (mhz + 0.5 - 30_000.0 / 3.6).abs();
        assert!(off_mhz < 0.5 + 5.0 * sigma_uhz * 1e-3, "{text}");
    }
    let mut lost = text
        .lines()
        .filter_map(|line| line.strip_suffix(" conversions lost"));
    let lost: u32 = lost
        .next_back()
        .expect("a count")
        .parse()
        .expect("a number");
    assert!(lost > 0, "a loop reads nothing while it fits: {text}");
    assert!(emulator.findings().is_empty(), "{:#?}", emulator.findings());
}
