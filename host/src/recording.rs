//! Telemetry in a file: a short header, then the bytes of the line.
//!
//! ```text
//! ridgetone telemetry 2 {"protocol":12,"version":"0.3.0","source":"/dev/ttyUSB0"}\n\0<bytes>
//! ```
//!
//! A mark between frames states when the frames after it were received: `@`, nanoseconds since 1970
//! as text, and a zero. A mark cannot be a frame, because it ends earlier than its first stuffing
//! byte promises.
//!
//! There is no index and no end mark: a file that is cut off anywhere is valid up to that point,
//! and loses at most one frame. Bytes without the header, as `cat /dev/ttyUSB0` or `emulate
//! --serial-out` write them, are read too.

use crate::feed::{FeedEvent, Source};
use crate::utc::Receipt;
use anyhow::{Context, Result, anyhow, bail, ensure};
use ridgetone_proto::telemetry::{Decoder, PROTOCOL};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, IsTerminal, Read, Write};
use std::path::Path;
use std::time::Duration;

/// Beginning of a file with a header.
const MAGIC: &str = "ridgetone telemetry ";

const FORMAT: u32 = 2;

/// First byte of a mark. As a stuffing byte it promises 63 more bytes, but only 20 follow.
const MARK: u8 = b'@';

/// Maximum number of bytes that are read as one frame if no zero ends them.
const FRAME_MAX: u64 = 1 << 16;

/// Maximum length of the header, bytes.
const HEADER_MAX: u64 = 4096;

/// Bytes searched for a complete frame at the beginning of a file. Frames have at most
/// [`WIRE_MAX`](ridgetone_proto::telemetry::WIRE_MAX) bytes, 512.
const LOOK_BYTES: u64 = 4096;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the wire contract ([`PROTOCOL`]).
    pub protocol: u8,
    /// Version of the command that wrote the file.
    pub version: String,
    pub source: String,
    /// Duration of a byte on the line, seconds.
    #[serde(default)]
    pub byte_s: f64,
}

/// Stores the bytes that a feed receives.
pub trait Keep {
    fn keep(&mut self, bytes: &[u8], receipt: Option<Receipt>) -> std::io::Result<()>;
}

/// Stores only the bytes.
impl<W: Write> Keep for W {
    fn keep(&mut self, bytes: &[u8], _: Option<Receipt>) -> std::io::Result<()> {
        self.write_all(bytes)?;
        self.flush()
    }
}

/// A recording that is being written: complete frames, each with a mark before it.
pub struct Recording {
    out: Box<dyn Write + Send>,
    /// Beginning of a frame that is not complete yet.
    partial: Vec<u8>,
}

impl Keep for Recording {
    fn keep(&mut self, bytes: &[u8], receipt: Option<Receipt>) -> std::io::Result<()> {
        self.partial.extend_from_slice(bytes);
        let whole = self
            .partial
            .iter()
            .rposition(|byte| *byte == 0)
            .map_or(0, |last| last + 1);
        if whole == 0 {
            return Ok(());
        }
        if let Some(Receipt { utc_ns, .. }) = receipt {
            self.out.write_all(format!("@{utc_ns}\0").as_bytes())?;
        }
        self.out.write_all(&self.partial[..whole])?;
        self.partial.drain(..whole);
        self.out.flush()
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        // Writes the incomplete last frame. An error cannot be reported here.
        let _ = self
            .out
            .write_all(&self.partial)
            .and_then(|()| self.out.flush());
    }
}

/// Begins a recording of `source` in a new file, or on standard output for `-`. Writes are not
/// buffered.
pub fn create(path: &Path, source: &str, byte_s: f64) -> Result<Recording> {
    let named = || path.display().to_string();
    if path == Path::new("-") {
        ensure!(
            !std::io::stdout().is_terminal(),
            "a recording is not for a terminal: choose a file, or pipe it"
        );
        let mut out = std::io::stdout();
        begin(&mut out, source, byte_s).context("standard output")?;
        return Ok(Recording {
            out: Box::new(out),
            partial: Vec::new(),
        });
    }
    let mut file = match File::create_new(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            bail!(
                "{}: this file exists already, and no recording is overwritten: choose another name",
                named()
            )
        }
        Err(error) => return Err(error).with_context(named),
    };
    begin(&mut file, source, byte_s).with_context(named)?;
    Ok(Recording {
        out: Box::new(file),
        partial: Vec::new(),
    })
}

fn begin(out: &mut dyn Write, source: &str, byte_s: f64) -> Result<()> {
    let header = Header {
        protocol: PROTOCOL,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        source: source.to_owned(),
        byte_s,
    };
    let text = format!("{MAGIC}{FORMAT} {}\n\0", serde_json::to_string(&header)?);
    Ok(out.write_all(text.as_bytes())?)
}

/// Returns true if a file holds telemetry: it has the header, or a complete frame near its
/// beginning.
pub fn is_telemetry(path: &Path) -> Result<bool> {
    let named = || path.display().to_string();
    let mut start = Vec::new();
    File::open(path)
        .with_context(named)?
        .take(LOOK_BYTES)
        .read_to_end(&mut start)
        .with_context(named)?;
    let mut decoder = Decoder::new();
    let is_frame = |byte: &u8| decoder.push(*byte).is_some() || decoder.foreign.is_some();
    Ok(start.starts_with(MAGIC.as_bytes()) || start.iter().any(is_frame))
}

/// Returns the error for a file that is not a recording of telemetry.
pub fn no_telemetry(path: &Path) -> anyhow::Error {
    let file = path.display();
    anyhow!(
        "{file}: holds no telemetry as `record` writes it; tables, and what `export` makes, are for `view`, `fit` and `replay`: use `ridgetone view {file}`"
    )
}

/// A recording as a source, read without delays.
#[derive(Debug)]
pub struct Recorded {
    name: String,
    file: BufReader<File>,
    /// Header; `None` if the file begins without one.
    pub header: Option<Header>,
    /// Bytes of telemetry in the file when it was opened.
    pub bytes: u64,
    /// Time of receipt, from the latest mark.
    receipt: Option<Receipt>,
}

impl Recorded {
    /// Opens a recording. Fails if the file cannot be read, is not a recording, or has a different
    /// version of the format or of the protocol.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        if !is_telemetry(path)? {
            return Err(no_telemetry(path));
        }
        let file = File::open(path).with_context(|| name.clone())?;
        let bytes = file.metadata().with_context(|| name.clone())?.len();
        let mut recorded = Self {
            name: name.clone(),
            file: BufReader::new(file),
            header: None,
            bytes,
            receipt: None,
        };
        recorded.read_header().with_context(|| name)?;
        Ok(recorded)
    }

    fn read_header(&mut self) -> Result<()> {
        if !self.file.fill_buf()?.starts_with(MAGIC.as_bytes()) {
            return Ok(());
        }
        let mut text = Vec::new();
        self.bytes -= self
            .file
            .by_ref()
            .take(HEADER_MAX)
            .read_until(0, &mut text)? as u64;
        let text = String::from_utf8(text).context("the header")?;
        let (format, json) = text[MAGIC.len()..]
            .trim_end_matches(['\0', '\n'])
            .split_once(' ')
            .context("the header")?;
        if format != FORMAT.to_string() {
            bail!(
                "holds telemetry in format {format}, this command reads format {FORMAT}: open it with the version that wrote it"
            );
        }
        let header: Header = serde_json::from_str(json).context("the header")?;
        if header.protocol != PROTOCOL {
            let Header {
                protocol, version, ..
            } = header;
            bail!(
                "holds protocol {protocol} of version {version}, this command reads protocol {PROTOCOL}: open it with ridgetone {version}, \
                 or make a table of its raw frames there: `ridgetone export FILE --table frames -o frames.csv`"
            );
        }
        self.header = Some(header);
        Ok(())
    }
}

/// Parses a mark. Returns its time, nanoseconds since 1970.
fn mark_ns(bytes: &[u8]) -> Option<u64> {
    let digits = bytes.strip_prefix(&[MARK])?.strip_suffix(&[0])?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}

impl Source for Recorded {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        loop {
            let mut bytes = Vec::new();
            self.file
                .by_ref()
                .take(FRAME_MAX)
                .read_until(0, &mut bytes)
                .with_context(|| self.name.clone())?;
            let Some(utc_ns) = mark_ns(&bytes).filter(|_| self.header.is_some()) else {
                return Ok(Some(if bytes.is_empty() {
                    FeedEvent::Over
                } else {
                    FeedEvent::Data(bytes)
                }));
            };
            self.receipt = Some(Receipt {
                utc_ns,
                byte_s: self.byte_s(),
            });
        }
    }

    fn receipt(&self) -> Option<Receipt> {
        self.receipt
    }

    fn byte_s(&self) -> f64 {
        self.header.as_ref().map_or(0.0, |header| header.byte_s)
    }

    fn send(&mut self, _: &[u8]) -> Result<()> {
        bail!("{}: a recording takes no requests", self.name)
    }

    fn has_board(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::Feed;
    use crate::input::Input;
    use crate::replay;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};

    /// Returns the telemetry of the default scene, as bytes and as packets.
    fn telemetry() -> (Vec<u8>, Vec<Packet>) {
        let mut packets = Vec::new();
        let mut sink = |packet: &Packet| {
            packets.push(packet.clone());
            Ok(())
        };
        let outcome = replay::run(
            Input::default().open().unwrap(),
            Settings::DEFAULT,
            &mut sink,
            &mut |_, _| {},
        )
        .unwrap();
        (outcome.serial, packets)
    }

    fn read(path: &Path) -> (Vec<Packet>, crate::live::Counts) {
        let mut feed = Feed::new(Recorded::open(path).unwrap());
        let mut packets = Vec::new();
        loop {
            match feed.next(Duration::ZERO).unwrap() {
                Some(FeedEvent::Data(packet)) => packets.push(packet),
                Some(FeedEvent::Over) => return (packets, feed.counts()),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_recording_is_read_back_and_a_cut_off_end_costs_at_most_one_packet() {
        let folder = tempfile::tempdir().unwrap();
        let (bytes, packets) = telemetry();
        let path = folder.path().join("whole");
        create(&path, "a test", 0.0)
            .unwrap()
            .keep(&bytes, None)
            .unwrap();
        let header = Recorded::open(&path).unwrap().header.unwrap();
        assert_eq!(
            (header.protocol, header.source.as_str()),
            (PROTOCOL, "a test")
        );
        let (found, counts) = read(&path);
        assert_eq!(found, packets);
        assert_eq!(
            (counts.received, counts.missing, counts.damaged),
            (packets.len() as u64, 0, 0)
        );

        // A file cut off at any byte returns all packets before the cut and counts none as damaged.
        let whole = std::fs::read(&path).unwrap();
        let from = whole.len() - bytes.len();
        for length in (from + 1..whole.len()).step_by(37) {
            let torn = folder.path().join(format!("torn{length}"));
            std::fs::write(&torn, &whole[..length]).unwrap();
            let (found, counts) = read(&torn);
            let complete = bytes[..length - from]
                .iter()
                .filter(|byte| **byte == 0)
                .count();
            assert_eq!(found, packets[..complete]);
            assert_eq!((counts.missing, counts.damaged), (0, 0));
        }
        let bare = folder.path().join("bare");
        std::fs::write(&bare, &bytes).unwrap();
        assert_eq!(read(&bare).0, packets);
        assert!(Recorded::open(&bare).unwrap().header.is_none());
    }

    #[test]
    fn frames_keep_the_times_at_which_they_were_received() {
        let folder = tempfile::tempdir().unwrap();
        let (bytes, packets) = telemetry();
        let path = folder.path().join("marked");
        let mut file = create(&path, "a test", 1e-5).unwrap();
        // Pieces end anywhere in a frame; a frame gets the time of the piece with its last byte.
        let mut expected = Vec::new();
        for (number, piece) in bytes.chunks(100).enumerate() {
            let receipt = Receipt {
                utc_ns: 1_769_862_605_000_000_000 + number as u64,
                byte_s: 1e-5,
            };
            file.keep(piece, Some(receipt)).unwrap();
            expected.extend(
                piece
                    .iter()
                    .filter(|byte| **byte == 0)
                    .map(|_| Some(receipt)),
            );
        }
        drop(file);
        let mut feed = Feed::new(Recorded::open(&path).unwrap());
        let (mut found, mut receipts) = (Vec::new(), Vec::new());
        while let Some(FeedEvent::Data(packet)) = feed.next(Duration::ZERO).unwrap() {
            found.push(packet);
            receipts.push(feed.receipt());
        }
        assert_eq!((found, receipts), (packets, expected));
        assert_eq!((feed.counts().damaged, feed.byte_s()), (0, 1e-5));
    }

    #[test]
    fn other_files_and_versions_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            let error = format!("{:#}", Recorded::open(&path).unwrap_err());
            assert!(error.starts_with(&path.display().to_string()), "{error}");
            error
        };
        assert!(refused("a.csv", b"time_s,ain0\n0,1\n").contains("holds no telemetry"));
        assert!(refused("empty", b"").contains("holds no telemetry"));
        assert!(refused("format", b"ridgetone telemetry 9 {}\n\0").contains("format 9"));
        assert!(refused("before", b"ridgetone telemetry 1 {}\n\0").contains("format 1"));
        for (protocol, version) in [(PROTOCOL - 1, "0.2.0"), (PROTOCOL + 1, "7.0.0")] {
            let header = format!(
                r#"{{"protocol":{protocol},"version":"{version}","source":"/dev/ttyUSB0"}}"#
            );
            let file = format!("{MAGIC}{FORMAT} {header}\n\0");
            let error = refused("protocol", &[file.as_bytes(), &telemetry().0].concat());
            for part in [
                format!("holds protocol {protocol} of version {version}"),
                format!("reads protocol {PROTOCOL}"),
                format!("ridgetone {version}"),
                "ridgetone export FILE --table frames".to_owned(),
            ] {
                assert!(error.contains(&part), "{error}");
            }
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        // Without a header, the greeting shows the protocol.
        let (_, mut packets) = telemetry();
        let Event::Hello(hello) = &mut packets[0].event else {
            panic!("no greeting")
        };
        hello.protocol = PROTOCOL - 1;
        let mut wire = [0; WIRE_MAX];
        let used = encode(&packets[0], &mut wire).unwrap();
        let bare = folder.path().join("bare");
        std::fs::write(&bare, &wire[..used]).unwrap();
        let error = Feed::new(Recorded::open(&bare).unwrap()).next(Duration::ZERO);
        let error = error.unwrap_err().to_string();
        let expected = format!("holds protocol {}, this command reads", PROTOCOL - 1);
        assert!(error.contains(&expected), "{error}");
        let there = folder.path().join("a.csv");
        assert!(format!("{:#}", create(&there, "x", 0.0).err().unwrap()).contains("already"));
    }
}
