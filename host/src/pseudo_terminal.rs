//! Offers the line of an emulated board as a serial port of this PC.

use crate::emulator::Firmware;
use crate::input::Opened;
use anyhow::Result;

#[cfg(not(unix))]
pub fn run(_: Opened, _: Firmware) -> Result<()> {
    anyhow::bail!(
        "there are no pseudo-terminals on Windows: use --emulated of the other commands, or WSL"
    )
}

/// Prints the port's path, then runs the board until it fails or the process is asked to stop.
#[cfg(unix)]
pub fn run(input: Opened, firmware: Firmware) -> Result<()> {
    use crate::feed::end;
    use crate::{emulator, output, stop};
    use anyhow::Context;
    use ridgetone_emulator::Session;
    use serialport::{ClearBuffer, SerialPort, TTYPort};
    use std::io::{Read, Write};
    use std::time::Duration;

    let (mut ours, theirs) = TTYPort::pair().context("no pseudo-terminal")?;
    ours.set_timeout(Duration::ZERO)?;
    output::line(&theirs.name().context("the port has no name")?)?;
    let session = Session::start(1.0, move || emulator::board(&firmware, input));
    while !stop::is_requested() {
        let Some(sent) = session.receive(Duration::from_millis(1)) else {
            break;
        };
        let mut bytes = [0; 256];
        if let Ok(length) = ours.read(&mut bytes) {
            session.send(&bytes[..length]);
        }
        // Write one byte at a time, so that a write never blocks.
        if !sent
            .iter()
            .all(|byte| matches!(ours.write(&[*byte]), Ok(1)))
        {
            // No program has read for a while: drop the bytes, as a cable would.
            theirs.clear(ClearBuffer::Input)?;
        }
    }
    end(Some(session))
}
