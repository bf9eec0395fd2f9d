//! Reads the messages of a recording: telemetry packets, or JSON objects from `export` or `--json`.

use crate::events::JsonLines;
use crate::feed::{Feed, FeedEvent};
use crate::mcap;
use crate::note;
use crate::recording::{self, Recorded};
use crate::utc::Receipt;
use anyhow::{Context, Result, bail};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Packet, Raw};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// First bytes of an MCAP file (mcap.dev, "Magic").
const MCAP_MAGIC: [u8; 5] = *b"\x89MCAP";

/// Bytes read from the beginning of a file to detect its form.
const LOOK_BYTES: u64 = 4096;

/// Kind of a file, by its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Telemetry,
    Mcap,
    JsonLines,
    /// Everything else, which is read as a table.
    Table,
}

impl Form {
    /// Detects the kind of a file from its beginning. A pipe cannot be rewound, so it is taken for
    /// a table.
    pub fn of(path: &Path) -> io::Result<Self> {
        if !std::fs::metadata(path)?.is_file() {
            return Ok(Self::Table);
        }
        let mut start = Vec::new();
        File::open(path)?.take(LOOK_BYTES).read_to_end(&mut start)?;
        Ok(match start.trim_ascii_start() {
            start if start.starts_with(&MCAP_MAGIC) => Self::Mcap,
            // JSON of other programs has no `type`: read it as a table.
            start if start.starts_with(b"{") && names_a_type(start) => Self::JsonLines,
            _ if recording::is_telemetry(path).unwrap_or(false) => Self::Telemetry,
            _ => Self::Table,
        })
    }
}

/// True if the first line has a field `type`.
fn names_a_type(start: &[u8]) -> bool {
    let line = start
        .split(|byte| *byte == b'\n')
        .next()
        .unwrap_or_default();
    line.windows(6).any(|bytes| bytes == b"\"type\"")
}

#[derive(Clone, Debug)]
pub enum Message {
    /// Packet, and the time when it was received, if known.
    Packet(Box<Packet>, Option<Receipt>),
    /// One object on one line, as with `--json`.
    Json(String),
}

/// Fields of `hello` and `raw` that are needed to decode frames.
#[derive(Deserialize)]
struct JsonFrame {
    r#type: String,
    settings: Option<JsonSettings>,
    t_s: Option<f64>,
    number: Option<u32>,
    present: Option<u16>,
    good: Option<u16>,
    codes: Option<[i32; TAXELS]>,
}

#[derive(Deserialize)]
struct JsonSettings {
    vref_v: f32,
}

impl Message {
    pub fn json(&self, lines: &mut JsonLines) -> Result<String> {
        match self {
            Self::Packet(packet, receipt) => Ok(lines.line(packet, *receipt)?),
            Self::Json(text) => Ok(text.clone()),
        }
    }

    /// Returns the raw frame of the message, if it has one. A greeting updates `vref_v`.
    pub fn frame(&self, vref_v: &mut f32) -> Result<Option<Raw>> {
        match self {
            Self::Packet(packet, _) => Ok(match &packet.event {
                Event::Raw(raw) => Some(*raw),
                Event::Hello(hello) => {
                    *vref_v = hello.settings.vref_v;
                    None
                }
                _ => None,
            }),
            // Parse only `raw` and `hello`: no other message has a frame or the reference voltage.
            Self::Json(text)
                if !text.contains(r#""type":"raw""#) && !text.contains(r#""type":"hello""#) =>
            {
                Ok(None)
            }
            Self::Json(text) => {
                let found: JsonFrame = serde_json::from_str(text)?;
                *vref_v = found.settings.map_or(*vref_v, |settings| settings.vref_v);
                let JsonFrame {
                    t_s: Some(t_s),
                    number: Some(number),
                    codes: Some(codes),
                    ..
                } = found
                else {
                    return Ok(None);
                };
                let (present, good) = (
                    found.present.unwrap_or(u16::MAX),
                    found.good.unwrap_or(u16::MAX),
                );
                let is_raw = found.r#type == "raw";
                Ok(is_raw.then(|| Raw {
                    t_us: (t_s * 1e6).round() as u64,
                    number,
                    present,
                    good,
                    codes,
                }))
            }
        }
    }
}

pub type Messages = Box<dyn Iterator<Item = Result<Message>> + Send>;

/// Reads all messages from a file in the given format.
pub fn messages(path: &Path, form: Form) -> Result<Messages> {
    let named = || path.display().to_string();
    match form {
        Form::Telemetry => {
            let mut feed = Feed::new(Recorded::open(path)?);
            Ok(Box::new(std::iter::from_fn(move || {
                loop {
                    match feed.next(Duration::ZERO) {
                        Ok(Some(FeedEvent::Data(packet))) => {
                            return Some(Ok(Message::Packet(Box::new(packet), feed.receipt())));
                        }
                        Ok(Some(FeedEvent::Over)) => return None,
                        Ok(_) => {}
                        Err(error) => return Some(Err(error)),
                    }
                }
            })))
        }
        Form::JsonLines => {
            let lines = BufReader::new(File::open(path).with_context(named)?).lines();
            let lines =
                lines.filter(|line| line.as_ref().map_or(true, |line| !line.trim().is_empty()));
            Ok(Box::new(lines.map(|line| Ok(Message::Json(line?)))))
        }
        Form::Mcap => {
            let bytes = std::fs::read(path).with_context(named)?;
            let file = mcap::json_messages(&bytes).with_context(named)?;
            if let Some(byte) = file.cut_at {
                let count = file.messages.len();
                note_once(format!(
                    "{}: cut off or damaged at byte {byte}: the {count} messages before it are read",
                    named()
                ));
            }
            let mut found = Vec::new();
            for (topic, json) in file.messages {
                if topic.starts_with("/ridgetone/") {
                    let json = String::from_utf8(json).with_context(named)?;
                    found.push(Ok(Message::Json(json)));
                }
            }
            Ok(Box::new(found.into_iter()))
        }
        Form::Table => bail!("{}: holds no telemetry", named()),
    }
}

/// Writes a remark on a file to standard error, but only once, even if the file is read again.
fn note_once(text: String) {
    static NOTED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let mut noted = NOTED.lock().unwrap_or_else(PoisonError::into_inner);
    if !noted.contains(&text) {
        note!("{text}");
        noted.insert(text);
    }
}

/// Reference voltage assumed until a greeting reports it.
pub const VREF_V: f32 = Settings::DEFAULT.vref_v;
