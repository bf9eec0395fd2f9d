//! `emulate`: the firmware image itself, in QEMU, with the simulated chip at the other end of its
//! bridge.

#[cfg(not(unix))]
mod absent;
#[cfg(unix)]
mod chip_end;
pub mod image;
#[cfg(unix)]
mod log;
mod options;
mod outcome;
#[cfg(unix)]
pub mod process;
#[cfg(unix)]
mod session;

#[cfg(not(unix))]
pub use absent::run_bytes;
pub use options::Options;
pub use outcome::{Exchange, Outcome};
#[cfg(unix)]
pub use process::QEMU;
#[cfg(unix)]
pub use session::run_bytes;

use crate::events;
use crate::input::Opened;
use crate::live::Counts;
use crate::requests::Requests;
use anyhow::{Result, bail};
use ridgetone_proto::command::{Command, Outcome as Answer};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, PROTOCOL, Packet};
use std::time::Duration;

/// The PC's end of the line, packet by packet: takes the board's time and a received packet, and
/// gives the bytes to send. It is called with every packet, and without one whenever the board has
/// sent anything else.
pub type Talk<'a> = dyn FnMut(Duration, Option<&Packet>) -> Result<Vec<u8>> + 'a;

/// Runs the firmware on `input` until the input is over and the firmware has left, or this process
/// is to stop (Ctrl-C). Packets go to `sink` as they arrive; `progress` takes the seconds of the
/// input done, and its length. Fails if the image is not ours, the emulator is missing or fails,
/// the firmware fails, falls silent or refuses its settings, or `sink` fails. The emulator has
/// ended by then in any case.
pub fn run(
    input: Opened,
    options: Options<'_>,
    sink: &mut dyn FnMut(&Packet) -> Result<()>,
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
    let mut talk = |now, packet: Option<&Packet>| {
        if let Some(packet) = packet {
            has_greeted = true;
            sink(packet)?;
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

/// A run in which the PC also sends. This PC's speed decides when bytes arrive: such a run does not
/// repeat to the bit.
pub fn run_packets(
    input: Opened,
    options: Options<'_>,
    talk: &mut Talk<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let (mut decoder, mut received) = (Decoder::new(), 0);
    let mut exchange = |now, bytes: &[u8]| {
        if bytes.is_empty() {
            return talk(now, None);
        }
        let mut sent = Vec::new();
        for packet in bytes.iter().filter_map(|byte| decoder.push(*byte)) {
            received += 1;
            sent.extend(talk(now, Some(&packet))?);
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
