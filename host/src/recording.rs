//! Telemetry in a file: a short header, then the bytes of the line.
//!
//! ```text
//! ridgetone telemetry 1 {"protocol":5,"version":"0.1.0","source":"/dev/ttyUSB0"}\n\0<bytes>
//! ```
//!
//! There is no index and no end mark: a file that is cut off anywhere is valid up to there, and loses at most one frame.
//! Bytes without the header, as `cat /dev/ttyUSB0` or `emulate --serial-out` leave them, are read too.

use crate::feed::{FeedEvent, Source};
use anyhow::{Context, Result, bail, ensure};
use ridgetone_proto::telemetry::{Decoder, PROTOCOL};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, IsTerminal, Read, Write};
use std::path::Path;
use std::time::Duration;

/// Beginning of such a file.
const MAGIC: &str = "ridgetone telemetry ";

const FORMAT: u32 = 1;

/// Bytes.
const HEADER_MAX: u64 = 4096;

/// Bytes at the beginning of a file of telemetry that hold a complete frame: frames have
/// [`WIRE_MAX`](ridgetone_proto::telemetry::WIRE_MAX) at most, 512.
const LOOK_BYTES: u64 = 4096;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the wire contract ([`PROTOCOL`]).
    pub protocol: u8,
    /// Version of the command that wrote it.
    pub version: String,
    pub source: String,
}

/// Begins a recording of `source`, in a new file or, with `-`, on standard output. It is not buffered.
pub fn create(path: &Path, source: &str) -> Result<Box<dyn Write + Send>> {
    let named = || path.display().to_string();
    if path == Path::new("-") {
        ensure!(!std::io::stdout().is_terminal(), "a recording is not for a terminal: choose a file, or pipe it");
        let mut out = std::io::stdout();
        begin(&mut out, source).context("standard output")?;
        return Ok(Box::new(out));
    }
    let mut file = match File::create_new(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            bail!("{}: this file exists already, and no recording is overwritten: choose another name", named())
        }
        Err(error) => return Err(error).with_context(named),
    };
    begin(&mut file, source).with_context(named)?;
    Ok(Box::new(file))
}

fn begin(out: &mut dyn Write, source: &str) -> Result<()> {
    let header =
        Header { protocol: PROTOCOL, version: env!("CARGO_PKG_VERSION").to_owned(), source: source.to_owned() };
    let text = format!("{MAGIC}{FORMAT} {}\n\0", serde_json::to_string(&header)?);
    Ok(out.write_all(text.as_bytes())?)
}

/// Whether a file holds telemetry, by its content: it has the header, or a whole frame near its beginning.
pub fn is_telemetry(path: &Path) -> Result<bool> {
    let named = || path.display().to_string();
    let mut start = Vec::new();
    File::open(path).with_context(named)?.take(LOOK_BYTES).read_to_end(&mut start).with_context(named)?;
    let mut decoder = Decoder::new();
    let is_frame = |byte: &u8| decoder.push(*byte).is_some() || decoder.foreign.is_some();
    Ok(start.starts_with(MAGIC.as_bytes()) || start.iter().any(is_frame))
}

/// A recording as a source, without delays.
#[derive(Debug)]
pub struct Recorded {
    name: String,
    file: BufReader<File>,
    /// None in bytes without one.
    pub header: Option<Header>,
    /// Bytes of telemetry in the file when it was opened.
    pub bytes: u64,
}

impl Recorded {
    /// Fails if it cannot be read, holds something else, or was written by another version of the format or of the protocol.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        if !is_telemetry(path)? {
            bail!(
                "{name}: holds no telemetry as `record` writes it; tables, and what `export` makes, are for `fit`, `feel`, `replay` and `emulate`"
            );
        }
        let file = File::open(path).with_context(|| name.clone())?;
        let bytes = file.metadata().with_context(|| name.clone())?.len();
        let mut recorded = Self { name: name.clone(), file: BufReader::new(file), header: None, bytes };
        recorded.read_header().with_context(|| name)?;
        Ok(recorded)
    }

    fn read_header(&mut self) -> Result<()> {
        if !self.file.fill_buf()?.starts_with(MAGIC.as_bytes()) {
            return Ok(());
        }
        let mut text = Vec::new();
        self.bytes -= self.file.by_ref().take(HEADER_MAX).read_until(0, &mut text)? as u64;
        let text = String::from_utf8(text).context("the header")?;
        let (format, json) =
            text[MAGIC.len()..].trim_end_matches(['\0', '\n']).split_once(' ').context("the header")?;
        if format != FORMAT.to_string() {
            bail!("written in format {format}, this command reads {FORMAT}: use the version that wrote it");
        }
        let header: Header = serde_json::from_str(json).context("the header")?;
        if header.protocol != PROTOCOL {
            let Header { protocol, version, .. } = header;
            bail!("holds protocol {protocol}, this command speaks {PROTOCOL}: use version {version}, which wrote it");
        }
        self.header = Some(header);
        Ok(())
    }
}

impl Source for Recorded {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        let bytes = self.file.fill_buf().with_context(|| self.name.clone())?.to_vec();
        self.file.consume(bytes.len());
        Ok(Some(if bytes.is_empty() { FeedEvent::Over } else { FeedEvent::Data(bytes) }))
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
    use ridgetone_proto::telemetry::Packet;

    /// The default scene's telemetry: its bytes and its packets.
    fn telemetry() -> (Vec<u8>, Vec<Packet>) {
        let mut packets = Vec::new();
        let mut sink = |packet: &Packet| {
            packets.push(packet.clone());
            Ok(())
        };
        let outcome =
            replay::run(Input::default().open().unwrap(), Settings::DEFAULT, None, &mut sink, &mut |_, _| {}).unwrap();
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
        create(&path, "a test").unwrap().write_all(&bytes).unwrap();
        let header = Recorded::open(&path).unwrap().header.unwrap();
        assert_eq!((header.protocol, header.source.as_str()), (PROTOCOL, "a test"));
        let (found, counts) = read(&path);
        assert_eq!(found, packets);
        assert_eq!((counts.received, counts.missing, counts.damaged), (packets.len() as u64, 0, 0));

        // Cut off at any byte: all packets before the cut, and nothing is called damaged.
        let whole = std::fs::read(&path).unwrap();
        let from = whole.len() - bytes.len();
        for length in (from + 1..whole.len()).step_by(37) {
            let torn = folder.path().join(format!("torn{length}"));
            std::fs::write(&torn, &whole[..length]).unwrap();
            let (found, counts) = read(&torn);
            let complete = bytes[..length - from].iter().filter(|byte| **byte == 0).count();
            assert_eq!(found, packets[..complete]);
            assert_eq!((counts.missing, counts.damaged), (0, 0));
        }
        let bare = folder.path().join("bare");
        std::fs::write(&bare, &bytes).unwrap();
        assert_eq!(read(&bare).0, packets);
        assert!(Recorded::open(&bare).unwrap().header.is_none());
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
        let other = br#"ridgetone telemetry 1 {"protocol":200,"version":"7.0.0","source":"x"}"#;
        let error = refused("protocol", &[&other[..], b"\n\0"].concat());
        assert!(error.contains("protocol 200") && error.contains("version 7.0.0"), "{error}");
        let there = folder.path().join("a.csv");
        assert!(format!("{:#}", create(&there, "x").err().unwrap()).contains("already"));
    }
}
