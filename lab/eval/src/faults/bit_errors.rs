//! Sends telemetry frames with bit errors: counts how many the decoder rejects, and whether it
//! reads the next frame.
//!
//! The guarantees of a CRC-32 apply to the message that it covers, here up to 504 bytes: it detects
//! any burst of up to 32 bits, any 3 bit errors, and in messages of up to 371 bytes any 4 (Koopman,
//! *32-bit cyclic redundancy codes for Internet applications*, DSN 2002, table 1: for 0x04C11DB7
//! the Hamming distance is 5 up to 2,974 bits and 4 up to 91,607). On the line the message is
//! stuffed by COBS. A bit error that creates a zero splits the frame in two, and an error in a
//! length byte of the stuffing also changes bytes elsewhere, which voids the guarantees. Of such
//! frames, and of frames with more errors, one in 2^32 passes the checksum, or 0.002 of ten
//! million. The stuffing rejects some before that, and the content's decoder others after it:
//! leftover bytes, unknown variants, values out of range.
//!
//! One damaged message always passes: the empty one, whose checksum is 0. Zeros in a row, as in
//! `health`, are stuffed as ones, and two bit errors that cut five ones out of a frame create an
//! empty message. The decoder rejects it because no packet is empty; `empty` counts such frames.

use super::counts::add_fields;
use crate::parallel;
use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_host::input::Opened;
use ridgetone_host::replay;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, Packet, Release, WIRE_MAX, encode};
use serde::Serialize;

/// Maximum number of single bit errors in a frame.
const SINGLE_MAX: u32 = 16;
const BURST_MAX: u32 = 64;
/// Frames per batch, which has its own random stream: enough to keep a thread busy, and few enough
/// to share the work among all threads.
const BATCH: u64 = 50_000;

/// Table-driven checksum, independent of the decoder's.
const CHECKSUM: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BitErrors {
    /// Frames sent, each with at least one bit error.
    pub sent: u64,
    /// Frames for which the decoder returned nothing.
    pub refused: u64,
    /// Frames for which the decoder returned a packet. Must be zero.
    pub accepted_damaged: u64,
    /// Frames with a non-empty part whose checksum is right. The decoder may still reject the
    /// content.
    pub checksum_passed: u64,
    /// Frames with a part that is the empty message.
    pub empty: u64,
    /// Undamaged frames, sent after damaged ones with a delimiter in between, that were not read.
    /// Must be zero.
    pub next_lost: u64,
}

add_fields!(BitErrors: sent refused accepted_damaged checksum_passed empty next_lost);

/// Sends `frames` telemetry frames from `touch`, each with bit errors: 1 to 16 anywhere including
/// the delimiter, or a burst of 2 to 64. The same `seed` creates the same errors with any number of
/// threads. Ten million frames take half a minute on two cores.
pub fn count(touch: Opened, frames: u64, seed: u64) -> Result<BitErrors> {
    let serial = replay::run(touch, Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {})?.serial;
    let telemetry: Vec<&[u8]> = serial.split_inclusive(|byte| *byte == 0).collect();
    let batches: Vec<u64> = (0..frames.div_ceil(BATCH)).collect();
    let counted = parallel::map("batches of damaged frames", &batches, |batch| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(*batch);
        Ok(count_batch(
            &telemetry,
            BATCH.min(frames - batch * BATCH),
            &mut rng,
        ))
    })?;
    let mut bit_errors = BitErrors::default();
    counted.into_iter().for_each(|more| bit_errors += more);
    Ok(bit_errors)
}

fn count_batch(telemetry: &[&[u8]], frames: u64, rng: &mut ChaCha8Rng) -> BitErrors {
    let mut bit_errors = BitErrors::default();
    let mut decoder = Decoder::new();
    let behind = Packet {
        sequence: 0,
        event: Event::Release(Release {
            t_us: 1_000_000,
            reported_after_us: 0,
        }),
    };
    let mut wire = [0; WIRE_MAX];
    let used = encode(&behind, &mut wire).unwrap_or(0);
    for (_, whole) in (0..frames).zip(telemetry.iter().cycle()) {
        let mut frame = whole.to_vec();
        while frame == *whole {
            damage(&mut frame, rng);
        }
        bit_errors.sent += 1;
        let lengths = frame.split(|byte| *byte == 0).filter_map(passing);
        let (empty, filled) = lengths.fold((false, false), |(e, f), length| {
            (e || length == 0, f || length > 0)
        });
        (bit_errors.empty, bit_errors.checksum_passed) = (
            bit_errors.empty + u64::from(empty),
            bit_errors.checksum_passed + u64::from(filled),
        );
        // If the frame's delimiter is damaged, send one more, as an idle line does.
        let delimiter: &[u8] = if frame.last() == Some(&0) { &[] } else { &[0] };
        let given = frame
            .iter()
            .chain(delimiter)
            .filter_map(|byte| decoder.push(*byte))
            .count();
        bit_errors.accepted_damaged += u64::from(given > 0);
        bit_errors.refused += u64::from(given == 0);
        let next = wire[..used].iter().filter_map(|byte| decoder.push(*byte));
        bit_errors.next_lost += u64::from(!next.eq([behind.clone()]));
    }
    bit_errors
}

fn damage(frame: &mut [u8], rng: &mut ChaCha8Rng) {
    let bits = 8 * frame.len() as u32;
    let mut at = |bit: u32| frame[bit as usize / 8] ^= 1 << (bit % 8);
    if rng.next_u32().is_multiple_of(2) {
        for _ in 0..=rng.next_u32() % SINGLE_MAX {
            at(rng.next_u32() % bits);
        }
    } else {
        let length = (2 + rng.next_u32() % (BURST_MAX - 1)).min(bits);
        let first = rng.next_u32() % (bits - length + 1);
        // A burst starts and ends with a bit error.
        at(first);
        at(first + length - 1);
        (first + 1..first + length - 1)
            .filter(|_| rng.next_u32().is_multiple_of(2))
            .for_each(at);
    }
}

/// Returns the length of the message between two zeros if its stuffing and checksum are right.
fn passing(stuffed: &[u8]) -> Option<usize> {
    let mut plain = [0; 2 * WIRE_MAX];
    let decoded = cobs::decode(stuffed, &mut plain).ok()?;
    let (content, checksum) = plain[..decoded.frame_size()].split_last_chunk::<4>()?;
    (CHECKSUM.checksum(content) == u32::from_le_bytes(*checksum)).then_some(content.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_host::input::Input;

    #[test]
    fn no_frame_with_bit_errors_is_taken_and_the_next_is_read() {
        let touch = Input::default().open().unwrap();
        let bit_errors = count(touch, 300_000, 1).unwrap();
        println!("{bit_errors:?}");
        // One frame in 2^32 would pass, but none does with this seed.
        let expected = BitErrors {
            sent: 300_000,
            refused: 300_000,
            empty: bit_errors.empty,
            ..BitErrors::default()
        };
        assert_eq!(bit_errors, expected);
    }

    #[test]
    #[ignore = "long, ten million frames: cargo xtask test --all"]
    fn of_ten_million_frames_with_bit_errors_none_is_taken() {
        let touch = Input::default().open().unwrap();
        let bit_errors = count(touch, 10_000_000, 2).unwrap();
        println!("{bit_errors:?}");
        assert_eq!(
            bit_errors,
            BitErrors {
                sent: 10_000_000,
                refused: 10_000_000,
                empty: bit_errors.empty,
                ..BitErrors::default()
            }
        );
    }

    #[test]
    fn the_empty_message_passes_the_checksum_and_is_no_packet() {
        assert_eq!(passing(&[1; 5]), Some(0));
        let mut decoder = Decoder::new();
        assert_eq!(
            [1, 1, 1, 1, 1, 0]
                .iter()
                .filter_map(|byte| decoder.push(*byte))
                .count(),
            0
        );
        assert_eq!(decoder.damaged, 1);
    }

    /// In the message itself, any single bit error and any burst of up to 32 bits must be detected,
    /// as the checksum guarantees.
    #[test]
    fn what_the_checksum_guarantees_holds_for_the_content() {
        let touch = Input::default().open().unwrap();
        let serial = replay::run(touch, Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {})
            .unwrap()
            .serial;
        let longest = serial
            .split(|byte| *byte == 0)
            .max_by_key(|frame| frame.len())
            .unwrap();
        assert!(passing(longest).is_some());
        let plain = cobs::decode_vec(longest).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let bits = 8 * plain.len() as u32;
        for first in 0..bits - 32 {
            let mut damaged = plain.clone();
            let pattern = u64::from(rng.next_u32() | 1) << (first % 8);
            for (byte, errors) in damaged[first as usize / 8..]
                .iter_mut()
                .zip(pattern.to_le_bytes())
            {
                *byte ^= errors;
            }
            assert_eq!(
                passing(&cobs::encode_vec(&damaged)),
                None,
                "a burst from bit {first} on"
            );
        }
    }
}
