//! Runs the firmware image, as it is flashed, on the register model of its board, in front of a
//! scene, as fast as possible. [`feed::Emulated`](crate::feed::Emulated) runs it in real time.

pub mod image;

pub use image::Firmware;

use crate::events;
use crate::input::Opened;
use crate::live::Counts;
use crate::requests::Requests;
use crate::stop;
use ads1258::Conversion;
use anyhow::{Result, anyhow, bail, ensure};
use hal_mock::{Constant, Scene};
use ridgetone_emulator::{Board, Emulator, Finding, Start};
use ridgetone_finger::TimedConversion;
use ridgetone_proto::command::{Command, Outcome as Answer};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, PROTOCOL, Packet};
use std::time::Duration;

/// Board time between two exchanges with the PC, nanoseconds.
const STEP_NS: u64 = 1_000_000;

/// Board time in seconds after the end of a scene: enough for the last fit and one more health
/// report.
const TAIL_S: f64 = 1.1;

/// Maximum board time for the firmware to start its converter, seconds.
const PATIENCE_S: f64 = 10.0;

/// Longest wait for the firmware to read the latest conversion at the end, in steps of 10 us.
const LAST_STEPS: usize = 100;

/// Voltage on every input of a processor's own ADC when nothing touches the finger: the middle of a
/// bridge.
const REST_V: f64 = 2.5;

/// FLASH_OPTCR with brown-out level 3, as the guide says to set it (RM0090, 3.9.10).
const OPTION_BYTES: u32 = 0x0FFF_AAE1;

#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    pub firmware: &'a Firmware,
    /// True to fill [`Outcome::conversions`].
    pub keep_conversions: bool,
    /// True to fill [`Outcome::serial`].
    pub keep_serial: bool,
    /// Settings of the firmware; [`run`] sends them after the greeting if they are not the default.
    pub settings: Settings,
    /// Error of the internal oscillator that replaces a dead crystal, parts per million; `None` if
    /// the crystal works.
    pub internal_ppm: Option<i32>,
}

impl<'a> Options<'a> {
    /// Returns the default options: keeps nothing, and does not change the firmware's settings.
    pub fn new(firmware: &'a Firmware) -> Self {
        Self {
            firmware,
            keep_conversions: false,
            keep_serial: false,
            settings: Settings::DEFAULT,
            internal_ppm: None,
        }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Every byte of the telemetry line, if `Options::keep_serial`.
    pub serial: Vec<u8>,
    pub counts: Counts,
    pub conversions_served: u64,
    pub chip: hal_mock::Counters,
    /// Conversions with at least one undamaged read. A conversion that was read only once counts
    /// only if it is the last.
    pub arrived: u64,
    /// Conversions that the board read only once before the next one was ready, so that no second
    /// read confirms them.
    pub read_once: u64,
    /// Times at which injected faults took effect, in nanoseconds of board time.
    pub injected: Vec<hal_mock::Injected>,
    pub registers: [u8; hal_mock::chip::REGISTERS],
    /// Conversions read, with the firmware's time of their DRDY edge, if
    /// `Options::keep_conversions`.
    pub conversions: Vec<TimedConversion>,
    /// Board time in microseconds at which START first rose: scene time zero.
    pub start_us: u64,
    /// Board time in microseconds of the first DRDY edge: device time zero.
    pub first_edge_us: u64,
    /// Board time at the end, microseconds.
    pub end_us: u64,
    /// Rules of the manuals that the firmware has violated.
    pub findings: Vec<Finding>,
}

impl Outcome {
    /// Returns device time zero in scene time (seconds): scene time begins when the board starts
    /// the chip, device time with the first result.
    pub fn zero_s(&self) -> f64 {
        (self.first_edge_us as f64 - self.start_us as f64) / 1e6
    }
}

/// A byte that has left the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SentByte {
    pub byte: u8,
    /// Device time in seconds at the end of the byte's stop bit; 0 before the first conversion.
    pub left_s: f64,
}

/// Takes a packet, and the device time at which its last byte had left the board, seconds.
pub type Sink<'a> = dyn FnMut(&Packet, f64) -> Result<()> + 'a;

/// The PC's end of the line, packet by packet: takes the board's time and a received packet with
/// its [`SentByte::left_s`], and returns the bytes to send. Called for every packet, and without
/// one in each step in which nothing arrives.
pub type Talk<'a> = dyn FnMut(Duration, Option<(&Packet, f64)>) -> Result<Vec<u8>> + 'a;

/// The PC's end of the line: takes the board's time and the received bytes, and returns the bytes
/// to send.
pub type Exchange<'a> = dyn FnMut(Duration, &[SentByte]) -> Result<Vec<u8>> + 'a;

pub fn board(firmware: &Firmware, input: Opened) -> Result<Emulator> {
    board_on(firmware, input, None)
}

/// Returns a board in front of `input`. With `internal_ppm`, its crystal is dead, and its internal
/// oscillator is off by this error (parts per million).
fn board_on(firmware: &Firmware, input: Opened, internal_ppm: Option<i32>) -> Result<Emulator> {
    let start = Start {
        adc: input.options,
        option_bytes: OPTION_BYTES,
        hse_is_dead: internal_ppm.is_some(),
        hsi_ppm: internal_ppm.unwrap_or(0),
        ..Start::default()
    };
    let emulator = Emulator::new(firmware.board, &firmware.image, input.scene, start);
    emulator.map_err(|failure| anyhow!("{failure}"))
}

/// Returns the input of a board while nothing touches the finger.
pub fn untouched(firmware: &Firmware) -> Opened {
    if !Board::OWN_ADC.contains(&firmware.board) {
        return Opened::untouched();
    }
    let scene: Box<dyn Scene> = Box::new(Constant {
        volts: [REST_V; 16],
        ..Constant::default()
    });
    Opened {
        scene,
        ..Opened::untouched()
    }
}

/// Returns scene time in seconds; `None` before the converter has started.
fn scene_s(emulator: &mut Emulator) -> Option<f64> {
    let zero_ns = emulator
        .adc()
        .scene_zero_ns()
        .or_else(|| emulator.sensors_zero_ns())?;
    Some(emulator.now_ns().saturating_sub(zero_ns) as f64 * 1e-9)
}

/// True if a scene of this length is over and the board has had time to report all of it.
pub fn is_over(emulator: &mut Emulator, end_s: f64) -> bool {
    scene_s(emulator).is_some_and(|at_s| at_s >= end_s + TAIL_S)
}

/// Runs the firmware on `input` until the input is over or this process is asked to stop (Ctrl-C).
/// Passes packets to `sink` as they arrive; `progress` takes the seconds of input done so far, and
/// the total. Fails if the firmware does something that is not modelled, does not start or refuses
/// its settings, or if `sink` fails.
pub fn run(
    input: Opened,
    options: Options<'_>,
    sink: &mut Sink<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let mut requests = Requests::new(1);
    if options.settings != Settings::DEFAULT {
        requests.push(Command::Set {
            settings: options.settings,
            keep: false,
        });
    }
    let mut has_greeted = false;
    let mut talk = |now, packet: Option<(&Packet, f64)>| {
        if let Some((packet, left_s)) = packet {
            has_greeted = true;
            sink(packet, left_s)?;
            match requests.answered(&packet.event) {
                None | Some((_, Answer::Done | Answer::DoneErased)) => {}
                Some((_, refused)) => bail!(
                    "the firmware refuses the settings: {}",
                    events::outcome(&refused)
                ),
            }
        }
        if has_greeted {
            requests.due(now)
        } else {
            Ok(Vec::new())
        }
    };
    run_packets(input, options, &mut talk, progress)
}

/// Like [`run`], but the PC also sends.
pub fn run_packets(
    input: Opened,
    options: Options<'_>,
    talk: &mut Talk<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let (mut decoder, mut received) = (Decoder::new(), 0);
    let mut exchange = |now, bytes: &[SentByte]| {
        if bytes.is_empty() {
            return talk(now, None);
        }
        let mut sent = Vec::new();
        for one in bytes {
            if let Some(packet) = decoder.push(one.byte) {
                received += 1;
                sent.extend(talk(now, Some((&packet, one.left_s)))?);
            }
        }
        Ok(sent)
    };
    let outcome = run_bytes(input, options, &mut exchange, progress)?;
    if let Some(protocol) = decoder.foreign {
        bail!(
            "the firmware speaks protocol {protocol}, this command {PROTOCOL}: build both from one version"
        );
    }
    Ok(Outcome {
        counts: Counts::of(&decoder, received),
        ..outcome
    })
}

/// Like [`run_packets`], but exchanges bytes: neither decodes nor counts packets.
pub fn run_bytes(
    input: Opened,
    options: Options<'_>,
    exchange: &mut Exchange<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let end_s = input.end_s;
    let mut emulator = board_on(options.firmware, input, options.internal_ppm)?;
    let (mut outcome, mut first_ns, mut last_ns) = (Outcome::default(), None, None);
    while !stop::is_requested() && !is_over(&mut emulator, end_s) {
        emulator
            .run_ns(STEP_NS)
            .map_err(|failure| anyhow!("the firmware fails: {failure}"))?;
        take_readings(
            &mut emulator,
            options,
            &mut outcome,
            &mut first_ns,
            &mut last_ns,
        );
        let left_s = |at_ns: u64| at_ns.saturating_sub(first_ns.unwrap_or(at_ns)) as f64 / 1e9;
        let sent = emulator.take_sent_timed().into_iter();
        let sent = sent.map(|(byte, at_ns)| SentByte {
            byte,
            left_s: left_s(at_ns),
        });
        let bytes: Vec<SentByte> = sent.collect();
        let now = Duration::from_nanos(emulator.now_ns());
        if options.keep_serial {
            outcome.serial.extend(bytes.iter().map(|sent| sent.byte));
        }
        let reply = exchange(now, &bytes)?;
        if !reply.is_empty() {
            emulator.send(&reply);
        }
        let done_s = scene_s(&mut emulator);
        progress(done_s.unwrap_or(0.0).min(end_s), end_s);
        ensure!(
            done_s.is_some() || now.as_secs_f64() < PATIENCE_S,
            "the firmware has not started its converter within {PATIENCE_S} s of board time"
        );
    }
    // Runs on until every conversion is either read or lost.
    for _ in 0..LAST_STEPS {
        if emulator.adc().latest_drdy_fall_ns() == last_ns {
            break;
        }
        emulator
            .run_ns(10_000)
            .map_err(|failure| anyhow!("the firmware fails: {failure}"))?;
        take_readings(
            &mut emulator,
            options,
            &mut outcome,
            &mut first_ns,
            &mut last_ns,
        );
    }
    let zero_ns = emulator.started_ns().or_else(|| emulator.sensors_zero_ns());
    let us = |ns: Option<u64>| ns.unwrap_or(0) / 1000;
    (outcome.arrived, outcome.read_once) = (emulator.arrived(), emulator.read_once());
    outcome.findings = emulator.findings().to_vec();
    outcome.end_us = emulator.now_ns() / 1000;
    (outcome.start_us, outcome.first_edge_us) = (us(zero_ns), us(first_ns.or(zero_ns)));
    let chip = emulator.adc();
    (outcome.chip, outcome.injected) = (chip.counters(), chip.injected().to_vec());
    outcome.registers = chip.registers();
    Ok(outcome)
}

fn take_readings(
    emulator: &mut Emulator,
    options: Options<'_>,
    outcome: &mut Outcome,
    first_ns: &mut Option<u64>,
    last_ns: &mut Option<u64>,
) {
    let readings = emulator.take_readings();
    if let (Some(first), Some(last)) = (readings.first(), readings.last()) {
        first_ns.get_or_insert(first.edge_ns);
        *last_ns = Some(last.edge_ns);
    }
    outcome.conversions_served += readings.len() as u64;
    if options.keep_conversions {
        outcome.conversions.extend(
            readings
                .iter()
                .map(|one| TimedConversion::new(one.t_us, Conversion::from_bytes(one.bytes))),
        );
    }
}
