//! Sources of messages, opened.

use super::name::Source;
use crate::feed::{Emulated, Feed, Pace};
use crate::input::frame_rate_hz;
use crate::port::{Link, System, Wanted};
use crate::recording::Recorded;
use crate::touches::{first_touches, of_scene};
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
    let input = match scene {
        Some(path) => of_scene(hal_mock::load_scene(path, frame_rate_hz())?)?.repeated(),
        None => first_touches()?,
    };
    Ok(Feed::new(Emulated::start(
        input,
        emulator.elf.clone(),
        emulator.silence,
        Some(1.0),
    )))
}
