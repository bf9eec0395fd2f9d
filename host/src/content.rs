//! Content of a file after decompression and decoding of its text: text, sound, or something that
//! is not a recording.

use anyhow::{Result, bail};
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;
use flate2::read::MultiGzDecoder;
use std::io::{Cursor, Read};

/// Number of bytes read to identify the kind of a file.
const LOOK_BYTES: u64 = 4096;

/// Length from which the line of a JSON object has arrays of samples, bytes.
const ROW_MAX: usize = 2048;

/// A reader that can be sent to another thread.
pub type Input = Box<dyn Read + Send>;

pub enum Content {
    /// Text as UTF-8.
    Text(Input),
    /// Sound in a RIFF file.
    Wav(Input),
}

const JSON_ARRAY: &str =
    "a JSON array: in Python, ridgetone.fit(pandas.read_json(FILE), rate_hz=...)";

const CAN_LOG: &str = "a log of CAN frames, whose bytes only a database can tell: in Python, db = cantools.database.load_file(DBC); ridgetone.fit(pandas.DataFrame([{'time_s': m.timestamp, **db.decode_message(ID, m.data)} for m in can.LogReader(FILE) if m.arbitration_id == ID]))";

/// Text that is no table, by its first characters in lower case, with advice on how to read it.
const MARKUP: [(&str, &str); 4] = [
    (
        "<?xml",
        "XML: in Python, ridgetone.fit(pandas.read_xml(FILE), rate_hz=...)",
    ),
    ("<!doctype html", HTML),
    ("<html", HTML),
    ("<table", HTML),
];

const HTML: &str = "HTML: in Python, ridgetone.fit(pandas.read_html(FILE)[0], rate_hz=...)";

/// File types that are not recordings, by their first bytes, with advice on how to read them.
const OTHERS: [(&[u8], &str); 16] = [
    (
        b"\x93NUMPY",
        "a NumPy array: in Python, ridgetone.fit(numpy.load(FILE), rate_hz=...)",
    ),
    (
        b"MATLAB ",
        "a MATLAB file: in MATLAB, writematrix([t x], 'FILE.csv'); in Python, ridgetone.fit(scipy.io.loadmat(FILE)['NAME'], rate_hz=...)",
    ),
    (
        b"\x89HDF",
        "an HDF5 file: in Python, ridgetone.fit(h5py.File(FILE)['NAME'][:], rate_hz=...)",
    ),
    (
        b"PAR1",
        "a Parquet file: in Python, ridgetone.fit(pandas.read_parquet(FILE), rate_hz=...)",
    ),
    (
        b"TDSm",
        "a TDMS file: in Python, ridgetone.fit(nptdms.TdmsFile(FILE).as_dataframe(), rate_hz=...)",
    ),
    (
        b"\xD0\xCF\x11\xE0",
        "an old Excel or Office file: save it as CSV",
    ),
    (
        b"#ROSBAG",
        "a ROS bag: write its topic with rostopic echo -b FILE -p /TOPIC > FILE.csv",
    ),
    (
        b"SQLite format 3",
        "an SQLite database: write its table as CSV",
    ),
    (
        b"\x28\xB5\x2F\xFD",
        "compressed with zstd: unpack it with unzstd FILE",
    ),
    (b"BZh", "compressed with bzip2: unpack it with bunzip2 FILE"),
    (b"\xFD7zXZ", "compressed with xz: unpack it with unxz FILE"),
    (b"[[", JSON_ARRAY),
    (b"[{", JSON_ARRAY),
    (b"LOGG", CAN_LOG),
    (
        b"MDF     ",
        "an MDF file: in Python, ridgetone.fit(asammdf.MDF(FILE).to_dataframe(), rate_hz=...)",
    ),
    (b"%PDF", "a PDF document: it holds no numbers to fit"),
];

impl Content {
    pub fn of(input: Input) -> Result<Self> {
        let (start, input) = look(input)?;
        if start.starts_with(&[0x1F, 0x8B]) {
            return Self::of(Box::new(MultiGzDecoder::new(input)));
        }
        if start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WAVE") {
            return Ok(Self::Wav(input));
        }
        if let Some((_, what)) = OTHERS.iter().find(|(magic, _)| start.starts_with(magic)) {
            bail!("this is {what}");
        }
        if start.starts_with(b"PK\x03\x04") {
            bail!("this is {}", archive(&start));
        }
        if is_universal(&start) {
            bail!(
                "this is a universal file (UFF 58): in Python, ridgetone.fit(pyuff.UFF(FILE).read_sets()['data'], rate_hz=...)"
            );
        }
        let text = String::from_utf8_lossy(&start);
        if is_can_log(&text) {
            bail!("this is {CAN_LOG}");
        }
        let begin = text.trim_start().to_lowercase();
        if let Some((_, what)) = MARKUP.iter().find(|(mark, _)| begin.starts_with(mark)) {
            bail!("this is {what}");
        }
        // An object a line is read as a table.
        let line = begin.lines().next().unwrap_or_default().trim_end();
        if begin.starts_with('{') && (line == "{" || line.len() > ROW_MAX) {
            bail!(
                "this is a JSON object of more than a line: in Python, ridgetone.fit(pandas.read_json(FILE), rate_hz=...)"
            );
        }
        let encoding = utf_16(&start);
        if encoding.is_none() && start.contains(&0) {
            bail!("this is neither text nor a recording that is known here: write it as CSV");
        }
        Ok(Self::Text(match encoding {
            Some(encoding) => Box::new(
                DecodeReaderBytesBuilder::new()
                    .encoding(Some(encoding))
                    .bom_override(true)
                    .build(input),
            ),
            None => input,
        }))
    }
}

/// True if a text begins with the delimiter of a universal file and the number of a data set.
fn is_universal(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines = text.lines().map(str::trim);
    lines.next() == Some("-1")
        && lines
            .next()
            .is_some_and(|set| matches!(set, "58" | "58b" | "151" | "55" | "15" | "82" | "164"))
}

/// True if most lines have a CAN frame, as `candump` and Vector's tools write them:
/// `(1436509052.25) can0 123#DEADBEEF`, `can0 123 [4] DE AD BE EF`,
/// `0.25 1 123x Rx d 4 DE AD BE EF`.
fn is_can_log(start: &str) -> bool {
    let is_hex = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_id = |word: &str| is_hex(word.trim_end_matches('x')) && word.len() < 10;
    let has_frame = |line: &&&str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_data = |words: &[&str], count: &str| {
            let count = count
                .parse::<usize>()
                .is_ok_and(|count| words.len() >= count && count > 0);
            count && is_hex(words[0]) && words[0].len() == 2
        };
        words.windows(2).enumerate().any(|(at, pair)| {
            let [before, word] = pair else { return false };
            let count = word
                .strip_prefix('[')
                .and_then(|count| count.strip_suffix(']'));
            match word.split_once('#') {
                Some((id, data)) => is_id(id) && is_hex(data.trim_start_matches('#')),
                None if matches!(*before, "Rx" | "Tx") && *word == "d" => words
                    .get(at + 2)
                    .is_some_and(|count| is_data(&words[at + 3..], count)),
                None => {
                    is_id(before) && count.is_some_and(|count| is_data(&words[at + 2..], count))
                }
            }
        })
    };
    let lines: Vec<&str> = start
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    start.starts_with(";$FILEVERSION")
        || lines.len() > 2 && lines.iter().filter(has_frame).count() * 2 > lines.len()
}

/// Returns the beginning of an input, and a reader of the whole input.
fn look(mut input: Input) -> std::io::Result<(Vec<u8>, Input)> {
    let mut start = Vec::new();
    input.by_ref().take(LOOK_BYTES).read_to_end(&mut start)?;
    Ok((start.clone(), Box::new(Cursor::new(start).chain(input))))
}

/// Describes a ZIP archive by its first entry.
fn archive(start: &[u8]) -> &'static str {
    let names = |part: &[u8]| start.windows(part.len()).any(|bytes| bytes == part);
    if names(b".npy") {
        "a NumPy archive: in Python, ridgetone.fit(numpy.load(FILE)['NAME'], rate_hz=...)"
    } else if names(b"xl/") || names(b"[Content_Types]") {
        "an Excel workbook: save the sheet as CSV"
    } else {
        "a ZIP archive: unpack it"
    }
}

/// Returns the encoding of 16-bit text, from its byte order mark or the zeros next to Latin
/// letters.
fn utf_16(start: &[u8]) -> Option<&'static Encoding> {
    if start.starts_with(&[0xFF, 0xFE]) {
        return Some(UTF_16LE);
    }
    if start.starts_with(&[0xFE, 0xFF]) {
        return Some(UTF_16BE);
    }
    let zeros = |odd: usize| {
        start
            .iter()
            .skip(odd)
            .step_by(2)
            .filter(|byte| **byte == 0)
            .count()
    };
    let (even, odd, units) = (zeros(0), zeros(1), start.len() / 2);
    if units > 4 && even == 0 && odd > units / 2 {
        Some(UTF_16LE)
    } else if units > 4 && odd == 0 && even > units / 2 {
        Some(UTF_16BE)
    } else {
        None
    }
}
