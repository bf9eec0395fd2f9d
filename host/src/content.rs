//! Content of a file after decompression and decoding of its text: text, sound, or something that
//! is not a recording.

use anyhow::{Result, bail};
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;
use flate2::read::MultiGzDecoder;
use std::io::{Cursor, Read};

/// Number of bytes read to identify the kind of a file.
const LOOK_BYTES: u64 = 4096;

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

/// File types that are not recordings, by their first bytes, with advice on how to read them.
const OTHERS: [(&[u8], &str); 14] = [
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
