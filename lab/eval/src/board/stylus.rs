//! The stylus in figures: its image under a simulated hand, while requests arrive one behind the
//! other.

use super::CYCLES_US;
use crate::page::{Table, fixed};
use anyhow::{Context, Result, anyhow, ensure};
use hal_mock::Constant;
use ridgetone_emulator::{Board, Emulator, Image, Output, Start};
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_stimulus::{Actuator, Harmonic, Texture};
use ridgetone_stylus::message::{Command, Decoder, Event, Health, Mark, Request};
use ridgetone_stylus::parameters::Parameters;
use ridgetone_stylus::{SAMPLE_HZ, SAMPLE_US};
use serde_json::Value;
use std::f64::consts::TAU;

/// TIM6's interrupt (RM0090, table 61).
const IRQ_TIM6: u16 = 54;

/// How long each case is measured, seconds.
const CASE_S: f64 = 3.0;

/// Speed of the hand, millimetres per second: the fastest of Okamoto et al. (section IV).
const HAND_MM_S: f64 = 230.0;

/// To and fro: a triangle of 2 s.
fn place_mm(t_s: f64) -> f64 {
    HAND_MM_S * (1.0 - ((t_s / 2.0).fract() * 2.0 - 1.0).abs())
}

struct Bench {
    emulator: Emulator,
    decoder: Decoder,
    number: u16,
    health: Option<Health>,
}

/// Cells of a column.
struct Case(Vec<Value>);

impl Bench {
    fn new() -> Result<Self> {
        let image = Image::built(Board::StylusF405)?;
        let emulator = Emulator::new(
            Board::StylusF405,
            &image,
            Constant::default(),
            Start::default(),
        )?;
        let mut bench = Self {
            emulator,
            decoder: Decoder::new(),
            number: 0,
            health: None,
        };
        bench.run_s(0.1)?;
        Ok(bench)
    }

    fn run_s(&mut self, s: f64) -> Result<()> {
        self.emulator.run_ns((s * 1e9) as u64)?;
        for packet in self
            .emulator
            .take_sent()
            .into_iter()
            .filter_map(|byte| self.decoder.push(byte))
        {
            if let Event::Health(health) = packet.event.0 {
                self.health = Some(health);
            }
        }
        Ok(())
    }

    fn request(&mut self, command: Command) -> Result<Vec<u8>> {
        self.number = self.number.wrapping_add(1);
        let mut wire = [0; REQUEST_WIRE_MAX];
        let request = Request {
            number: self.number,
            command: Mark(command),
        };
        let length = framing::encode(&request, &mut wire).map_err(|_| anyhow!("a request"))?;
        Ok(wire[..length].to_vec())
    }

    fn send(&mut self, command: Command) -> Result<()> {
        let bytes = self.request(command)?;
        self.emulator.send(&bytes);
        self.run_s(0.01)
    }
}

/// Measures a texture under an actuator.
fn case(texture: Texture, actuator: Actuator) -> Result<Case> {
    let mut bench = Bench::new()?;
    bench.send(Command::Configure(Parameters {
        actuator,
        ..Parameters::DEFAULT
    }))?;
    bench.send(Command::Texture(texture))?;
    bench.send(Command::Enable)?;
    let (from_ns, count_mm) = (
        bench.emulator.now_ns(),
        f64::from(Parameters::DEFAULT.count_mm),
    );
    let place = move |ns: u64| place_mm((ns as f64 - from_ns as f64) * 1e-9);
    bench
        .emulator
        .move_hand(move |ns| (place(ns) / count_mm).floor() as i64);
    bench.run_s(0.2)?;
    bench.emulator.forget_served();
    let (reads, outputs) = (
        bench.emulator.encoder_reads_ns().len(),
        bench.emulator.outputs().len(),
    );
    let (cycles, asleep) = bench.emulator.cycles();
    for _ in 0..(CASE_S * 10.0) as u32 {
        // 0.1 s are 9.2 kB.
        let many: Result<Vec<_>> = (0..500).map(|_| bench.request(Command::Alive)).collect();
        bench.emulator.send(&many?.concat());
        bench.run_s(0.1)?;
    }
    let (cycles, asleep) = (
        bench.emulator.cycles().0 - cycles,
        bench.emulator.cycles().1 - asleep,
    );
    let served = bench.emulator.served(IRQ_TIM6);
    let outputs = &bench.emulator.outputs()[outputs..];
    let reads_ns = &bench.emulator.encoder_reads_ns()[reads..];
    let periods: Vec<u64> = outputs
        .windows(2)
        .map(|pair| pair[1].at_ns - pair[0].at_ns)
        .collect();
    // The first output may belong to a reading before.
    let delays: Vec<u64> = reads_ns
        .iter()
        .zip(&outputs[1..])
        .map(|(read, out)| out.at_ns.saturating_sub(*read))
        .collect();
    let (least, most) =
        |of: &[u64]| -> Option<(u64, u64)> { Some((*of.iter().min()?, *of.iter().max()?)) }(
            &delays,
        )
        .context("no reading")?;
    let jitter_ns = periods
        .iter()
        .map(|ns| ns.abs_diff(1000 * u64::from(SAMPLE_US)))
        .max()
        .context("no output")?;
    let [amplitude, phase] = against(outputs, place, &texture, &actuator);
    let us = |cycles: f64| fixed(cycles / CYCLES_US, 1);
    let mean = |cycles: u64| cycles as f64 / served.times.max(1) as f64;
    // Without the requests: the latest `health` of theirs.
    let health = bench.health.context("no health")?;
    ensure!(
        health.samples > SAMPLE_HZ,
        "health is older than the measurement"
    );
    Ok(Case(vec![
        us(mean(served.run_cycles)),
        us(served.longest_run_cycles as f64),
        us(served.longest_wait_cycles as f64),
        health.deadlines_missed.into(),
        jitter_ns.into(),
        fixed(least as f64 * 1e-3, 1),
        fixed(most as f64 * 1e-3, 1),
        fixed(100.0 * (amplitude - 1.0), 2),
        fixed(phase, 4),
        fixed((cycles - asleep) as f64 / cycles as f64 * 100.0, 1),
    ]))
}

/// Amplitude over the true one, and phase against the place of the hand at the middle of each
/// output, cycles: of the fundamental.
fn against(
    outputs: &[Output],
    place: impl Fn(u64) -> f64,
    texture: &Texture,
    actuator: &Actuator,
) -> [f64; 2] {
    let (mut ys, mut yc, mut ss) = (0.0, 0.0, 0.0);
    for output in outputs {
        let volts = f64::from(output.code.unwrap_or(0)) / 4095.0 * f64::from(actuator.voltage_v);
        let y = volts - f64::from(actuator.bias_v());
        let (s, c) = (TAU * place(output.at_ns + 500 * u64::from(SAMPLE_US))
            / f64::from(texture.period_mm))
        .sin_cos();
        (ys, yc, ss) = (ys + y * s, yc + y * c, ss + s * s);
    }
    let peak = 1.0
        + texture
            .overtones
            .iter()
            .map(|one| f64::from(one.amplitude))
            .sum::<f64>();
    // Less where the actuator moves more: a second order (Actuator::resonance).
    let (at_hz, gain) = (
        f64::from(actuator.resonance.0),
        f64::from(actuator.resonance.1),
    );
    let ratio = HAND_MM_S / f64::from(texture.period_mm) / at_hz;
    let share = if at_hz > 0.0 {
        (1.0 - ratio * ratio).hypot(ratio / gain)
    } else {
        1.0
    };
    let true_v = f64::from(actuator.bias_v()) / peak * share;
    [(ys / ss).hypot(yc / ss) / true_v, yc.atan2(ys) / TAU]
}

/// The two cases' names.
const CASES: [&str; 2] = ["a sine", "three overtones, a resonance"];

const ROWS: [&str; 10] = [
    "the interrupt of a sample, mean, us",
    "the same, longest, with the line's in between, us",
    "from the trigger to its first instruction, longest, us",
    "samples that were not there in time",
    "jitter of the output, greatest, ns",
    "from the reading of the encoder to the output, least, us",
    "the same, greatest, us",
    "amplitude of the fundamental, error, %",
    "its phase against the place of the hand, cycles",
    "the processor is busy, %",
];

/// The table of the page.
pub fn table() -> Result<Table> {
    // By its power: the full amplitude.
    let sine = Texture {
        power: 6000.0,
        ..Texture::new(2.0)
    };
    let overtone = |phase_cycles| Harmonic {
        amplitude: 0.2,
        phase_cycles,
    };
    let full = Texture {
        overtones: [0.1, -0.7, 0.4].map(overtone),
        ..sine
    };
    let resonance = Actuator {
        resonance: (1000.0, 3.0),
        cutoff_hz: 1000.0,
        ..Actuator::PIEZO
    };
    let cases = [case(sine, Actuator::PIEZO)?, case(full, resonance)?];
    let mut table = Table::new(&format!("|{}", CASES.join("|")));
    for (row, name) in ROWS.iter().enumerate() {
        let cells = cases.iter().map(|case| case.0[row].clone());
        table.row([Value::from(*name)].into_iter().chain(cells));
    }
    Ok(table)
}
