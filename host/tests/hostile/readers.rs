//! Properties that readers must have for any bytes in a file or request. `lab/fuzz` tests these
//! too.

use hal_mock::{FileError, Scene, SlidingScene, parse_scene};
use ridgetone_host::events::{JsonLines, text};
use ridgetone_host::feed::{Feed, FeedEvent};
use ridgetone_host::input::frame_rate_hz;
use ridgetone_host::messages::{Form, Message, messages};
use ridgetone_host::recording::Recorded;
use ridgetone_host::samples::Samples;
use ridgetone_host::settings_form;
use ridgetone_proto::command::{Command, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::settings::Settings;
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

#[derive(Clone, Copy, Debug)]
pub enum Reader {
    /// Samples: tables, and raw frames in any file.
    Rows,
    /// Telemetry as `record` writes it.
    Recording,
    Mcap,
    Settings,
    Scene,
    /// A request to the board, without its framing.
    Request,
}

impl Reader {
    /// Reads the bytes, and panics if a property is violated. Returns true if they were accepted.
    pub fn accepts(self, bytes: &[u8]) -> bool {
        match self {
            Self::Rows => rows(bytes),
            Self::Recording => recording(bytes),
            Self::Mcap => mcap(bytes),
            Self::Settings => settings(bytes),
            Self::Scene => scene(bytes),
            Self::Request => request(bytes),
        }
    }
}

/// Writes the bytes to a file in a folder of this thread.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    thread_local! {
        static FOLDER: TempDir = TempDir::new().expect("a folder");
    }
    let path = FOLDER.with(|folder| folder.path().join(name));
    std::fs::write(&path, bytes).expect("written");
    path
}

/// Asserts that rows are complete and finite, no more than there are bytes, and the same in a
/// second pass.
fn rows(bytes: &[u8]) -> bool {
    let path = file("rows", bytes);
    let Ok(samples) = Samples::file(&path) else {
        return false;
    };
    let first = all_rows(&samples, bytes.len());
    let second = all_rows(&samples, bytes.len());
    let texts = [&first, &second].map(|read| read.as_ref().map_err(FileError::to_string));
    assert_eq!(texts[0], texts[1]);
    first.is_ok()
}

fn all_rows(samples: &Samples, max: usize) -> Result<Vec<u64>, FileError> {
    let name = samples.name().to_owned();
    let refuse = |error: anyhow::Error| FileError::new(&name, None, format!("{error:#}"));
    let mut rows = samples.open().map_err(refuse)?;
    let (mut values, mut all, mut count) = (Vec::new(), Vec::new(), 0);
    while rows.advance()? {
        count += 1;
        assert!(count <= max, "more rows than bytes");
        rows.values(&mut values)?;
        assert_eq!(values.len(), rows.names().len());
        assert!(
            !values.iter().any(|value| value.is_infinite()),
            "{values:?}"
        );
        let t_s = rows.time_s();
        assert!(t_s.is_none_or(f64::is_finite), "{t_s:?}");
        all.extend(values.iter().chain(&t_s).map(|value| value.to_bits()));
    }
    Ok(all)
}

/// Asserts that packets are counted, and that each can be printed.
fn recording(bytes: &[u8]) -> bool {
    let Ok(recorded) = Recorded::open(&file("telemetry", bytes)) else {
        return false;
    };
    let (mut feed, mut lines, mut packets) = (Feed::new(recorded), JsonLines::default(), 0);
    loop {
        match feed.next(Duration::ZERO).expect("a file can be read") {
            Some(FeedEvent::Data(packet)) => {
                packets += 1;
                let json = lines.line(&packet, feed.receipt()).expect("JSON");
                let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
                assert!(json["type"].is_string() && !text(&packet).is_empty());
            }
            Some(FeedEvent::Over) => break,
            _ => {}
        }
    }
    assert_eq!(feed.counts().received, packets);
    packets > 0
}

/// Asserts that all messages together are no longer than the file.
fn mcap(bytes: &[u8]) -> bool {
    let Ok(all) = messages(&file("messages", bytes), Form::Mcap) else {
        return false;
    };
    let length = |message: anyhow::Result<Message>| match message.expect("it was read") {
        Message::Json(text) => text.len(),
        Message::Packet(..) => unreachable!("MCAP has JSON"),
    };
    assert!(all.map(length).sum::<usize>() <= bytes.len());
    true
}

/// Asserts that settings from a file are valid, and unchanged after they are written and read
/// again.
fn settings(bytes: &[u8]) -> bool {
    let Ok(settings) = settings_form::load(&file("settings.toml", bytes)) else {
        return false;
    };
    assert_eq!(settings.validate(), Ok(()));
    assert_written_and_read(&settings);
    true
}

fn assert_written_and_read(settings: &Settings) {
    let written = settings_form::toml(settings).expect("TOML");
    let read = settings_form::load(&file("written.toml", written.as_bytes()));
    assert_eq!(read.expect("settings"), *settings, "{written}");
}

/// Asserts that a scene has voltages at all times.
fn scene(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return false;
    };
    let Ok(sliding) = parse_scene("scene.toml", text, frame_rate_hz()) else {
        return false;
    };
    let mut scene = SlidingScene::new(sliding).expect("it was checked");
    let end_s = scene.end_s();
    assert!(end_s > 0.0, "{end_s}");
    for step in 0..32 {
        let t_s = f64::from(step) / 16.0 * end_s.min(1e4);
        let volts = [0, 15].map(|input| scene.volts(input, t_s));
        assert!(
            volts.iter().all(|volts| volts.is_finite()),
            "{t_s} s: {volts:?}"
        );
    }
    true
}

/// Asserts that an accepted request fits its frame, and that valid settings in it fit a file.
fn request(bytes: &[u8]) -> bool {
    let mut wire = [0; 2 * REQUEST_WIRE_MAX];
    let read = |wire: &[u8]| Request::decode(&mut wire.to_vec());
    let used = framing::encode_bytes(bytes, &mut wire);
    let Some(request) = used.ok().and_then(|used| read(&wire[..used - 1])) else {
        return false;
    };
    let mut again = [0; REQUEST_WIRE_MAX];
    let used = framing::encode(&request, &mut again).expect("it fits");
    let repeated = read(&again[..used - 1]).expect("a request");
    // Compares as text, because NaN does not equal itself.
    assert_eq!(format!("{repeated:?}"), format!("{request:?}"));
    if let Command::Set { settings, .. } = request.command
        && settings.validate().is_ok()
    {
        assert_written_and_read(&settings);
    }
    true
}
