//! `listen`: what a board on a serial line says, until nobody reads it any more.

use crate::port::{Happening, Link, Ports};
use anyhow::{Result, bail};
use ridgetone::telemetry::{PROTOCOL, Packet};
use std::time::Duration;

/// How often it is looked whether the board speaks another protocol.
const LOOK: Duration = Duration::from_secs(1);

/// Gives packets to `sink` and tells standard error when the board goes and comes.
///
/// # Errors
/// The board speaks another protocol; those of `sink`.
pub fn run<P: Ports>(mut link: Link<P>, sink: &mut dyn FnMut(&Packet) -> Result<()>) -> Result<()> {
    let mut told = 0;
    loop {
        match link.next(LOOK) {
            Some(Happening::Packet(packet)) => sink(&packet)?,
            Some(Happening::Came(name)) => eprintln!("ridgetone: {name}: the board is there"),
            Some(Happening::Went(name, error)) => eprintln!("ridgetone: {name}: {error}; waiting for the board"),
            None => {}
        }
        let decoder = link.decoder();
        if let Some(protocol) = decoder.foreign {
            bail!("the board speaks protocol {protocol}, this command {PROTOCOL}: build both from one version");
        }
        if decoder.missing > told {
            eprintln!("ridgetone: {} packets lost, {} damaged so far", decoder.missing, decoder.damaged);
            told = decoder.missing;
        }
    }
}
