//! Raw frames of a board's recording, as codes of its converter.

use super::frame::Frame;
use crate::messages::{Form, Message, messages};
use crate::settings_form;
use anyhow::{Result, bail, ensure};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Raw, Starts};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

pub struct Board {
    path: PathBuf,
    form: Form,
}

impl Board {
    /// Opens a recording. Also returns the board's settings and the length in seconds.
    pub fn open(name: &str, path: &Path, form: Form) -> Result<(Self, Settings, f64)> {
        let board = Self {
            path: path.to_owned(),
            form,
        };
        let (mut settings, mut length_s, mut latest_us) = (None::<Settings>, 0.0f64, 0);
        for message in messages(path, form)? {
            let message = message?;
            if let Some(found) = settings_of(&message)? {
                let known = settings.get_or_insert(found);
                ensure!(
                    known.plan == found.plan,
                    "{name}: the board changed its plan after {:.3} s: record each plan in a file of its own",
                    latest_us as f64 * 1e-6
                );
            }
            if let Some(raw) = raw_of(&message)? {
                latest_us = raw.t_us;
                length_s = length_s.max(raw.t_us as f64 * 1e-6);
            }
        }
        if latest_us == 0 {
            bail!("{name}: holds no raw frames of a board: record with --raw");
        }
        Ok((board, settings.unwrap_or_default(), length_s))
    }

    pub fn each(&self, take: &mut dyn FnMut(Frame<'_>) -> Result<ControlFlow<()>>) -> Result<()> {
        let (mut starts, mut before_us) = (Starts::new(), 0);
        for message in messages(&self.path, self.form)? {
            let message = message?;
            let has_restarted = match &message {
                Message::Packet(packet, _) => starts.take(&packet.event),
                Message::Json(_) => false,
            };
            let raw = raw_of(&message)?;
            let is_earlier = raw.is_some_and(|raw| raw.t_us < before_us);
            if (has_restarted || is_earlier) && before_us > 0 {
                before_us = 0;
                if take(Frame::Restart)?.is_break() {
                    break;
                }
            }
            let Some(raw) = raw else { continue };
            before_us = raw.t_us;
            if take(Frame::Raw(raw))?.is_break() {
                break;
            }
        }
        Ok(())
    }
}

fn raw_of(message: &Message) -> Result<Option<Raw>> {
    message.frame(&mut 0.0)
}

fn settings_of(message: &Message) -> Result<Option<Settings>> {
    match message {
        Message::Packet(packet, _) => Ok(match &packet.event {
            Event::Hello(hello) => Some(hello.settings),
            _ => None,
        }),
        Message::Json(text) if text.contains(r#""type":"hello""#) => {
            let hello: serde_json::Value = serde_json::from_str(text)?;
            let settings = hello["settings"].to_string();
            settings_form::with_json(&Settings::DEFAULT, &settings).map(Some)
        }
        Message::Json(_) => Ok(None),
    }
}
