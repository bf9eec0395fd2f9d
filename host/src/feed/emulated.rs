//! The emulated board as a source: runs the firmware image on the register model, at the speed of a
//! real board.

use super::decoded::Feed;
use super::source::{FeedEvent, Source};
use crate::emulator::{self, Firmware};
use crate::input::{Opened, first_scene, frame_rate_hz};
use crate::note;
use crate::port::BYTE_S;
use crate::touches::{first_touches, of_scene};
use anyhow::{Result, anyhow};
use ridgetone_emulator::Session;
use std::path::Path;
use std::time::Duration;

/// Name of the emulated board as a source.
pub const EMULATED: &str = "emulated board";

#[derive(Clone, Debug)]
pub struct Emulation {
    pub firmware: Firmware,
    /// Board time over wall time; `None` for as fast as possible.
    pub pace: Option<f64>,
    /// True to repeat the scene for ever; in the first scene, each touch is over a different
    /// grating.
    pub repeats: bool,
}

/// Opens the emulated board in front of a scene file, or of the first scene.
pub fn emulated(scene: Option<&Path>, how: Emulation) -> Result<Feed> {
    let input = scene_input(scene, how.repeats)?;
    Ok(Feed::new(Emulated::start(input, how.firmware, how.pace)))
}

/// Returns a scene file, or the first scene, as the input of a board.
pub fn scene_input(scene: Option<&Path>, repeats: bool) -> Result<Opened> {
    let input = match scene {
        Some(path) => {
            let input = of_scene(hal_mock::load_scene(path, frame_rate_hz())?)?;
            if repeats { input.repeated() } else { input }
        }
        None if repeats => first_touches()?,
        None => of_scene(first_scene()?)?,
    };
    if let Some(warning) = &input.warning {
        note!("warning: {warning}");
    }
    Ok(input)
}

/// Opens the emulated board with nothing on its finger.
pub fn untouched(how: Emulation) -> Feed {
    let input = emulator::untouched(&how.firmware);
    Feed::new(Emulated::start(input, how.firmware, how.pace))
}

/// The emulated board. Dropping it ends the emulator, and reports if it could not keep the pace.
#[derive(Debug)]
pub struct Emulated(Option<Session>);

impl Emulated {
    /// Starts an image in front of `input`. `pace` is board time over wall time, `None` for as fast
    /// as possible. With a pace, bytes do not arrive before their board time.
    pub fn start(input: Opened, firmware: Firmware, pace: Option<f64>) -> Self {
        let end_s = input.end_s;
        Self(Some(Session::start_until(
            pace.unwrap_or(0.0),
            move || emulator::board(&firmware, input),
            move |emulator| emulator::is_over(emulator, end_s),
        )))
    }
}

impl Source for Emulated {
    fn name(&self) -> String {
        EMULATED.into()
    }

    fn next(&mut self, max: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        match self.0.as_ref().map(|session| session.receive(max)) {
            Some(Some(bytes)) if bytes.is_empty() => Ok(None),
            Some(Some(bytes)) => Ok(Some(FeedEvent::Data(bytes))),
            _ => end(self.0.take()).map(|()| Some(FeedEvent::Over)),
        }
    }

    fn byte_s(&self) -> f64 {
        BYTE_S
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        // A board that has ended receives nothing more; its end is the next event.
        if let Some(session) = &self.0 {
            session.send(bytes);
        }
        Ok(())
    }

    fn idle(&mut self, idle: bool) -> bool {
        self.0.as_ref().is_some_and(|session| session.pause(idle)) && !idle
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        if let Err(error) = end(self.0.take()) {
            note!("{error:#}");
        }
    }
}

pub fn end(session: Option<Session>) -> Result<()> {
    let Some(session) = session else {
        return Ok(());
    };
    let summary = session
        .end()
        .map_err(|error| anyhow!("{EMULATED}: {error}"))?;
    if !summary.behind.is_zero() {
        note!(
            "{EMULATED}: {:.1} s behind: this computer is too slow for the pace",
            summary.behind.as_secs_f64()
        );
    }
    Ok(())
}
