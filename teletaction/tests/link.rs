//! Tests `ridgetone link`: in virtual time with a simulated stylus, over UDP, with the emulated
//! finger, and with refused options.

#[path = "../../host/tests/common/mod.rs"]
mod common;

use common::{assert_one_line, directory, json_lines, ridgetone, run, text};
use hal_mock::Sliding;
use ridgetone_host::input::Input;
use ridgetone_host::recording::{self, Keep};
use ridgetone_host::replay;
use ridgetone_host::touches::PERIODS_MM;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, Status};
use ridgetone_teletaction::link::board::{BoardEnd, Line};
use ridgetone_teletaction::link::finger::PeriodBy;
use ridgetone_teletaction::link::run::Report;
use ridgetone_teletaction::link::simulated::Simulated;
use ridgetone_teletaction::link::{Ends, Hand, Link, Options};
use ridgetone_teletaction::stimulus::{Actuator, Texture};
use ridgetone_teletaction::stylus::SAMPLE_HZ;
use ridgetone_teletaction::stylus::gate::State;
use ridgetone_teletaction::stylus::parameters::Parameters;
use ridgetone_teletaction::touch::Output;
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;

/// Limits that differ from the default, to test that they reach the stylus.
const ACTUATOR: Actuator = Actuator {
    voltage_v: 120.0,
    slew_v_s: 150_000.0,
    ..Actuator::PIEZO
};

/// Codes of the converter: at rest, and the maximum.
const REST_CODE: u16 = 2048;
const MAX_CODE: f32 = 4095.0;

/// Network delays and their standard deviations, milliseconds: a steady one, and the paper's.
const STEADY: [f64; 2] = [120.0, 0.0];
const PAPER: [f64; 2] = [120.0, 40.0];

struct Bench {
    link: Link,
    now_ms: u32,
}

impl Bench {
    fn new(hand: Hand, delay_ms: [f64; 2], loss: f64, follows: bool) -> Self {
        let [delay_ms, jitter_ms] = delay_ms;
        let output = Output::new(ACTUATOR, None).expect("an output");
        let options = Options {
            delay_ms,
            jitter_ms,
            loss,
            seed: 5,
            run: 70_000,
            follows,
        };
        let parameters = Parameters::DEFAULT;
        let stylus = Simulated::new(hand, output, &parameters, delay_ms / 1e3);
        let line = Line::Simulated(Box::new(stylus));
        let end = BoardEnd::new(line, output, parameters, options.run).expect("an end");
        let link = Link::new(&options, Ends::Here, Some(end)).expect("a link");
        Self { link, now_ms: 0 }
    }

    fn touching(period_mm: f32, delay_ms: [f64; 2], loss: f64) -> Self {
        let mut bench = Self::new(Hand::OKAMOTO, delay_ms, loss, false);
        bench.link.finger.found(Some(Texture::new(period_mm)));
        bench
    }

    fn stylus(&mut self) -> &mut Simulated {
        let end = self.link.stylus.as_mut().expect("an end");
        end.simulated().expect("a simulated stylus")
    }

    fn step(&mut self) {
        let t_s = 0.001 * f64::from(self.now_ms);
        self.link.step(t_s).expect("a step");
        self.now_ms += 1;
        // Steps must not exceed the actuator's slew, plus one code of rounding. From 0 V to rest a
        // stylus uses the default slew.
        let slew_v = ACTUATOR.slew_v_s / SAMPLE_HZ as f32;
        let max = slew_v / ACTUATOR.voltage_v * MAX_CODE + 1.0;
        let steepest = self.stylus().steepest;
        assert!(f32::from(steepest) <= max, "{t_s} s: {steepest} of {max}");
    }

    /// Advances by `ms`, and returns the report of the last second.
    fn pass(&mut self, ms: u32) -> Report {
        let until_ms = self.now_ms + ms;
        while self.now_ms < until_ms {
            if self.now_ms + 1000 == until_ms {
                self.report();
            }
            self.step();
        }
        self.report()
    }

    fn report(&mut self) -> Report {
        self.link.report(0.001 * f64::from(self.now_ms))
    }

    /// Asserts that nothing is felt, that the stylus' state is reported as `state`, and that it
    /// rests.
    fn assert_rests(&mut self, report: &Report, state: Option<State>) {
        let said = report.stylus.expect("a stylus").state;
        assert_eq!(
            (report.is_felt, report.period_mm, said),
            (false, None, state)
        );
        let stylus = self.stylus();
        assert_eq!((stylus.state(), stylus.code), (State::Disabled, REST_CODE));
    }
}

/// The delay must not be felt: the error is below 1 % of the amplitude, while a transmitted
/// vibration would not resemble the surface.
#[test]
fn neither_delay_nor_jitter_nor_loss_is_felt() {
    let mut bench = Bench::touching(1.4, PAPER, 0.05);
    let report = bench.pass(10_000);
    println!("{}", report.text());
    assert!(report.error_percent.expect("felt") < 1.0, "{report:?}");
    assert!(
        report.as_vibration_percent.expect("felt") > 50.0,
        "{report:?}"
    );
    let Report {
        positions,
        positions_sent,
        textures_sent,
        ..
    } = &report;
    // 250 a second, and one more for each request that changes a state.
    assert!((2495..=2520).contains(positions_sent), "{report:?}");
    // 5 % are lost, with a standard deviation of 11. Messages on the way, for up to 0.28 s, are not
    // counted as lost.
    let under_way = positions_sent - positions.received - positions.lost - positions.late;
    assert!(
        (80..175).contains(&positions.lost) && under_way <= 75 && positions.damaged == 0,
        "{report:?}"
    );
    assert!((38..43).contains(textures_sent), "{report:?}");
    // At the mean speed the hand moves 15 mm within the mean delay.
    assert!(report.behind_mm.expect("a position") < 60.0, "{report:?}");
    // A new texture arrives.
    bench.link.finger.found(Some(Texture::new(0.9)));
    let while_it_travels = bench.pass(1000);
    let after = bench.pass(1000);
    assert!(
        while_it_travels.error_percent > Some(5.0),
        "{while_it_travels:?}"
    );
    assert_eq!(after.period_mm, Some(0.9));
    assert!(after.error_percent < Some(1.0), "{after:?}");
}

/// If the network is dead or the finger silent, the vibration must fade within the slew, and return
/// later. At the end the stylus must be left at rest.
#[test]
fn without_the_finger_the_stylus_rests() {
    let mut bench = Bench::touching(1.4, STEADY, 0.0);
    assert!(bench.pass(3000).is_felt);
    bench.link.to_stylus.loss = 1.0;
    // Messages already on the way still arrive.
    assert!(bench.pass(600).is_felt);
    let dead = bench.pass(1400);
    bench.assert_rests(&dead, Some(State::Disabled));
    bench.link.to_stylus.loss = 0.0;
    assert!(bench.pass(2000).error_percent < Some(1.0));
    bench.link.finger.found(None);
    let silent = bench.pass(1000);
    bench.assert_rests(&silent, Some(State::Disabled));
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(1000).is_felt);
    for _ in 0..200 {
        bench.link.stylus.as_mut().expect("an end").stop_softly();
        bench.step();
    }
    let stopped = bench.report();
    bench.assert_rests(&stopped, Some(State::Disabled));
}

/// The state of a silent stylus is unknown. The silence must be reported, and the stylus disabled
/// and set up again when it returns.
#[test]
fn a_stylus_that_is_silent_is_reported_and_stops_softly() {
    let mut bench = Bench::touching(1.4, STEADY, 0.0);
    assert!(bench.pass(1000).is_felt);
    bench.stylus().is_mute = true;
    let report = bench.pass(2000);
    bench.assert_rests(&report, None);
    assert_eq!(report.stylus.expect("a stylus").silences, 1);
    bench.stylus().is_mute = false;
    let report = bench.pass(1000);
    assert_eq!((report.is_felt, report.period_mm), (true, Some(1.4)));
}

/// A restarted stylus must get its limits and its texture again. Its encoder restarts at 0, which
/// must not be taken for a movement. The 16-bit counter wraps.
#[test]
fn a_stylus_that_has_started_again_gets_all_again() {
    const SPEED_MM_S: f64 = 100.0;
    let hand = Hand {
        speed_mm_s: SPEED_MM_S,
        turns_hz: 0.0,
    };
    let mut bench = Bench::new(hand, STEADY, 0.0, false);
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(1000).is_felt);
    let from_mm = bench.link.finger.position_mm.expect("a position");
    bench.stylus().restart();
    let report = bench.pass(4000);
    assert_eq!((report.is_felt, report.period_mm), (true, Some(1.4)));
    assert!(report.error_percent < Some(1.0), "{report:?}");
    let moved_mm = bench.link.finger.position_mm.expect("a position") - from_mm;
    assert!((moved_mm / SPEED_MM_S - 4.0).abs() < 0.02, "{moved_mm} mm");
}

/// A robot that follows the hand slides a simulated finger back and forth over a grating of 3.6 mm,
/// and the firmware's library fits the signal. The period must be derived from the hand's path, but
/// not from windows in which the hand turns.
#[test]
fn the_period_is_the_hands_path_over_the_windows_cycles() {
    const PERIOD_MM: f64 = 3.6;
    // At most 60 mm/s, with a turn every 2 s.
    let scene_hand = hal_mock::sliding::Hand {
        peak_mm_s: 60.0,
        swing_hz: 0.25,
        swings: 3.0,
    };
    let input = Input {
        scene: Sliding {
            period_mm: PERIOD_MM,
            hand: Some(scene_hand),
            ..Sliding::physical()
        },
        ..Input::default()
    };
    let opened = input.open().expect("a scene");
    let slide_start_s = opened.truth.as_ref().expect("a scene").slide_start_s;
    let mut events = Vec::new();
    let mut sink = |packet: &Packet| {
        events.push(packet.event.clone());
        Ok(())
    };
    let settings = Settings {
        window_s: 0.8,
        ..Settings::DEFAULT
    };
    replay::run(opened, settings, &mut sink, &mut |_, _| {}).expect("a run");

    // The link's hand starts to move at 0 s, and the finger follows one delay later.
    let delay_s = STEADY[0] / 1e3;
    let linked_s = |device_us: u64| device_us as f64 * 1e-6 - slide_start_s + delay_s;
    let hand = Hand {
        speed_mm_s: scene_hand.peak_mm_s / FRAC_PI_2,
        turns_hz: scene_hand.swing_hz,
    };
    let mut bench = Bench::new(hand, STEADY, 0.05, true);
    let (mut straight, mut turning) = (Vec::new(), 0);
    for event in &events {
        let Event::Estimate(estimate) = event else {
            continue;
        };
        let end_s = linked_s(estimate.t_us);
        let begin_s = end_s - f64::from(estimate.window_s);
        // Use only windows within the slide, and skip the fit of the whole slide.
        if begin_s < delay_s || estimate.window_s > 1.0 {
            continue;
        }
        // The estimate arrives 60 ms after the end of its window.
        while f64::from(bench.now_ms) < 1e3 * (end_s + 0.06) {
            bench.step();
        }
        let found = bench.link.finger.window(end_s, estimate);
        let swing = |t_s: f64| ((t_s - delay_s) * 2.0 * scene_hand.swing_hz).floor();
        if swing(begin_s) != swing(end_s) {
            turning += 1;
            assert_eq!(found, None, "{begin_s} to {end_s} s");
        } else if estimate.status == Status::Good {
            let found = found.unwrap_or_else(|| panic!("{begin_s} to {end_s} s"));
            let off_mm = found.mm - PERIOD_MM;
            assert!(off_mm.abs() < 4.0 * found.sigma_mm, "{found:?}");
            straight.push((off_mm, found.sigma_mm));
        } else {
            assert_eq!(found, None, "{:?}", estimate.status);
        }
    }
    let count = straight.len() as f64;
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        (values.map(|mm| mm * mm).sum::<f64>() / count).sqrt()
    };
    let off_mm = rms(&mut straight.iter().map(|(off_mm, _)| *off_mm));
    let sigma_mm = rms(&mut straight.iter().map(|(_, sigma_mm)| *sigma_mm));
    let texture = bench.link.finger.texture().expect("a texture");
    println!(
        "{count} windows without a turn, {turning} with one: rms error {off_mm:.4} mm, sigma {sigma_mm:.4} mm"
    );
    assert!(count >= 10.0 && turning >= 3, "{count} {turning}");
    // The lags of an uncalibrated array are known to 7 %.
    assert!(
        off_mm < 0.02 * PERIOD_MM && sigma_mm < 0.03 * PERIOD_MM,
        "{off_mm} {sigma_mm}"
    );
    assert!(
        (f64::from(texture.period_mm) - PERIOD_MM).abs() < 4.0 * f64::from(texture.period_sigma_mm)
    );
    assert_eq!(bench.link.finger.period_by(), Some(PeriodBy::Path));
}

/// One end plays a recording of the demo's touch and the other has a hand. They are two processes
/// on a real network with losses.
#[test]
fn two_ends_find_each_other_over_a_network() {
    let folder = directory();
    let path = folder.path().join("touch.rec");
    let input = Input::default().open().expect("a scene");
    let outcome =
        replay::run(input, Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {}).expect("a run");
    recording::create(&path, "a test", 0.0)
        .expect("a file")
        .keep(&outcome.serial, None)
        .expect("kept");
    let network = "--delay-ms 40 --jitter-ms 10 --loss 5% --json";
    let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<String>>();
    let mut finger = ridgetone()
        .args(["link", "--stylus", "udp:127.0.0.1:0", "--finger"])
        .arg(text(&path))
        .args(words(network))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut report = BufReader::new(finger.stderr.take().expect("a pipe"));
    let mut line = String::new();
    report.read_line(&mut line).expect("a line");
    let address = line
        .trim()
        .rsplit(' ')
        .next()
        .expect("an address")
        .to_owned();
    let stylus = ridgetone()
        .args(words(&format!(
            "link --finger {address} --stylus simulated --for 7 {network}"
        )))
        .output()
        .expect("the command runs");
    let stylus = json_lines(&stylus);
    let mut printed = String::new();
    finger
        .stdout
        .take()
        .expect("a pipe")
        .read_to_string(&mut printed)
        .expect("UTF-8");
    assert!(finger.wait().expect("ended").success(), "{line}");
    let finger: Vec<Value> = printed
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let last = |lines: &[Value]| lines.last().expect("a report").clone();
    // The finger must receive the hand's positions, and the stylus the texture of 3.6 mm.
    let positions = &last(&finger)["positions"];
    assert!(
        positions["received"].as_u64() > Some(200) && positions["lost"].as_u64() > Some(5),
        "{finger:?}"
    );
    let felt = stylus
        .iter()
        .rfind(|report| report["is_felt"] == true)
        .unwrap_or_else(|| panic!("felt: {stylus:?}"));
    let [period_mm, sigma_mm] =
        ["period_mm", "period_sigma_mm"].map(|what| felt[what].as_f64().expect("a number"));
    // An uncalibrated array measures the period to about 8 %.
    assert!(
        (period_mm - 3.6).abs() < 4.0 * sigma_mm && sigma_mm < 0.3,
        "{felt}"
    );
    // The recording has ended, so the link is dead and nothing is felt any more.
    assert_eq!(last(&stylus)["is_felt"], false, "{stylus:?}");
}

#[test]
fn what_makes_no_sense_is_refused_on_one_line() {
    for (arguments, status, words) in [
        ("", 2, &["--finger"][..]),
        ("--emulated --finger emulated", 2, &["--finger"]),
        ("--emulated --follows", 2, &["--follows", "serial port"]),
        (
            "--finger udp:127.0.0.1:1 --follows",
            2,
            &["--follows", "finger's end"],
        ),
        ("--emulated --loss 101%", 2, &["0 to 100"]),
        ("--emulated --loss -1", 2, &["0 to 100"]),
        ("--emulated --loss NaN", 2, &["not a number"]),
        ("--emulated --delay-ms 5000", 2, &["--delay-ms 5000"]),
        (
            "--emulated --stylus mine",
            1,
            &["--stylus", "simulated", "mine"],
        ),
        (
            "--finger udp:127.0.0.1:1 --stylus udp:127.0.0.1:0",
            2,
            &["one end must be here"],
        ),
        (
            "--finger http://127.0.0.1:1",
            2,
            &["a port, emulated or a recording"],
        ),
        ("--emulated --speed-mm-s 1e9", 2, &["--speed-mm-s"]),
        ("--finger udp:nowhere", 1, &["nowhere", "HOST:PORT"]),
    ] {
        let arguments: Vec<&str> = ["link"]
            .into_iter()
            .chain(arguments.split_whitespace())
            .collect();
        assert_one_line(&run(&arguments), status, words);
    }
}

/// The emulated finger with a simulated hand and the paper's network delay, which must not be felt.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_finger_is_felt_without_the_delay() {
    let paper = ["--delay-ms", "120", "--jitter-ms", "40", "--loss", "5%"];
    let reports = json_lines(&run(&[
        &["link", "--emulated", "--for", "40", "--json"],
        &paper[..],
    ]
    .concat()));
    assert!(reports.len() >= 10, "{}", reports.len());
    // Use seconds without a new texture at either end. The finger has a texture one delay before
    // the stylus, so the next report must have the same texture too.
    let steady: Vec<&Value> = reports
        .windows(3)
        .filter(|three| {
            three[0]["period_mm"].is_number()
                && three
                    .iter()
                    .all(|report| report["period_mm"] == three[0]["period_mm"])
        })
        .map(|three| &three[1])
        .collect();
    assert!(steady.len() >= 3, "{reports:?}");
    for report in steady {
        let number = |what: &str| {
            report[what]
                .as_f64()
                .unwrap_or_else(|| panic!("{what}: {report}"))
        };
        let is_one = |period_mm: &f64| (number("period_mm") - period_mm).abs() < 0.1;
        assert!(PERIODS_MM.iter().any(is_one), "{report}");
        assert!(number("error_percent") < 1.0, "{report}");
        assert!(number("as_vibration_percent") > 50.0, "{report}");
    }
}
