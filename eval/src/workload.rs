//! The workload of the benchmarks: jobs from a PC for the images `ridgetone-bench` and `baselines-bench`, and their results.
//!
//! The file `workload` is a row of jobs; all numbers are little endian. A job is a [`Job`] of
//! [`JOB_BYTES`]: kind (0 end, 1 fit, 2 detect, 3 encode, 4 intake, 5 baseline), most harmonics or the baseline's
//! method, the baseline's channels, a zero, and the number of items behind it as u32. The items of a fit
//! and of a baseline are frames of [`FRAME_BYTES`]: the mask of valid taxels as u16, then a value for
//! each taxel as f32. Those of a detection are conversions of
//! [`CONVERSION_BYTES`]: time in microseconds as u32, then status and code as the chip sends them.
//! The job `end` comes last.
//!
//! The file `results` has one line of text for each [`Measured`], in the order of the jobs: a word
//! for its kind, then its numbers, floats as their bits in hexadecimal.

use ads1258::Conversion;
use core::fmt;
use ridgetone::frame::TimedConversion;
use ridgetone_proto::settings::TAXELS;
pub use ridgetone_proto::telemetry::longest_packet;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX, encode};
use ridgetone_tone::{Fit, Values};

/// Bytes of a job.
pub const JOB_BYTES: usize = 8;
/// Bytes of a frame.
pub const FRAME_BYTES: usize = 2 + 4 * TAXELS;
/// Bytes of a conversion.
pub const CONVERSION_BYTES: usize = 8;
/// Most bytes of a result's line, its end included.
pub const LINE_MAX: usize = 96;

/// A job of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// Leave the emulator.
    End,
    /// Fit a window of so many frames with so many harmonics at most; gives a [`Measured::Fit`].
    Fit {
        /// Most harmonics, the fundamental included.
        harmonics: u8,
        /// Frames of the window, which follow; at most [`ridgetone_proto::settings::RING_FRAMES`].
        frames: u32,
    },
    /// A detector takes conversions; gives a [`Measured::Message`] for every event and a [`Measured::Frame`] for every scan.
    Detect {
        /// Conversions, which follow; whole scans from the first slot on.
        conversions: u32,
    },
    /// Encode the [`longest_packet`]; gives a [`Measured::Message`].
    Encode,
    /// Take conversions in from a chip in memory; gives a [`Measured::Intake`].
    Intake,
    /// Estimate the frequency of a window by one of the baselines; gives a [`Measured::Baseline`].
    Baseline {
        /// The method's number.
        method: u8,
        /// The first so many channels count.
        channels: u8,
        /// Frames of the window, which follow.
        frames: u32,
    },
}

impl Job {
    /// The job's bytes.
    pub fn encode(&self) -> [u8; JOB_BYTES] {
        let (kind, how, channels, items) = match *self {
            Self::End => (0, 0, 0, 0),
            Self::Fit { harmonics, frames } => (1, harmonics, 0, frames),
            Self::Detect { conversions } => (2, 0, 0, conversions),
            Self::Encode => (3, 0, 0, 0),
            Self::Intake => (4, 0, 0, 0),
            Self::Baseline { method, channels, frames } => (5, method, channels, frames),
        };
        let [a, b, c, d] = items.to_le_bytes();
        [kind, how, channels, 0, a, b, c, d]
    }

    /// Reads a job back; none if its kind is unknown.
    pub fn decode(bytes: &[u8; JOB_BYTES]) -> Option<Self> {
        let [kind, how, channels, _, a, b, c, d] = *bytes;
        let items = u32::from_le_bytes([a, b, c, d]);
        match kind {
            0 => Some(Self::End),
            1 => Some(Self::Fit { harmonics: how, frames: items }),
            2 => Some(Self::Detect { conversions: items }),
            3 => Some(Self::Encode),
            4 => Some(Self::Intake),
            5 => Some(Self::Baseline { method: how, channels, frames: items }),
            _ => None,
        }
    }
}

/// A frame's bytes.
pub fn encode_frame(values: &Values, valid: u16) -> [u8; FRAME_BYTES] {
    let mut bytes = [0; FRAME_BYTES];
    let (mask, rest) = bytes.split_at_mut(2);
    mask.copy_from_slice(&valid.to_le_bytes());
    for (place, value) in rest.chunks_exact_mut(4).zip(values) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// Reads a frame back: values and mask.
pub fn decode_frame(bytes: &[u8; FRAME_BYTES]) -> (Values, u16) {
    let [low, high, rest @ ..] = bytes;
    let mut values = [0.0; TAXELS];
    for (value, bytes) in values.iter_mut().zip(rest.as_chunks::<4>().0) {
        *value = f32::from_le_bytes(*bytes);
    }
    (values, u16::from_le_bytes([*low, *high]))
}

/// A conversion's bytes.
pub fn encode_conversion(timed: &TimedConversion) -> [u8; CONVERSION_BYTES] {
    let t = timed.t_us.to_le_bytes();
    let [_, high, middle, low] = timed.conversion.code.to_be_bytes();
    [t[0], t[1], t[2], t[3], timed.conversion.status.0, high, middle, low]
}

/// Reads a conversion back.
pub fn decode_conversion(bytes: &[u8; CONVERSION_BYTES]) -> TimedConversion {
    let [a, b, c, d, conversion @ ..] = *bytes;
    TimedConversion { t_us: u32::from_le_bytes([a, b, c, d]), conversion: Conversion::from_bytes(conversion) }
}

/// The result of a fit, as bits: the chip's must be the PC's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// [`Status`](ridgetone_tone::Status) by its number, 255 if the window could not be read.
    pub status: u8,
    /// Bits of [`Fit::frequency`].
    pub frequency_bits: u32,
    /// Bits of [`Fit::sigma`].
    pub sigma_bits: u32,
    /// Harmonics fitted.
    pub harmonics: u8,
}

impl Outcome {
    /// Of a fit, or of none.
    pub fn new(fit: Option<&Fit>) -> Self {
        match fit {
            Some(fit) => Self {
                status: fit.status as u8,
                frequency_bits: fit.frequency.to_bits(),
                sigma_bits: fit.sigma.to_bits(),
                harmonics: fit.harmonics,
            },
            None => Self { status: u8::MAX, frequency_bits: 0, sigma_bits: 0, harmonics: 0 },
        }
    }
}

/// The bytes of a packet on the wire: the chip's must be the PC's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Bytes, the zero behind them included; 0 if it was too long.
    pub bytes: u32,
    /// Their sum in 32 bits, each times its place from 1 on.
    pub sum: u32,
}

impl Wire {
    /// Encodes a packet into `wire` and returns its length. Separate from [`Self::new`], which must not be measured.
    pub fn write(packet: &Packet, wire: &mut [u8; WIRE_MAX]) -> usize {
        encode(packet, wire).unwrap_or(0)
    }

    /// Of the bytes on the wire.
    pub fn new(wire: &[u8]) -> Self {
        let sum = (1..).zip(wire).fold(0u32, |sum, (place, byte)| sum.wrapping_add(*byte as u32 * place));
        Self { bytes: wire.len() as u32, sum }
    }
}

/// One measurement. Instructions are exact: the emulator counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// One fit, from its frames to frequency and uncertainty.
    Fit {
        /// Instructions.
        instructions: u32,
        /// Most stack in use, bytes.
        stack_bytes: u32,
        /// Its result.
        outcome: Outcome,
    },
    /// One scan's conversions in the detector.
    Frame {
        /// Instructions for all of them.
        instructions: u32,
        /// Windows that fell due.
        windows: u32,
    },
    /// One packet encoded.
    Message {
        /// Instructions.
        instructions: u32,
        /// Its bytes.
        wire: Wire,
    },
    /// One conversion read, stamped and queued.
    Intake {
        /// Instructions, at most.
        instructions: u32,
    },
    /// One estimate of a baseline.
    Baseline {
        /// Instructions.
        instructions: u32,
        /// Bits of the frequency in cycles per frame, if it found one.
        frequency_bits: Option<u32>,
    },
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fit { instructions, stack_bytes, outcome } => {
                let Outcome { status, frequency_bits, sigma_bits, harmonics } = outcome;
                write!(f, "fit {instructions} {stack_bytes} {status} {frequency_bits:08x} {sigma_bits:08x} {harmonics}")
            }
            Self::Frame { instructions, windows } => write!(f, "frame {instructions} {windows}"),
            Self::Message { instructions, wire } => write!(f, "message {instructions} {} {:08x}", wire.bytes, wire.sum),
            Self::Intake { instructions } => write!(f, "intake {instructions}"),
            Self::Baseline { instructions, frequency_bits: Some(bits) } => {
                write!(f, "baseline {instructions} {bits:08x}")
            }
            Self::Baseline { instructions, frequency_bits: None } => write!(f, "nothing {instructions}"),
        }
    }
}

impl Measured {
    /// Reads a line back; none if it is no result.
    pub fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let kind = words.next()?;
        let mut number = |radix| u32::from_str_radix(words.next()?, radix).ok();
        let instructions = number(10)?;
        let measured = match kind {
            "fit" => Self::Fit {
                instructions,
                stack_bytes: number(10)?,
                outcome: Outcome {
                    status: number(10)?.try_into().ok()?,
                    frequency_bits: number(16)?,
                    sigma_bits: number(16)?,
                    harmonics: number(10)?.try_into().ok()?,
                },
            },
            "frame" => Self::Frame { instructions, windows: number(10)? },
            "intake" => Self::Intake { instructions },
            "message" => Self::Message { instructions, wire: Wire { bytes: number(10)?, sum: number(16)? } },
            "baseline" => Self::Baseline { instructions, frequency_bits: Some(number(16)?) },
            "nothing" => Self::Baseline { instructions, frequency_bits: None },
            _ => return None,
        };
        words.next().is_none().then_some(measured)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;
    extern crate std;

    #[test]
    fn jobs_frames_and_conversions_come_back() {
        let fit = Job::Fit { harmonics: 4, frames: 70_000 };
        let baseline = Job::Baseline { method: 6, channels: 16, frames: 241 };
        for job in [Job::End, fit, Job::Detect { conversions: 21 }, Job::Encode, Job::Intake, baseline] {
            assert_eq!(Job::decode(&job.encode()), Some(job));
        }
        assert_eq!(Job::decode(&[9, 0, 0, 0, 0, 0, 0, 0]), None);
        let values = core::array::from_fn(|c| c as f32 * -1e6);
        assert_eq!(decode_frame(&encode_frame(&values, 0x8001)), (values, 0x8001));
        let conversion = Conversion { status: ads1258::Status(0x97), code: -0x12_3456 };
        let timed = TimedConversion { t_us: 0xfedc_ba98, conversion };
        assert_eq!(decode_conversion(&encode_conversion(&timed)), timed);
    }

    #[test]
    fn results_come_back_from_lines_of_limited_length() {
        let most = u32::MAX;
        let outcome = Outcome { status: 255, frequency_bits: most, sigma_bits: most, harmonics: 255 };
        for measured in [
            Measured::Fit { instructions: most, stack_bytes: most, outcome },
            Measured::Frame { instructions: 7, windows: most },
            Measured::Message { instructions: most, wire: Wire { bytes: most, sum: 0xabc } },
            Measured::Intake { instructions: most },
            Measured::Baseline { instructions: most, frequency_bits: Some(1) },
            Measured::Baseline { instructions: most, frequency_bits: None },
        ] {
            let line = measured.to_string();
            assert!(line.len() < LINE_MAX, "{line}");
            assert_eq!(Measured::parse(&line), Some(measured), "{line}");
            assert_eq!(Measured::parse(&(line + " 1")), None);
        }
        for damaged in ["", "fit", "fit 1 2 3", "frame x 1", "message 1 2", "other 1 2"] {
            assert_eq!(Measured::parse(damaged), None, "{damaged}");
        }
    }

    #[test]
    fn a_packet_is_known_by_its_bytes_and_their_order() {
        let mut wire = [0; WIRE_MAX];
        let used = Wire::write(&longest_packet(), &mut wire);
        let whole = Wire::new(&wire[..used]);
        assert!(used > 300 && whole.bytes == used as u32);
        wire.swap(20, 21);
        assert!(wire[20] == wire[21] || Wire::new(&wire[..used]) != whole);
    }
}
