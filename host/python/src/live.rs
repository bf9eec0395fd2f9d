//! A live board: receives its messages, and sends settings and commands.

use crate::raised;
use anyhow::{Result, bail};
use pyo3::prelude::*;
use ridgetone_host::client::Client;
use ridgetone_host::emulator::image;
use ridgetone_host::events::JsonLines;
use ridgetone_host::feed::{Emulation, Feed, Requester, emulated};
use ridgetone_host::listen::{Heard, Listener};
use ridgetone_host::port::{Link, System, Wanted};
use ridgetone_host::{recording, settings_form};
use ridgetone_proto::command::Command;
use ridgetone_proto::settings::Settings;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A connected board; `None` once closed.
#[pyclass(frozen)]
pub struct Board(Mutex<Option<(Listener, JsonLines)>>);

#[pymethods]
impl Board {
    /// Opens a serial port (by default the only one), or the emulated board.
    #[new]
    #[expect(
        clippy::too_many_arguments,
        reason = "the options of `ridgetone monitor`"
    )]
    fn new(
        py: Python<'_>,
        port: Option<String>,
        usb_serial: Option<String>,
        is_emulated: bool,
        scene: Option<PathBuf>,
        once: bool,
        pace: f64,
        elf: Option<PathBuf>,
        raw: bool,
        settings: Option<&str>,
        record: Option<PathBuf>,
    ) -> PyResult<Self> {
        let open = || -> Result<_> {
            let settings = settings
                .map(|text| settings_form::with_json(&Settings::DEFAULT, text))
                .transpose()?;
            let mut feed = match is_emulated {
                true => emulate(scene.as_deref(), once, pace, elf)?,
                false => Feed::new(Link::open(System, Wanted::new(port, usb_serial))?),
            };
            if let Some(path) = record {
                let file = recording::create(&path, &feed.name(), feed.byte_s())?;
                feed = feed.recorded(Box::new(file));
            }
            let mut requester = Requester::with_settings(settings);
            requester.want_raw_if(raw);
            Ok(Self(Mutex::new(Some((
                Listener::new(feed, requester),
                JsonLines::default(),
            )))))
        };
        py.detach(open).map_err(raised)
    }

    /// Returns kind and text of the next event within `most_s` seconds; `None` if there is none.
    fn next(&self, py: Python<'_>, max_s: f64) -> PyResult<Option<(&'static str, String)>> {
        let max = Duration::try_from_secs_f64(max_s).unwrap_or_default();
        py.detach(|| self.heard(max)).map_err(raised)
    }

    /// Returns the settings in force as JSON.
    fn settings(&self, py: Python<'_>) -> PyResult<String> {
        let get = || self.ask(|client| Ok(settings_form::json(&client.hello()?.settings)?));
        py.detach(get).map_err(raised)
    }

    /// Applies changes to the settings in force, and stores them if `keep` is set.
    fn change(&self, py: Python<'_>, changes: &str, keep: bool) -> PyResult<()> {
        let set = |client: &mut Client<'_>| {
            let settings = settings_form::with_json(&client.hello()?.settings, changes)?;
            client.request(Command::Set { settings, keep })?;
            Ok(())
        };
        py.detach(|| self.ask(set)).map_err(raised)
    }

    /// Carries out a command without arguments.
    fn command(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        let send = |client: &mut Client<'_>| {
            let command = match name {
                "start" => Command::Start,
                "stop" => Command::Stop,
                "restart" => Command::Restart,
                "forget" => Command::Forget,
                _ => bail!("{name}: choose start, stop, restart or forget"),
            };
            client.request(command).map(|_| ())
        };
        py.detach(|| self.ask(send)).map_err(raised)
    }

    /// Returns the numbers of packets received, missing and damaged.
    fn counts(&self) -> PyResult<(u64, u32, u32)> {
        let board = self.lock();
        let counts = board
            .as_ref()
            .map(|(listener, _)| listener.feed.counts())
            .unwrap_or_default();
        Ok((counts.received, counts.missing, counts.damaged))
    }

    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.lock().take()));
    }
}

impl Board {
    fn lock(&self) -> MutexGuard<'_, Option<(Listener, JsonLines)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn heard(&self, max: Duration) -> Result<Option<(&'static str, String)>> {
        let mut board = self.lock();
        let Some((listener, json)) = board.as_mut() else {
            return Ok(Some(("over", String::new())));
        };
        let heard = listener.next(max)?;
        let losses = listener.losses();
        Ok(match heard {
            Some(Heard::Packet(packet, receipt)) => Some(("event", json.line(&packet, receipt)?)),
            Some(Heard::Disconnected(name, why)) => {
                Some(("warning", format!("{name}: {why}; waiting for the board")))
            }
            Some(Heard::Over) => Some(("over", String::new())),
            Some(Heard::Connected(_)) | None => losses.map(|losses| ("warning", losses)),
        })
    }

    fn ask<T>(&self, ask: impl FnOnce(&mut Client<'_>) -> Result<T>) -> Result<T> {
        match self.lock().as_mut() {
            Some((listener, _)) => ask(&mut Client::new(&mut listener.feed)),
            None => bail!("the board is closed"),
        }
    }
}

fn emulate(scene: Option<&Path>, once: bool, pace: f64, elf: Option<PathBuf>) -> Result<Feed> {
    let how = Emulation {
        firmware: elf.as_deref().map_or_else(image::find, image::read)?,
        pace: (pace > 0.0).then_some(pace),
        repeats: !once,
    };
    emulated(scene, how)
}
