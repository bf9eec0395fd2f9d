//! Sources of messages, opened.

use super::name::Source;
use crate::feed::{self, Emulation, Feed, Pace};
use crate::port::{Link, System, Wanted};
use crate::recording::Recorded;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The firmware of emulated boards.
pub struct Emulator {
    pub elf: PathBuf,
    /// Time without a sign of life after which it is given up.
    pub silence: Duration,
}

/// Opens a source of packets: all but an address.
pub fn feed(source: &Source, emulator: Option<&Emulator>) -> Result<Feed> {
    match source {
        Source::Recording(path) => Ok(Feed::new(Recorded::open(path)?).paced(Pace::new(1.0))),
        Source::Emulated(scene) => emulated(scene.as_deref(), emulator),
        Source::Port(name) | Source::Url(name) => Ok(Feed::new(Link::open(
            System,
            Wanted::new(Some(name.clone()), None),
        )?)),
    }
}

/// At the speed of a real board, touched again and again.
fn emulated(scene: Option<&Path>, emulator: Option<&Emulator>) -> Result<Feed> {
    let emulator = emulator.ok_or_else(|| anyhow::anyhow!("no firmware image to emulate"))?;
    let how = Emulation {
        elf: emulator.elf.clone(),
        silence: emulator.silence,
        pace: Some(1.0),
        repeats: true,
    };
    feed::emulated(scene, how)
}
