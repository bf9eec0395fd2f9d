//! `emulate`: the firmware image itself, in QEMU, with the simulated chip at the other end of its bridge.
//!
//! One loop serves four pipes: the bridge's requests, the telemetry, QEMU's messages, and the log. It looks at the process
//! whenever they are silent, so that it ends whichever way the emulator does.

mod chip_end;
pub mod image;
mod log;
pub mod process;

pub use chip_end::ChipEnd;
pub use process::QEMU;

use crate::events;
use crate::input::Opened;
use crate::requests::Requests;
use crate::stop;
use anyhow::{Context, Result, bail};
use hal_mock::bridge::{Crash, PAYLOAD_MAX, REQUEST_BYTES, Request};
use log::Log;
use process::Emulator;
use ridgetone::frame::TimedConversion;
use ridgetone_proto::command::{Command, Outcome as Answer};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, PROTOCOL, Packet};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{ErrorKind, Read};
use std::os::fd::AsFd;
use std::path::Path;
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// How often the process is looked at while its pipes are silent, nanoseconds.
const LOOK_NS: i64 = 50_000_000;

/// Board time that the firmware has to start the chip, and to read the last result after the input's end, seconds.
const PATIENCE_S: f64 = 10.0;

/// 8 ns an instruction: 125 MIPS, about what the STM32F405 does at 168 MHz.
const ICOUNT_SHIFT: u8 = 3;

/// What to run, and how long to wait for it.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The firmware image.
    pub elf: &'a Path,
    /// Wall time without a sign of life after which the emulator is given up.
    pub silence: Duration,
    /// Whether [`Outcome::conversions`] is wanted.
    pub keep_conversions: bool,
    /// Whether [`Outcome::serial`] is wanted.
    pub keep_serial: bool,
    /// What is to happen to the board, and at what time of its, microseconds.
    pub crash: Option<(u64, Crash)>,
    /// An instruction takes two to the power of this nanoseconds: 3 is 125 million a second.
    pub icount_shift: u8,
    /// From when until when the telemetry line is blocked, seconds of scene time.
    pub line_blocked_s: Option<(f64, f64)>,
    /// Settings of the firmware: others than its own are sent to it as soon as it has greeted. [`run`] alone does that.
    pub settings: Settings,
    /// What is to be told each line of the firmware's log: board time in seconds, level, text.
    pub log: Option<fn(&str)>,
}

impl<'a> Options<'a> {
    /// Half a minute of silence at the most; nothing is kept that grows with the run, nothing happens to the board; the
    /// processor has its usual speed.
    pub fn new(elf: &'a Path) -> Self {
        Self {
            elf,
            silence: Duration::from_secs(30),
            keep_conversions: false,
            keep_serial: false,
            crash: None,
            icount_shift: ICOUNT_SHIFT,
            line_blocked_s: None,
            settings: Settings::DEFAULT,
            log: None,
        }
    }
}

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Every byte of the telemetry line, if [`Options::keep_serial`].
    pub serial: Vec<u8>,
    /// What the firmware and the emulator said beside it, line by line.
    pub messages: String,
    /// Packets received.
    pub received: u64,
    /// Packets that never came, by their numbers.
    pub missing: u32,
    /// Packets whose checksum was wrong.
    pub damaged: u32,
    /// Conversions that the board has read.
    pub conversions_served: u64,
    /// Conversions that were overwritten before the board came.
    pub conversions_lost: u64,
    /// What the chip has done.
    pub chip: hal_mock::Counters,
    /// Conversions of which at least one read arrived at the board as they were converted.
    pub arrived: u64,
    /// When each injected fault acted, nanoseconds of board time.
    pub injected: Vec<hal_mock::Injected>,
    /// The chip's registers at the end.
    pub registers: [u8; hal_mock::chip::REGISTERS],
    /// Those read, with the board's time of their DRDY edge, if [`Options::keep_conversions`].
    pub conversions: Vec<TimedConversion>,
    /// Board time at which START first rose, microseconds: zero of the scene's time.
    pub start_us: u64,
    /// Board time of the first DRDY edge, microseconds: zero of the device time, in which events are told.
    pub first_edge_us: u64,
    /// Board time at the end, microseconds.
    pub end_us: u64,
}

/// What a PC does on the line: it is given the board's time and the packet that has come, if one has, and gives the bytes
/// to be sent. It is asked with every packet and, without one, whenever something has come from the board.
pub type Talk<'a> = dyn FnMut(Duration, Option<&Packet>) -> Result<Vec<u8>> + 'a;

/// Runs the firmware on `input` until the input is over and the firmware has left, or this process is asked to end ([`stop`]). Packets go to `sink` as they come;
/// `progress` is told the seconds of the input done and those to do.
///
/// # Errors
/// The image is not ours, the emulator is missing or fails, the firmware fails, falls silent or refuses its settings; those of
/// `sink`. The emulator is gone by then in any case.
pub fn run(
    input: Opened,
    options: Options<'_>,
    sink: &mut dyn FnMut(&Packet) -> Result<()>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let mut requests = Requests::new(1);
    if options.settings != Settings::DEFAULT {
        requests.give(Command::Set { settings: options.settings, keep: false });
    }
    let mut has_greeted = false;
    let mut talk = |now, packet: Option<&Packet>| {
        if let Some(packet) = packet {
            has_greeted = true;
            sink(packet)?;
            match requests.hear(&packet.event) {
                None | Some((_, Answer::Done | Answer::DoneErased)) => {}
                Some((_, refused)) => bail!("the firmware does not take the settings: {}", events::outcome(&refused)),
            }
        }
        if has_greeted { requests.due(now) } else { Ok(Vec::new()) }
    };
    run_talking(input, options, &mut talk, progress)
}

/// The same with somebody at the PC's end of the line who sends too. When what is sent arrives depends on how fast this PC
/// is: such a run does not repeat to the bit.
///
/// # Errors
/// Those of [`run`].
pub fn run_talking(
    input: Opened,
    options: Options<'_>,
    talk: &mut Talk<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let (mut decoder, mut received) = (Decoder::new(), 0);
    let mut wire = |now, bytes: &[u8]| {
        if bytes.is_empty() {
            return talk(now, None);
        }
        let mut said = Vec::new();
        for packet in bytes.iter().filter_map(|byte| decoder.push(*byte)) {
            received += 1;
            said.extend(talk(now, Some(&packet))?);
        }
        Ok(said)
    };
    let outcome = run_wired(input, options, &mut wire, progress)?;
    if let Some(protocol) = decoder.foreign {
        bail!("the firmware speaks protocol {protocol}, this command {PROTOCOL}: build both from one version");
    }
    Ok(Outcome { received, missing: decoder.missing, damaged: decoder.damaged, ..outcome })
}

/// What is at the other end of the line: it is given the board's time and the bytes that have come, and gives those to be
/// sent. Without bytes it is asked whenever something else has come from the board.
pub type Wire<'a> = dyn FnMut(Duration, &[u8]) -> Result<Vec<u8>> + 'a;

/// The same with the line's bytes as they are: nothing is decoded, and nothing counted, here.
///
/// # Errors
/// Those of [`run`], but for what the bytes say.
pub fn run_wired(
    input: Opened,
    options: Options<'_>,
    wire: &mut Wire<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let image = image::check(options.elf)?;
    let mut chip = ChipEnd::new(input, options.keep_conversions).blocking(options.line_blocked_s);
    if let Some((at_us, crash)) = options.crash {
        chip.arrange(at_us, crash);
    }
    let log = options.log.map(|tell| Log::new(&image, tell)).transpose()?;
    let emulator = Emulator::start(&image, options.icount_shift)?;
    let mut session = Session {
        emulator,
        chip,
        incoming: Vec::new(),
        serial: options.keep_serial.then(Vec::new),
        messages: Vec::new(),
        log,
        open: [true; 4],
        heard: Instant::now(),
    };
    let status = match session.serve(options.silence, wire, progress) {
        // Ctrl-C may have reached the emulator first.
        Err(_) if stop::is_asked() => None,
        status => status?,
    };
    session.conclude(status)
}

/// Pipes, in the order in which they are served.
const REQUESTS: usize = 0;
const SERIAL: usize = 1;
const MESSAGES: usize = 2;
const LOG: usize = 3;

struct Session {
    emulator: Emulator,
    chip: ChipEnd,
    /// Bytes of requests that have not come in full.
    incoming: Vec<u8>,
    serial: Option<Vec<u8>>,
    /// What the emulator said on its standard error.
    messages: Vec<u8>,
    log: Option<Log>,
    /// Pipes whose other end has not been closed.
    open: [bool; 4],
    heard: Instant,
}

impl Session {
    /// Serves it until it has ended, and gives how, or until this process is asked to end.
    fn serve(
        &mut self,
        silence: Duration,
        wire: &mut Wire<'_>,
        progress: &mut dyn FnMut(f64, f64),
    ) -> Result<Option<ExitStatus>> {
        while !stop::is_asked() {
            if self.turn(LOOK_NS, wire)? {
                self.heard = Instant::now();
                self.emulator.send(&wire(Duration::from_micros(self.chip.now_us()), &[])?)?;
                let (done_s, end_s) = self.chip.progress_s();
                progress(done_s, end_s);
                if self.chip.start_us().is_none() && self.chip.now_us() as f64 * 1e-6 > PATIENCE_S {
                    bail!("the firmware has not started the chip within {PATIENCE_S} s of board time{}", self.said());
                }
                if done_s > end_s + PATIENCE_S {
                    bail!("the firmware has stopped reading the chip{}", self.said());
                }
            } else if let Some(status) = self.emulator.exit_status()? {
                // What it wrote before it ended; something it left behind may hold the pipes open, so no waiting.
                while self.turn(0, wire)? {}
                return Ok(Some(status));
            } else if self.heard.elapsed() > silence {
                let when = if self.chip.ended() { " after the end of the input" } else { "" };
                bail!("{QEMU}: no sign of life from the firmware for {} s{when}{}", silence.as_secs_f32(), self.said());
            }
        }
        Ok(None)
    }

    /// Waits up to `most_ns` for something to come, and serves it. False if nothing came.
    fn turn(&mut self, most_ns: i64, wire: &mut Wire<'_>) -> Result<bool> {
        let emulator = &self.emulator;
        let pipes =
            [emulator.request.as_fd(), emulator.serial.as_fd(), emulator.messages.as_fd(), emulator.log.as_fd()];
        let mut fds: Vec<PollFd<'_>> = Vec::with_capacity(pipes.len());
        let mut which = Vec::with_capacity(pipes.len());
        for (at, pipe) in pipes.iter().enumerate().filter(|(at, _)| self.open[*at]) {
            fds.push(PollFd::new(pipe, PollFlags::IN));
            which.push(at);
        }
        match poll(&mut fds, Some(&Timespec { tv_sec: 0, tv_nsec: most_ns })) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error).context("poll"),
        }
        let ready: Vec<usize> =
            which.iter().zip(&fds).filter(|(_, fd)| !fd.revents().is_empty()).map(|(at, _)| *at).collect();
        let mut came = false;
        for at in ready {
            came |= self.receive(at, wire)?;
        }
        Ok(came)
    }

    /// Reads from one pipe that is ready. False at its end.
    fn receive(&mut self, at: usize, wire: &mut Wire<'_>) -> Result<bool> {
        let mut bytes = [0; 4096];
        let read = match at {
            REQUESTS => self.emulator.request.read(&mut bytes),
            SERIAL => self.emulator.serial.read(&mut bytes),
            MESSAGES => self.emulator.messages.read(&mut bytes),
            _ => self.emulator.log.read(&mut bytes),
        };
        let length = match read {
            Ok(length) => length,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => return Ok(false),
            Err(error) => return Err(error).context(QEMU),
        };
        self.open[at] = length > 0;
        let bytes = &bytes[..length];
        match at {
            REQUESTS => {
                self.incoming.extend_from_slice(bytes);
                self.answer()?;
            }
            SERIAL => {
                if let Some(serial) = &mut self.serial {
                    serial.extend_from_slice(bytes);
                }
                let now = Duration::from_micros(self.chip.now_us());
                self.emulator.send(&wire(now, bytes)?)?;
            }
            MESSAGES => self.messages.extend_from_slice(bytes),
            LOG => self.log.iter_mut().for_each(|log| log.push(bytes)),
            _ => {}
        }
        Ok(length > 0)
    }

    /// Answers every request that is complete.
    fn answer(&mut self) -> Result<()> {
        while let Some((header, rest)) = self.incoming.split_first_chunk::<REQUEST_BYTES>() {
            let Some(request) = Request::decode(header) else {
                bail!("the firmware does not speak this program's bridge: build both from the same sources");
            };
            let length = usize::from(request.length);
            let Some(sent) = rest.get(..length) else { break };
            let mut payload = [0; PAYLOAD_MAX];
            let payload = &mut payload[..length];
            payload.copy_from_slice(sent);
            self.incoming.drain(..REQUEST_BYTES + length);
            self.emulator.connected();
            let reply = self.chip.answer(&request, payload);
            let record = [&reply.encode()[..], payload].concat();
            self.emulator.reply(&record)?;
        }
        Ok(())
    }

    fn conclude(self, status: Option<ExitStatus>) -> Result<Outcome> {
        let said = self.said();
        match status.map(|status| status.code()) {
            _ if stop::is_asked() => {}
            Some(Some(0)) if self.chip.ended() => {}
            Some(Some(0)) => bail!("the firmware left before the end of the input{said}"),
            // The statuses the firmware leaves with; see its board/semihost.rs.
            Some(Some(3)) => bail!("the firmware faulted{said}"),
            Some(Some(4)) => bail!("the firmware stood still{said}"),
            Some(Some(101)) => bail!("the firmware panicked{said}"),
            _ => bail!("{QEMU} failed: {}{said}", status.unwrap_or_default()),
        }
        let (conversions_served, conversions_lost) = self.chip.served_and_lost();
        Ok(Outcome {
            serial: self.serial.unwrap_or_default(),
            messages: String::from_utf8_lossy(&self.messages).into_owned(),
            conversions_served,
            conversions_lost,
            chip: self.chip.chip().counters(),
            arrived: self.chip.arrived(),
            injected: self.chip.chip().injected().to_vec(),
            registers: self.chip.chip().registers(),
            start_us: self.chip.start_us().unwrap_or(0),
            first_edge_us: self.chip.first_edge_us().unwrap_or(0),
            end_us: self.chip.now_us(),
            conversions: self.chip.into_conversions(),
            ..Outcome::default()
        })
    }

    /// The last line that the emulator said, to go behind a message.
    fn said(&self) -> String {
        let text = String::from_utf8_lossy(&self.messages);
        text.lines().map(str::trim).rfind(|line| !line.is_empty()).map_or_else(String::new, |line| format!(": {line}"))
    }
}
