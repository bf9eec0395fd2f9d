//! Tests `ridgetone fit --positions` with raw frames of a simulated finger whose speed varies and
//! reverses, and with the log of a robot that has its own clock.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, text};
use hal_mock::{Finger, Hand, Options, Scene, SimulatedBoard, Sliding, SlidingScene};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_finger::{Pipeline, TimedConversion};
use ridgetone_host::messages::{Form, Message, messages};
use ridgetone_host::part::Selection;
use ridgetone_host::positions::PositionFile;
use ridgetone_host::recording::{self, Keep};
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit;
use ridgetone_host::utc::Receipt;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const EPOCH_S: f64 = 1_769_862_605.25;
/// Relative amount by which the board's clock is slow.
const SLOW: f64 = 80e-6;
/// Duration of a byte on the line, seconds.
const BYTE_S: f64 = 10.0 / 921_600.0;

/// Motion of the finger from the start of the slide.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// Back and forth.
    Hand(Hand),
    /// In one direction, for two periods of 1.5 s in which the speed varies by 60 % about its mean.
    Varying { mean_mm_s: f64 },
}

const SWING_S: f64 = 1.5;

impl Motion {
    fn lasts_s(self) -> f64 {
        match self {
            Self::Hand(hand) => hand.swings / hand.swing_hz,
            Self::Varying { .. } => 2.0 * SWING_S,
        }
    }

    /// Returns the position in closed form, independently of the scene.
    fn mm(self, since_s: f64) -> f64 {
        let since_s = since_s.clamp(0.0, self.lasts_s());
        match self {
            Self::Hand(hand) => {
                let turns = hand.swing_hz * since_s;
                hand.peak_mm_s / (TAU * hand.swing_hz) * (1.0 - (TAU * turns).cos())
            }
            Self::Varying { mean_mm_s } => {
                let swung_s = 0.6 * SWING_S / TAU * (1.0 - (TAU * since_s / SWING_S).cos());
                mean_mm_s * (since_s + swung_s)
            }
        }
    }

    fn mm_s(self, since_s: f64) -> f64 {
        let is_moving = (0.0..=self.lasts_s()).contains(&since_s);
        let mm_s = match self {
            Self::Hand(hand) => hand.peak_mm_s * (TAU * hand.swing_hz * since_s).sin(),
            Self::Varying { mean_mm_s } => {
                mean_mm_s * (1.0 + 0.6 * (TAU * since_s / SWING_S).sin())
            }
        };
        if is_moving { mm_s } else { 0.0 }
    }
}

/// A slide at constant speed, played back along a motion.
struct Moved {
    scene: SlidingScene,
    motion: Motion,
}

impl Scene for Moved {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let Motion::Varying { mean_mm_s } = self.motion else {
            return self.scene.volts(input, t_s);
        };
        let start_s = self.scene.truth().slide_start_s;
        let since_s = (t_s - start_s).clamp(0.0, self.motion.lasts_s());
        // Time at which the steady scene is at that position.
        let own_s = start_s + self.motion.mm(since_s) / mean_mm_s;
        self.scene.volts(input, own_s + t_s - start_s - since_s)
    }

    fn end_s(&self) -> f64 {
        self.scene.end_s()
    }
}

struct Recorded {
    folder: tempfile::TempDir,
    path: PathBuf,
    motion: Motion,
    /// Start of the slide, seconds of scene time.
    start_s: f64,
    /// Scene time at device time zero, seconds.
    zero_s: f64,
}

impl Recorded {
    /// Records a slide over a grating of this period, with friction and the bridges' low-pass.
    fn new(motion: Motion, period_mm: f64, plan: Plan, seed: u64) -> Self {
        let finger = Some(Finger::default());
        let base = Sliding {
            finger,
            ..Sliding::physical()
        };
        Self::of(base, motion, period_mm, plan, seed)
    }

    fn of(base: Sliding, motion: Motion, period_mm: f64, plan: Plan, seed: u64) -> Self {
        let (hand, speed_mm_s) = match motion {
            Motion::Hand(hand) => (Some(hand), hand.peak_mm_s),
            Motion::Varying { mean_mm_s } => (None, mean_mm_s),
        };
        let scene = SlidingScene::new(Sliding {
            hand,
            speed_mm_s,
            period_mm,
            ridge_mm: 0.5 * period_mm,
            slide_mm: motion.lasts_s() * speed_mm_s,
            seed,
            ..base
        })
        .expect("a scene");
        let start_s = scene.truth().slide_start_s;
        let folder = directory();
        let path = folder.path().join("touch.rec");
        let zero_s = record(Moved { scene, motion }, plan, &path, seed);
        Self {
            folder,
            path,
            motion,
            start_s,
            zero_s,
        }
    }

    /// Writes the robot's log: rows of time and value at about this rate, unevenly spaced.
    fn log(&self, header: &str, rate_hz: f64, row: impl Fn(&Self, f64) -> (f64, f64)) -> PathBuf {
        let mut csv = format!("{header}\n");
        let count = ((self.start_s + self.motion.lasts_s() + 0.3) * rate_hz) as usize;
        for number in 0..count {
            let t_s = (number as f64 + 0.2 * (number as f64).sin()) / rate_hz;
            let (stamp_s, value) = row(self, t_s);
            let _ = writeln!(csv, "{stamp_s:.6},{value:.7}");
        }
        file(self.folder.path(), "robot.csv", &csv)
    }

    fn mm(&self, t_s: f64) -> f64 {
        self.motion.mm(t_s - self.start_s)
    }

    fn utc_mm(&self, t_s: f64) -> (f64, f64) {
        (EPOCH_S + t_s, 7.0 + self.mm(t_s))
    }
}

/// Records the raw frames of a scene. The times of receipt have an exponential delay with a mean of
/// 0.3 ms. Returns the scene time at device time zero.
fn record(scene: impl Scene + 'static, plan: Plan, path: &Path, seed: u64) -> f64 {
    let options = Options {
        clock_hz: plan.adc_clock_hz,
        ..Options::default()
    };
    let board = SimulatedBoard::new(scene, options);
    let mut adc = ads1258::Ads1258::new(board.spi());
    let mut start = board.start_pin();
    adc.stop(&mut start).expect("the chip");
    let own = Ads1258Plan::of(&plan);
    adc.configure(&own.config()).expect("the chip");
    adc.start(&mut start).expect("the chip");
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT.with_plan(plan)));
    pipeline.report_raw(u32::MAX);
    let mut out = recording::create(path, "a test", BYTE_S).expect("a recording");
    let (mut random, mut sequence, mut zero_s) = (ChaCha8Rng::seed_from_u64(seed), 0, None);
    let mut keep = |event: Event, now_s: f64| {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        sequence = sequence.wrapping_add(1);
        let fraction = (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
        let received_s = now_s * (1.0 + SLOW) + used as f64 * BYTE_S - 0.3e-3 * fraction.ln();
        let receipt = Receipt {
            utc_ns: ((EPOCH_S + received_s) * 1e9) as u64,
            byte_s: BYTE_S,
        };
        out.keep(&wire[..used], Some(receipt)).expect("it is kept");
    };
    keep(pipeline.hello(), 0.0);
    while let Some(edge_ns) = board.wait_for_drdy() {
        let conversion = adc.read().expect("the chip");
        if board.with_chip(|chip| chip.ended()) {
            break;
        }
        let scene_ns = board.with_chip(|chip| chip.scene_zero_ns()).unwrap_or(0);
        let now_s = (edge_ns - scene_ns) as f64 * 1e-9;
        zero_s.get_or_insert(now_s);
        let timed = TimedConversion::new((edge_ns / 1000) as u32, conversion);
        pipeline.push(timed, &mut |event| keep(event, now_s));
    }
    zero_s.expect("a conversion")
}

const SLOW_HAND: Hand = Hand {
    peak_mm_s: 60.0,
    swing_hz: 0.8,
    swings: 4.0,
};

/// Every good window's period must be within its uncertainty while the speed varies and reverses.
#[test]
fn windows_have_the_scenes_period_within_their_sigma() {
    type Row = fn(&Recorded, f64) -> (f64, f64);
    let utc_mm: Row = Recorded::utc_mm;
    let fast = Hand::default();
    let varying = Motion::Varying { mean_mm_s: 20.0 };
    for (name, motion, period_mm, plan, window_s, header, rate_hz, row) in [
        (
            "hand",
            Motion::Hand(SLOW_HAND),
            2.6,
            Plan::PAPER,
            0.6,
            "utc_s,position_mm",
            250.0,
            utc_mm,
        ),
        (
            "one way",
            varying,
            3.1,
            Plan::PAPER,
            0.7,
            "utc_s,position_mm",
            50.0,
            utc_mm,
        ),
        (
            "fast hand",
            Motion::Hand(fast),
            1.0,
            Plan::HAND,
            0.15,
            "utc_s,position_mm",
            100.0,
            utc_mm,
        ),
        (
            "speeds",
            Motion::Hand(SLOW_HAND),
            2.6,
            Plan::PAPER,
            0.6,
            "utc_s,speed_m_s",
            100.0,
            |of, t_s| (EPOCH_S + t_s, 1e-3 * of.motion.mm_s(t_s - of.start_s)),
        ),
        (
            "device time",
            Motion::Hand(SLOW_HAND),
            2.6,
            Plan::PAPER,
            0.6,
            "time_s,position_um",
            250.0,
            |of, t_s| (t_s - of.zero_s, 1e3 * of.mm(t_s)),
        ),
    ] {
        let (mut good, mut windows, mut covered, mut worst) = (0, 0, 0, 0f64);
        for seed in 1..=3 {
            let recorded = Recorded::new(motion, period_mm, plan, seed);
            let log = recorded.log(header, rate_hz, row);
            let from_s = format!("{}", recorded.start_s - recorded.zero_s + 0.05);
            let to_s = format!(
                "{}",
                recorded.start_s - recorded.zero_s + motion.lasts_s() - 0.05
            );
            let window_s = window_s.to_string();
            let rows = json_lines(&run(&[
                "fit",
                text(&recorded.path),
                "--positions",
                text(&log),
                "--window",
                &window_s,
                "--from",
                &from_s,
                "--to",
                &to_s,
                "--json",
            ]));
            for found in &rows {
                windows += 1;
                assert_eq!(found["domain"], "position", "{name}: {found}");
                if found["status"] != "good" {
                    continue;
                }
                let [mm, sigma_mm, per_mm] = ["period_mm", "period_sigma_mm", "frequency_per_mm"]
                    .map(|field| found[field].as_f64().expect("a number"));
                assert!((mm * per_mm - 1.0).abs() < 1e-9, "{found}");
                let off = (mm - period_mm).abs() / sigma_mm;
                worst = worst.max(off);
                good += 1;
                covered += usize::from(off < 1.96);
                assert!(
                    off < 5.0 && sigma_mm < 0.01 * period_mm,
                    "{name}: {off} sigma, {found}"
                );
            }
        }
        println!("{name}: {good} of {windows} good, {covered} covered, {worst:.2} sigma at most");
        assert!(
            3 * good > 2 * windows && windows >= 9,
            "{name}: {good} of {windows}"
        );
        assert!(10 * covered >= 8 * good, "{name}: {covered} of {good}");
    }
}

/// The last channel of a scan is read 3 ms after the first, while a hand moves 0.2 mm. A fit that
/// ignores this has a larger residual.
#[test]
fn channels_have_positions_of_their_own() {
    let motion = Motion::Hand(SLOW_HAND);
    let quiet = Sliding {
        snr_db: Some(40.0),
        ..Sliding::default()
    };
    let recorded = Recorded::of(quiet, motion, 2.6, Plan::PAPER, 1);
    let positions = PositionFile {
        path: recorded.log("utc_s,position_mm", 250.0, Recorded::utc_mm),
        column: None,
        time: None,
    };
    let samples = Samples::file(&recorded.path).expect("samples");
    // Fit the rows from one turn of the hand to the next.
    let begin_s = recorded.start_s - recorded.zero_s + 0.625;
    let selection = Selection {
        from_s: Some(begin_s),
        to_s: Some(begin_s + 0.625),
        ..Selection::default()
    };
    let residual = |is_skewed: bool| {
        let (samples, mut selection) = positions.join(&samples, &selection).expect("they join");
        if let (Some(alignment), false) = (&mut selection.alignment, is_skewed) {
            alignment.skew_frames = [0.0; 16];
        }
        let mut rows = samples.open().expect("rows");
        let fit = table_fit::fit(&mut *rows, &selection, &mut |_| {}).expect("a fit");
        // Mean relative residual of the first and last two channels of the scan.
        let of = |channel: usize| {
            let found = &fit.channels[channel];
            found.residual.expect("a residual") / found.amplitude.expect("an amplitude")
        };
        [0, 1, 14, 15].map(of).iter().sum::<f64>() / 4.0
    };
    let (with, without) = (residual(true), residual(false));
    println!("residual over amplitude {with:.3} with the skew, {without:.3} without");
    assert!(without > 3.0 * with, "{with} {without}");
}

/// Returns the greeting of a board with this plan. Not inlined, because a pipeline is large and
/// only one should be on the stack at a time.
#[inline(never)]
fn hello(plan: Plan) -> Event {
    Pipeline::new(Settings::DEFAULT.with_plan(plan)).hello()
}

fn copied(from: &Path, name: &str, change: &dyn Fn(&mut Event, &mut Option<Receipt>)) -> PathBuf {
    let path = from.with_file_name(name);
    let mut out = recording::create(&path, "a test", BYTE_S).expect("a recording");
    for message in messages(from, Form::Telemetry).expect("a recording") {
        let Message::Packet(mut packet, mut receipt) = message.expect("a message") else {
            continue;
        };
        change(&mut packet.event, &mut receipt);
        let mut wire = [0; WIRE_MAX];
        let used = encode(&packet, &mut wire).expect("it fits");
        out.keep(&wire[..used], receipt).expect("it is kept");
    }
    path
}

/// Each error must name what was found and what to do.
#[test]
fn what_does_not_go_is_named() {
    let recorded = Recorded::new(Motion::Varying { mean_mm_s: 20.0 }, 3.1, Plan::PAPER, 1);
    let folder = recorded.folder.path();
    let good = recorded.log("utc_s,position_mm", 100.0, Recorded::utc_mm);
    let wordless = file(
        folder,
        "wordless.csv",
        "utc_s,x,y\n1769862605,0.5,1.5\n1769862606,1.5,2.5\n",
    );
    let late = file(
        folder,
        "late.csv",
        "utc_s,position_mm\n1769900000,0.5\n1769900001,1.5\n",
    );
    let gap = {
        let log = std::fs::read_to_string(&good).expect("the log");
        let is_kept = |line: &&str| {
            let time_s = line
                .split(',')
                .next()
                .and_then(|text| text.parse::<f64>().ok());
            time_s.is_none_or(|t_s| {
                let since_s = t_s - EPOCH_S - recorded.start_s;
                !(1.0..1.5).contains(&since_s)
            })
        };
        let lines: Vec<&str> = log.lines().filter(is_kept).collect();
        file(folder, "gap.csv", &lines.join("\n"))
    };
    let counts = file(
        folder,
        "counts.csv",
        "utc_s,position\n1769862605,1\n1769862612,9\n",
    );
    let empty = folder.join("empty.rec");
    {
        let mut out = recording::create(&empty, "a test", BYTE_S).expect("a recording");
        let hello = hello(Plan::PAPER);
        let mut wire = [0; WIRE_MAX];
        let packet = Packet {
            sequence: 0,
            event: hello,
        };
        let used = encode(&packet, &mut wire).expect("it fits");
        out.keep(&wire[..used], None).expect("it is kept");
    }
    let unreceived = copied(&recorded.path, "unreceived.rec", &|_, receipt| {
        *receipt = None
    });
    // Replaces one frame with a greeting that has a different plan.
    let changed = copied(&recorded.path, "changed.rec", &|event, _| {
        let t_us = match event {
            Event::Raw(raw) if raw.number == 100 => raw.t_us,
            _ => return,
        };
        *event = hello(Plan::HAND);
        if let Event::Hello(hello) = event {
            hello.t_us = t_us;
        }
    });
    let touch = text(&recorded.path);
    for (arguments, status, parts) in [
        (
            vec![touch, "--positions", text(&late)],
            1,
            &[
                "do not overlap",
                "the frames go from 1769862605",
                "the positions from 1769900000.000",
            ][..],
        ),
        (
            vec![touch, "--positions", text(&wordless)],
            1,
            &[
                "no columns are called position or speed",
                "x, y",
                "--position-column",
            ],
        ),
        (
            vec![
                touch,
                "--positions",
                text(&wordless),
                "--position-column",
                "z",
            ],
            1,
            &["no column z", "x, y"],
        ),
        (
            vec![
                touch,
                "--positions",
                text(&wordless),
                "--position-column",
                "x:furlong",
            ],
            2,
            &["furlong", "choose mm"],
        ),
        (
            vec![touch, "--positions", text(&counts)],
            1,
            &["whole numbers without a unit", "--mm-per-count"],
        ),
        (
            vec![touch, "--positions", text(&gap), "--whole"],
            1,
            &["gap.csv has a gap", "--from"],
        ),
        (
            vec![text(&empty), "--positions", text(&good)],
            1,
            &["empty.rec", "--raw"],
        ),
        (
            vec![text(&unreceived), "--positions", text(&good)],
            1,
            &["unreceived.rec", "no times of receipt", "time_s"],
        ),
        (
            vec![text(&changed), "--positions", text(&good)],
            1,
            &["changed.rec", "the plan changes", "each plan by itself"],
        ),
        (
            vec![text(&good), "--positions", text(&good)],
            1,
            &["record --raw", "--position-column"],
        ),
    ] {
        let found = run(&[&["fit"], &arguments[..]].concat());
        assert_one_line(&found, status, parts);
    }
}
