//! One run of the emulator. A loop serves four pipes: the bridge's requests, the telemetry, QEMU's
//! messages, and the log. Whenever they are silent it looks at the process, so that it ends however
//! the emulator ends.

use super::chip_end::ChipEnd;
use super::image;
use super::log::Log;
use super::options::Options;
use super::outcome::{Exchange, Outcome};
use super::process::{Emulator, MESSAGES, QEMU, REQUESTS, SERIAL};
use crate::input::Opened;
use crate::stop;
use anyhow::{Context, Result, bail};
use hal_mock::bridge::{PAYLOAD_MAX, REQUEST_BYTES, Request};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{ErrorKind, Read};
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// Time between two looks at the process while its pipes are silent, nanoseconds.
const LOOK_NS: i64 = 50_000_000;

/// Board time that the firmware has to start the chip, and to read the last result after the input
/// has ended, seconds.
const PATIENCE_S: f64 = 10.0;

/// As [`run_packets`](super::run_packets) with the bytes of the line: it neither decodes nor counts
/// packets.
pub fn run_bytes(
    input: Opened,
    options: Options<'_>,
    exchange: &mut Exchange<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let image = image::check(options.elf)?;
    let log = options
        .log
        .map(|print| Log::new(&image, print))
        .transpose()?;
    let mut session = Session {
        emulator: Emulator::start(&image, options.icount_shift)?,
        chip: ChipEnd::new(input, &options),
        incoming: Vec::new(),
        serial: options.keep_serial.then(Vec::new),
        messages: Vec::new(),
        log,
        open: [true; 4],
        active: Instant::now(),
    };
    let status = match session.serve(options.silence, exchange, progress) {
        // Ctrl-C may have reached the emulator first.
        Err(_) if stop::is_requested() => None,
        status => status?,
    };
    session.conclude(status)
}

struct Session {
    emulator: Emulator,
    chip: ChipEnd,
    /// Bytes of an incomplete request.
    incoming: Vec<u8>,
    serial: Option<Vec<u8>>,
    messages: Vec<u8>,
    log: Option<Log>,
    /// Pipes whose other end is open.
    open: [bool; 4],
    /// Last sign of life.
    active: Instant,
}

impl Session {
    /// Serves the emulator until it ends, and gives its status, or until this process is to stop.
    fn serve(
        &mut self,
        silence: Duration,
        exchange: &mut Exchange<'_>,
        progress: &mut dyn FnMut(f64, f64),
    ) -> Result<Option<ExitStatus>> {
        while !stop::is_requested() {
            if self.serve_ready(LOOK_NS, exchange)? {
                self.active = Instant::now();
                self.emulator
                    .send(&exchange(Duration::from_micros(self.chip.now_us), &[])?)?;
                let (done_s, end_s) = self.chip.progress_s();
                progress(done_s, end_s);
                if self.chip.start_us.is_none() && self.chip.now_us as f64 * 1e-6 > PATIENCE_S {
                    bail!(
                        "the firmware has not started the chip within {PATIENCE_S} s of board time{}",
                        self.last_message()
                    );
                }
                if done_s > end_s + PATIENCE_S {
                    bail!(
                        "the firmware has stopped reading the chip{}",
                        self.last_message()
                    );
                }
            } else if let Some(status) = self.emulator.exit_status()? {
                // Reads what is left without waiting: a process that the emulator left running may
                // hold the pipes open.
                while self.serve_ready(0, exchange)? {}
                return Ok(Some(status));
            } else if self.active.elapsed() > silence {
                let when = if self.chip.ended {
                    " after the end of the input"
                } else {
                    ""
                };
                bail!(
                    "{QEMU}: no sign of life from the firmware for {} s{when}{}",
                    silence.as_secs_f32(),
                    self.last_message()
                );
            }
        }
        Ok(None)
    }

    /// Waits at most `most_ns` for pipes to be ready, and serves them. False without any byte.
    fn serve_ready(&mut self, most_ns: i64, exchange: &mut Exchange<'_>) -> Result<bool> {
        let pipes = &self.emulator.pipes;
        let open: Vec<usize> = (0..pipes.len()).filter(|at| self.open[*at]).collect();
        let mut fds: Vec<PollFd<'_>> = open
            .iter()
            .map(|at| PollFd::new(&pipes[*at], PollFlags::IN))
            .collect();
        match poll(
            &mut fds,
            Some(&Timespec {
                tv_sec: 0,
                tv_nsec: most_ns,
            }),
        ) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error).context("poll"),
        }
        let is_ready: Vec<bool> = fds.iter().map(|fd| !fd.revents().is_empty()).collect();
        let mut any = false;
        for (at, _) in open
            .into_iter()
            .zip(is_ready)
            .filter(|(_, is_ready)| *is_ready)
        {
            any |= self.receive(at, exchange)?;
        }
        Ok(any)
    }

    /// Reads from one pipe that is ready. False at its end.
    fn receive(&mut self, at: usize, exchange: &mut Exchange<'_>) -> Result<bool> {
        let mut bytes = [0; 4096];
        let length = match self.emulator.pipes[at].read(&mut bytes) {
            Ok(length) => length,
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                return Ok(false);
            }
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
                let now = Duration::from_micros(self.chip.now_us);
                self.emulator.send(&exchange(now, bytes)?)?;
            }
            MESSAGES => self.messages.extend_from_slice(bytes),
            _ => self.log.iter_mut().for_each(|log| log.push(bytes)),
        }
        Ok(length > 0)
    }

    /// Answers every complete request.
    fn answer(&mut self) -> Result<()> {
        while let Some((header, rest)) = self.incoming.split_first_chunk::<REQUEST_BYTES>() {
            let Some(request) = Request::decode(header) else {
                bail!(
                    "the firmware does not speak this program's bridge: build both from the same sources"
                );
            };
            let length = usize::from(request.length);
            let Some(sent) = rest.get(..length) else {
                break;
            };
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
        let last = self.last_message();
        match status.map(|status| status.code()) {
            _ if stop::is_requested() => {}
            Some(Some(0)) if self.chip.ended => {}
            Some(Some(0)) => bail!("the firmware left before the end of the input{last}"),
            // Exit statuses of the firmware: src/board/emulated/semihost.rs.
            Some(Some(3)) => bail!("the firmware faulted{last}"),
            Some(Some(4)) => bail!("the firmware stood still{last}"),
            Some(Some(101)) => bail!("the firmware panicked{last}"),
            _ => bail!("{QEMU} failed: {}{last}", status.unwrap_or_default()),
        }
        let ChipEnd {
            chip,
            now_us,
            start_us,
            first_edge_us,
            conversions,
            served,
            arrived,
            read_once,
            ..
        } = self.chip;
        Ok(Outcome {
            serial: self.serial.unwrap_or_default(),
            messages: String::from_utf8_lossy(&self.messages).into_owned(),
            conversions_served: served,
            chip: chip.counters(),
            arrived,
            read_once,
            injected: chip.injected().to_vec(),
            registers: chip.registers(),
            start_us: start_us.unwrap_or(0),
            first_edge_us: first_edge_us.unwrap_or(0),
            end_us: now_us,
            conversions,
            ..Outcome::default()
        })
    }

    /// The emulator's last line, to append to an error.
    fn last_message(&self) -> String {
        let text = String::from_utf8_lossy(&self.messages);
        text.lines()
            .map(str::trim)
            .rfind(|line| !line.is_empty())
            .map_or_else(String::new, |line| format!(": {line}"))
    }
}
