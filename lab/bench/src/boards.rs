//! Measures an image as flashed, on the emulator, for `lab/boards.py`: start, load, latency,
//! interrupts and jitter. `boards feather-f405 IMAGE.elf` prints one JSON object.

use hal_mock::{Constant, Options, Scene, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Reading, Served, Start};
use ridgetone_proto::command::{Command, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::{Decoder, Event, Span};
use std::error::Error;
use std::path::Path;

/// Tasks, and their interrupts on the Feather and on the Nucleo.
const TASKS: [(&str, [&[u16]; 2]); 6] = [
    ("line", [&[39], &[38, 39]]),
    ("drdy", [&[10], &[10]]),
    ("detect", [&[74], &[74]]),
    ("report", [&[75], &[75]]),
    ("watch", [&[30], &[30]]),
    ("fit", [&[76], &[76]]),
];

/// Phases of the demo's touch, seconds after START: the contact is at 0.51, the slide from 1.51 to
/// 3.51, the release at 4.51.
const PHASES: [(f64, f64); 3] = [(0.1, 0.4), (0.7, 1.4), (1.6, 3.4)];

/// Clock in hertz at which the simulated chip makes 23,739 conversions a second in the default
/// scan, like the real chip at its fastest setting (SBAS297G: 16 MHz, DRATE 3, no delay). The real
/// chip cannot run at this clock.
const FAST_CLOCK_HZ: u32 = 73_734_000;

/// Number of requests sent while interrupts are measured, and their interval in nanoseconds.
const REQUESTS: u16 = 100;
const REQUEST_NS: u64 = 50_000_000;

/// Interval at which bytes are taken off the line, nanoseconds.
const STEP_NS: u64 = 10_000;

/// Number of bytes sent back to back while jitter is measured.
const BYTES: usize = 20_000;

const CYCLES_US: f64 = 168.0;

type Outcome<T> = Result<T, Box<dyn Error>>;

struct Bench {
    board: Board,
    image: Image,
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [board, path] = &*arguments else {
        return Err("boards BOARD IMAGE.elf".into());
    };
    let bench = Bench {
        board: Board::named(board).ok_or("no such board: feather-f405 or nucleo-f446re")?,
        image: Image::read(Path::new(path))?,
    };
    let fields = [
        ("start_ms", list(&bench.start_ms()?)),
        ("load_percent", list(&bench.load_percent(None)?)),
        (
            "load_fast_percent",
            list(&bench.load_percent(Some(FAST_CLOCK_HZ))?),
        ),
        ("latency_ms", list(&bench.latency_ms()?)),
        (
            "jitter_us",
            list(&[bench.jitter_us(0)?, bench.jitter_us(BYTES)?]),
        ),
        ("tasks", bench.tasks()?),
    ];
    let fields = fields.map(|(name, value)| format!("\"{name}\": {value}"));
    println!("{{{}}}", fields.join(", "));
    Ok(())
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(f64::to_string).collect();
    format!("[{}]", values.join(", "))
}

impl Bench {
    fn emulator(&self, scene: impl Scene + 'static, clock_hz: Option<u32>) -> Outcome<Emulator> {
        let mut start = Start::default();
        start.adc.clock_hz = clock_hz.unwrap_or(Options::default().clock_hz);
        Ok(Emulator::new(self.board, &self.image, scene, start)?)
    }

    /// Returns the times from power-up to START, to the first conversion read, and to the end of
    /// the greeting on the line, and the number of conversions lost meanwhile.
    fn start_ms(&self) -> Outcome<[f64; 4]> {
        let mut emulator = self.emulator(Constant::default(), None)?;
        let mut decoder = Decoder::new();
        let is_greeting = |event: Event| matches!(event, Event::Hello(_));
        while !emulator.take_sent().into_iter().any(|byte| {
            decoder
                .push(byte)
                .is_some_and(|packet| is_greeting(packet.event))
        }) {
            emulator.run_ns(STEP_NS)?;
        }
        let greeted_ns = emulator.now_ns();
        let started_ns = emulator.started_ns().ok_or("START never rises")?;
        let readings = emulator.readings();
        let first_ns = readings.first().ok_or("no conversion is read")?.edge_ns;
        let ms = |ns: u64| ns as f64 * 1e-6;
        let lost = emulator.adc().counters().lost;
        Ok([ms(started_ns), ms(first_ns), ms(greeted_ns), lost as f64])
    }

    /// Returns the percentage of time that the processor is awake in each phase of the demo's
    /// touch.
    fn load_percent(&self, clock_hz: Option<u32>) -> Outcome<Vec<f64>> {
        let mut emulator = self.emulator(SlidingScene::new(Sliding::default())?, clock_hz)?;
        while emulator.started_ns().is_none() {
            emulator.run_ns(1_000_000)?;
        }
        let start_ns = emulator.now_ns();
        let mut loads = Vec::new();
        for (from_s, to_s) in PHASES {
            emulator.run_until(start_ns + (from_s * 1e9) as u64)?;
            let before = emulator.cycles();
            emulator.run_until(start_ns + (to_s * 1e9) as u64)?;
            let now = emulator.cycles();
            let [all, asleep] = [now.0 - before.0, now.1 - before.1].map(|cycles| cycles as f64);
            loads.push(100.0 * (all - asleep) / all);
        }
        Ok(loads)
    }

    /// Returns the mean and maximum time from the last frame of a window in the demo's slide to the
    /// last byte of its estimate on the line, and the number of windows.
    fn latency_ms(&self) -> Outcome<[f64; 3]> {
        let mut emulator = self.emulator(SlidingScene::new(Sliding::default())?, None)?;
        let (mut decoder, mut late_ms, mut first_ns) = (Decoder::new(), Vec::new(), None);
        while emulator.now_ns() < 6_000_000_000 {
            emulator.run_ns(STEP_NS)?;
            let edge_ns = emulator.readings().first().map(|reading| reading.edge_ns);
            first_ns = first_ns.or(edge_ns);
            for byte in emulator.take_sent() {
                if let Some(packet) = decoder.push(byte)
                    && let Event::Estimate(estimate) = packet.event
                    && estimate.span == Span::Window
                {
                    let end_ns = first_ns.unwrap_or(0) + 1000 * estimate.t_us;
                    late_ms.push((emulator.now_ns() - end_ns) as f64 * 1e-6);
                }
            }
        }
        let mean = late_ms.iter().sum::<f64>() / late_ms.len().max(1) as f64;
        let longest = late_ms.iter().copied().fold(0.0, f64::max);
        Ok([mean, longest, late_ms.len() as f64])
    }

    /// Measures the tasks' interrupts during the demo's touch while requests arrive. Returns JSON
    /// by task: number of runs, mean and maximum run and wait, microseconds.
    fn tasks(&self) -> Outcome<String> {
        let mut emulator = self.emulator(SlidingScene::new(Sliding::default())?, None)?;
        emulator.run_ns(400_000_000)?;
        emulator.forget_served();
        for number in 1..=REQUESTS {
            let (mut wire, command) = ([0; REQUEST_WIRE_MAX], Command::Greet);
            let length = framing::encode(&Request { number, command }, &mut wire)
                .map_err(|_| "a request that cannot be encoded")?;
            emulator.send(&wire[..length]);
            emulator.run_ns(REQUEST_NS)?;
        }
        let at = usize::from(self.board == Board::NucleoF446re);
        let row = |(name, irqs): &(&str, [&[u16]; 2])| {
            let served: Vec<_> = irqs[at].iter().map(|irq| emulator.served(*irq)).collect();
            let sum = |of: fn(&Served) -> u64| served.iter().map(of).sum::<u64>() as f64;
            let max = |of: fn(&Served) -> u64| served.iter().map(of).max().unwrap_or(0) as f64;
            let times = sum(|one| one.times);
            let figures = [
                sum(|one| one.run_cycles) / times.max(1.0),
                max(|one| one.longest_run_cycles),
                sum(|one| one.wait_cycles) / times.max(1.0),
                max(|one| one.longest_wait_cycles),
            ];
            let figures = figures.map(|cycles| cycles / CYCLES_US);
            format!("\"{name}\": {}", list(&[&[times], &figures[..]].concat()))
        };
        Ok(format!("{{{}}}", TASKS.map(|task| row(&task)).join(", ")))
    }

    /// Returns the jitter of the time stamps relative to the edges of DRDY while `bytes` bytes
    /// arrive.
    fn jitter_us(&self, bytes: usize) -> Outcome<f64> {
        let mut emulator = self.emulator(Constant::default(), None)?;
        emulator.run_ns(500_000_000)?;
        emulator.take_readings();
        emulator.send(&vec![0x55; bytes]);
        emulator.run_ns(200_000_000)?;
        let late_us = |reading: &Reading| f64::from(reading.t_us) - reading.edge_ns as f64 * 1e-3;
        let late: Vec<f64> = emulator.readings().iter().map(late_us).collect();
        let min = late.iter().copied().fold(f64::INFINITY, f64::min);
        Ok(late.iter().copied().fold(f64::NEG_INFINITY, f64::max) - min)
    }
}
