//! The workload of the benchmarks: jobs from a PC for the images `ridgetone-bench` and
//! `baselines-bench`, and their results.
//!
//! Both files are rows of records: a byte with the length, then that many bytes of `postcard`. The
//! file `workload` has [`Job`]s, and behind each its items: frames of a fit and of a baseline
//! ([`Frame`]), conversions of a detection ([`conversion`]). The job `End` comes last. The file
//! `results` has every [`Measured`], in the order of the jobs.

use ads1258::Conversion;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::settings::Declared;
pub use ridgetone_proto::telemetry::longest_packet;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX, encode};
use ridgetone_tone::{Fit, Values};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Most bytes of a record, its length included; a frame has 68.
pub const RECORD_MAX: usize = 80;

/// Writes a record; gives its bytes. None if it is too long.
pub fn write<'a>(item: &impl Serialize, record: &'a mut [u8; RECORD_MAX]) -> Option<&'a [u8]> {
    let (length, bytes) = record.split_first_mut()?;
    *length = postcard::to_slice(item, bytes).ok()?.len() as u8;
    record.get(..=usize::from(record[0]))
}

/// Reads a record; `fill` fills a slice with the next bytes, or returns false. None if it fails, or
/// if that is no record.
pub fn read<T: DeserializeOwned>(mut fill: impl FnMut(&mut [u8]) -> bool) -> Option<T> {
    let (mut length, mut bytes) = ([0], [0; RECORD_MAX]);
    let bytes = if fill(&mut length) {
        bytes.get_mut(..length[0].into())?
    } else {
        return None;
    };
    if !fill(bytes) {
        return None;
    }
    postcard::take_from_bytes(bytes)
        .ok()
        .filter(|(_, rest)| rest.is_empty())
        .map(|(item, _)| item)
}

/// A job of the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Job {
    End,
    /// Fit a window of `frames` frames of a scene with at most `harmonics` harmonics, the fundamental
    /// included; gives a [`Measured::Fit`].
    Fit {
        declared: Declared,
        harmonics: u8,
        frames: u32,
    },
    /// A detector takes whole scans of conversions, from the first slot on; gives a
    /// [`Measured::Message`] for every event and a [`Measured::Frame`] for every scan.
    Detect {
        conversions: u32,
    },
    /// Encode the [`longest_packet`]; gives a [`Measured::Message`].
    Encode,
    /// Take conversions in from a chip in memory; gives a [`Measured::Intake`].
    Intake,
    /// Estimate the frequency of a window by a baseline, from the first `channels` channels; gives
    /// a [`Measured::Baseline`].
    Baseline {
        method: u8,
        channels: u8,
        frames: u32,
    },
}

/// The values of a frame, and the mask of its valid taxels.
pub type Frame = (Values, u16);

/// A conversion from its record: the time in microseconds, then status and code as the chip sends
/// them.
pub fn conversion(t_us: u32, bytes: [u8; 4]) -> TimedConversion {
    TimedConversion::new(t_us, Conversion::from_bytes(bytes))
}

/// The record of a conversion.
pub fn conversion_record(timed: &TimedConversion) -> (u32, [u8; 4]) {
    let [_, high, middle, low] = timed.code().to_be_bytes();
    (timed.t_us, [timed.status().0, high, middle, low])
}

/// The result of a fit, as bits: the chip's must be the PC's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// [`Status`](ridgetone_tone::Status) by its number, 255 if the window could not be read.
    pub status: u8,
    pub frequency_bits: u32,
    pub sigma_bits: u32,
    pub harmonics: u8,
}

impl Outcome {
    /// The outcome of a fit, or of none.
    pub fn new(fit: Option<&Fit>) -> Self {
        match fit {
            Some(fit) => Self {
                status: fit.status as u8,
                frequency_bits: fit.frequency.to_bits(),
                sigma_bits: fit.sigma.to_bits(),
                harmonics: fit.harmonics,
            },
            None => Self {
                status: u8::MAX,
                frequency_bits: 0,
                sigma_bits: 0,
                harmonics: 0,
            },
        }
    }
}

/// The bytes of a packet on the wire: the chip's must be the PC's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wire {
    /// Bytes, the zero behind them included; 0 if it was too long.
    pub bytes: u32,
    /// Their sum in 32 bits, each times its place from 1 on.
    pub sum: u32,
}

impl Wire {
    /// Encodes a packet into `wire` and returns its length. Separate from [`Self::new`], which must
    /// not be measured.
    pub fn write(packet: &Packet, wire: &mut [u8; WIRE_MAX]) -> usize {
        encode(packet, wire).unwrap_or(0)
    }

    /// Sums up the bytes on the wire.
    pub fn new(wire: &[u8]) -> Self {
        let sum = (1..).zip(wire).fold(0u32, |sum, (place, byte)| {
            sum.wrapping_add(*byte as u32 * place)
        });
        Self {
            bytes: wire.len() as u32,
            sum,
        }
    }
}

/// One measurement. Instructions are exact: the emulator counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Measured {
    /// One fit, from its frames to frequency and uncertainty.
    Fit {
        instructions: u32,
        /// Instructions of the window where its tone is expected; 0 where it was not good.
        tracked: u32,
        stack_bytes: u32,
        outcome: Outcome,
    },
    /// One scan's conversions in the detector, and the windows that fell due.
    Frame {
        instructions: u32,
        windows: u32,
    },
    Message {
        instructions: u32,
        wire: Wire,
    },
    /// One conversion read, stamped and queued, at most.
    Intake {
        instructions: u32,
    },
    /// One estimate of a baseline, if it found a frequency: cycles per frame.
    Baseline {
        instructions: u32,
        frequency_bits: Option<u32>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_from<T: DeserializeOwned>(mut bytes: &[u8]) -> Option<T> {
        let item = read(|place| std::io::Read::read_exact(&mut bytes, place).is_ok());
        item.filter(|_| bytes.is_empty())
    }

    /// What stands in `item`'s record, and the record's length. A shorter one and a longer one are
    /// no records.
    fn back<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(item: &T) -> (T, usize) {
        let mut record = [0; RECORD_MAX];
        let bytes = write(item, &mut record).expect("a record").to_vec();
        let (shorter, mut longer) = (&bytes[..bytes.len() - 1], [&bytes[..], &[0]].concat());
        longer[0] += 1;
        assert!(
            read_from::<T>(shorter).is_none() && read_from::<T>(&longer).is_none(),
            "{item:?}"
        );
        (read_from(&bytes).expect("a record"), bytes.len())
    }

    #[test]
    fn jobs_frames_and_conversions_come_back() {
        let fit = Job::Fit {
            declared: Declared::DEFAULT,
            harmonics: 4,
            frames: 70_000,
        };
        let baseline = Job::Baseline {
            method: 6,
            channels: 16,
            frames: 241,
        };
        for job in [
            Job::End,
            fit,
            Job::Detect { conversions: 21 },
            Job::Encode,
            Job::Intake,
            baseline,
        ] {
            assert_eq!(back(&job).0, job);
        }
        assert_eq!(read_from::<Job>(&[1, 9]), None);
        let frame: Frame = (core::array::from_fn(|c| c as f32 * -1e6), 0x8001);
        assert_eq!(back(&frame), (frame, 68));
        let read = Conversion {
            status: ads1258::Status(0x97),
            code: -0x12_3456,
        };
        let timed = TimedConversion::new(0xfedc_ba98, read);
        let (t_us, bytes) = back(&conversion_record(&timed)).0;
        assert_eq!(conversion(t_us, bytes), timed);
    }

    #[test]
    fn results_come_back() {
        let most = u32::MAX;
        let outcome = Outcome {
            status: 255,
            frequency_bits: most,
            sigma_bits: most,
            harmonics: 255,
        };
        for measured in [
            Measured::Fit {
                instructions: most,
                tracked: most,
                stack_bytes: most,
                outcome,
            },
            Measured::Frame {
                instructions: 7,
                windows: most,
            },
            Measured::Message {
                instructions: most,
                wire: Wire {
                    bytes: most,
                    sum: 0xabc,
                },
            },
            Measured::Intake { instructions: most },
            Measured::Baseline {
                instructions: most,
                frequency_bits: Some(1),
            },
            Measured::Baseline {
                instructions: most,
                frequency_bits: None,
            },
        ] {
            assert_eq!(back(&measured).0, measured);
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
