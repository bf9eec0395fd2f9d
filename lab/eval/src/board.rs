//! The boards in figures: start, load, interrupts and jitter of the images that get flashed, on the
//! register model, for docs/results/boards.md.

use crate::page::{self, Bar, Figures, Table, Tables, fixed};
use anyhow::{Context, Result, anyhow};
use hal_mock::{Constant, Options, Scene, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_proto::command::{Command, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::{Decoder, Event};
use serde_json::Value;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct BoardArgs {
    /// Write boards.json into a folder, and fill in boards.md there.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results")]
    write: Option<PathBuf>,
}

/// Interrupt of the task `fit`, on both boards.
pub const FIT_IRQ: u16 = 76;

/// Tasks, and their interrupts on the Feather and on the Nucleo.
const TASKS: [(&str, [&[u16]; 2]); 6] = [
    ("`line`", [&[39], &[38, 39]]),
    ("`drdy`", [&[10], &[10]]),
    ("`detect`", [&[74], &[74]]),
    ("`report`", [&[75], &[75]]),
    ("`watch`", [&[30], &[30]]),
    ("`fit`", [&[FIT_IRQ], &[FIT_IRQ]]),
];

/// Phases of the demo's touch, seconds after START: the contact is at 0.51, the slide from 1.51 to
/// 3.51, the release at 4.51.
const PHASES: [(&str, f64, f64); 3] = [
    ("at rest", 0.1, 0.4),
    ("contact", 0.7, 1.4),
    ("sliding, with fits", 1.6, 3.4),
];

/// Clock of a simulated chip that makes 23,739 conversions a second of the default scan, hertz: the
/// most that the real one does by any setting (SBAS297G: 16 MHz, DRATE 3, no delay). No real chip
/// bears this clock.
const FAST_CLOCK_HZ: u32 = 73_734_000;

/// Requests a second while interrupts are measured.
const REQUESTS_HZ: f64 = 20.0;

/// The processor's clock, cycles in a microsecond.
const CYCLES_US: f64 = 168.0;

/// What is measured of a board, as cells of the tables.
struct Measured {
    /// Start, load and jitter.
    figures: Vec<Value>,
    tasks: Vec<Vec<Value>>,
}

struct Bench {
    board: Board,
    image: Image,
}

impl Bench {
    fn emulator(&self, scene: impl Scene + 'static, clock_hz: Option<u32>) -> Result<Emulator> {
        let mut start = Start::default();
        start.adc.clock_hz = clock_hz.unwrap_or(Options::default().clock_hz);
        Ok(Emulator::new(self.board, &self.image, scene, start)?)
    }

    /// Milliseconds from power-up to START, to the first conversion that is read and to the
    /// greeting's end on the line, and conversions that are lost meanwhile.
    fn start(&self) -> Result<Vec<Value>> {
        let mut emulator = self.emulator(Constant::default(), None)?;
        let mut decoder = Decoder::new();
        let is_greeting = |event: Event| matches!(event, Event::Hello(_));
        while !emulator.take_sent().into_iter().any(|byte| {
            decoder
                .push(byte)
                .is_some_and(|packet| is_greeting(packet.event))
        }) {
            emulator.run_ns(10_000)?;
        }
        let greeted_ns = emulator.now_ns();
        let started_ns = emulator.started_ns().context("START never rises")?;
        let first_ns = emulator
            .readings()
            .first()
            .context("no conversion is read")?
            .edge_ns;
        let ms = |ns: u64| fixed(ns as f64 * 1e-6, 1);
        Ok(vec![
            ms(started_ns),
            ms(first_ns),
            ms(greeted_ns),
            emulator.adc().counters().lost.into(),
        ])
    }

    /// Shares of time that the processor is awake in each phase of the demo's touch, percent.
    fn load(&self, clock_hz: Option<u32>) -> Result<Vec<Value>> {
        let mut emulator = self.emulator(SlidingScene::new(Sliding::default())?, clock_hz)?;
        while emulator.started_ns().is_none() {
            emulator.run_ns(1_000_000)?;
        }
        let start_ns = emulator.now_ns();
        let at = |s: f64| start_ns + (s * 1e9) as u64;
        PHASES
            .iter()
            .map(|(_, from_s, to_s)| {
                emulator.run_until(at(*from_s))?;
                let before = emulator.cycles();
                emulator.run_until(at(*to_s))?;
                let (cycles, asleep) = (
                    emulator.cycles().0 - before.0,
                    emulator.cycles().1 - before.1,
                );
                Ok(fixed((cycles - asleep) as f64 / cycles as f64 * 100.0, 1))
            })
            .collect()
    }

    /// How the tasks' interrupts are served over the demo's touch while requests arrive.
    fn tasks(&self) -> Result<Vec<Vec<Value>>> {
        let mut emulator = self.emulator(SlidingScene::new(Sliding::default())?, None)?;
        emulator.run_ns(400_000_000)?;
        emulator.forget_served();
        for number in 1..=(5.0 * REQUESTS_HZ) as u16 {
            emulator.send(&request(number, Command::Greet)?);
            emulator.run_ns((1e9 / REQUESTS_HZ) as u64)?;
        }
        let at = usize::from(self.board == Board::NucleoF446re);
        let row = |(_, irqs): &(&str, [&[u16]; 2])| {
            let served: Vec<_> = irqs[at].iter().map(|irq| emulator.served(*irq)).collect();
            let sum =
                |of: fn(&ridgetone_emulator::Served) -> u64| served.iter().map(of).sum::<u64>();
            let most = |of: fn(&ridgetone_emulator::Served) -> u64| {
                served.iter().map(of).max().unwrap_or(0)
            };
            let times = sum(|one| one.times);
            let mean = |cycles: u64| cycles as f64 / times.max(1) as f64;
            let us = |cycles: f64| fixed(cycles / CYCLES_US, 1);
            let run = [
                mean(sum(|one| one.run_cycles)),
                most(|one| one.longest_run_cycles) as f64,
            ]
            .map(us);
            let wait = [
                mean(sum(|one| one.wait_cycles)),
                most(|one| one.longest_wait_cycles) as f64,
            ]
            .map(us);
            [vec![Value::from(times)], run.to_vec(), wait.to_vec()].concat()
        };
        Ok(TASKS.iter().map(row).collect())
    }

    /// Greatest less least difference of the time stamps from the edges of DRDY, microseconds, with
    /// and without bytes that arrive one behind the other.
    fn jitter(&self) -> Result<Vec<Value>> {
        let spread = |bytes: usize| {
            let mut emulator = self.emulator(Constant::default(), None)?;
            emulator.run_ns(500_000_000)?;
            emulator.take_readings();
            emulator.send(&vec![0x55; bytes]);
            emulator.run_ns(200_000_000)?;
            let late = |reading: &ridgetone_emulator::Reading| {
                f64::from(reading.t_us) - reading.edge_ns as f64 * 1e-3
            };
            let late: Vec<f64> = emulator.readings().iter().map(late).collect();
            let (least, most) = late.iter().fold((f64::MAX, f64::MIN), |(a, b), late| {
                (a.min(*late), b.max(*late))
            });
            Ok(fixed(most - least, 1))
        };
        [0, 20_000].into_iter().map(spread).collect()
    }
}

/// A request as it travels.
pub fn request(number: u16, command: Command) -> Result<Vec<u8>> {
    let mut wire = [0; REQUEST_WIRE_MAX];
    let length = framing::encode(&Request { number, command }, &mut wire)
        .map_err(|_| anyhow!("a request"))?;
    Ok(wire[..length].to_vec())
}

/// Measures each board.
pub fn measure() -> Result<Tables> {
    let one = |board| {
        let bench = Bench {
            board,
            image: Image::built(board)?,
        };
        let loads = [bench.load(None)?, bench.load(Some(FAST_CLOCK_HZ))?].concat();
        Ok(Measured {
            figures: [bench.start()?, loads, bench.jitter()?].concat(),
            tasks: bench.tasks()?,
        })
    };
    let boards = Board::ALL
        .into_iter()
        .map(one)
        .collect::<Result<Vec<_>>>()?;
    let loads = ["5064", "23,739"].map(|rate| {
        PHASES.map(|(phase, ..)| format!("load {phase}, {rate} conversions a second, %"))
    });
    let names = [
        "from power-up to START, ms",
        "from power-up to the first conversion that is read, ms",
        "from power-up to the end of `hello` on the line, ms",
        "conversions lost at the start",
    ];
    let jitter = ["no byte arrives", "bytes arrive one behind the other"];
    let jitter = jitter.map(|case| format!("jitter of time stamps, {case}, us"));
    let names = names
        .map(str::to_owned)
        .into_iter()
        .chain(loads.concat())
        .chain(jitter);
    let mut figures = Table::new(&format!("|{}", Board::ALL.map(Board::name).join("|")));
    for (row, name) in names.enumerate() {
        let cells = boards.iter().map(|board| board.figures[row].clone());
        figures.row([Value::from(name)].into_iter().chain(cells));
    }
    let mut tasks =
        Table::new("board|task|runs|mean, us|longest, us|mean wait, us|longest wait, us");
    for (board, measured) in Board::ALL.into_iter().zip(&boards) {
        for ((task, _), cells) in TASKS.iter().zip(&measured.tasks) {
            let names = [Value::from(board.name()), Value::from(*task)];
            tasks.row(names.into_iter().chain(cells.iter().cloned()));
        }
    }
    Ok(with_bars(Tables::from([
        ("boards".into(), figures),
        ("tasks".into(), tasks),
    ])))
}

/// What the figures must be: of rows by the beginning of their names, the greatest.
const BARS: [(&str, &str, usize, f64); 2] = [
    ("boards", "conversions lost at the start", 1, 0.0),
    // A byte lasts 10.9 us, and the USART holds one.
    ("tasks", "`line`", 6, 10.9),
];

/// The tables with that of the bars.
pub fn with_bars(mut tables: Tables) -> Tables {
    let bars = BARS.map(|(table, name, from, most)| {
        let rows = tables.get(table).into_iter().flat_map(|table| &table.rows);
        let own = rows.filter(|row| row.iter().any(|cell| cell == name));
        let figures = own.flat_map(|row| row.iter().skip(from).filter_map(Value::as_f64));
        let greatest = figures.reduce(f64::max);
        let what = match table {
            "tasks" => format!("{name}, longest wait, us"),
            _ => name.to_owned(),
        };
        Bar {
            bar: what,
            limit: format!("at most {most}"),
            measured: greatest.map_or_else(|| "-".into(), |figure| figure.to_string()),
            met: greatest.is_some_and(|figure| figure <= most),
        }
    });
    tables.insert("bars".into(), page::bars(&bars));
    tables
}

/// The command.
pub fn run(args: &BoardArgs) -> Result<()> {
    let tables = measure()?;
    match &args.write {
        Some(folder) => page::write(
            folder,
            "boards",
            &Figures {
                tables,
                detail: page::None {},
            },
        ),
        None => page::print(&tables),
    }
}
