//! What a robot streams: where its finger is on the surface, or how fast it moves, each with a
//! stamp of the robot's own clock.
//!
//! Messages travel between requests, up to 250 a second, framed as they are ([`crate::framing`]),
//! and get no reply. The content has a fixed length, so that a robot needs no library for it; all
//! numbers are little endian:
//!
//! | bytes | content |
//! |---|---|
//! | 0, 1 | FF FF: with byte 2 this is no request, whose number would have more than 16 bits |
//! | 2 | 4: a place; 5: a speed |
//! | 3, 4 | number of the message, wrapping |
//! | 5 to 8 | the robot's stamp, microseconds, wrapping |
//! | 9 to 12 | the place, `i32`, tenths of a micrometre, wrapping; or the speed, `f32`, millimetres per second |
//!
//! Then CRC-32, stuffing and a zero byte: [`WIRE_BYTES`] in all.

use crate::framing;

/// Bytes of the content.
const CONTENT_BYTES: usize = 13;

/// Bytes of a message without the zero at its end: content, four of checksum, one of stuffing.
pub const FRAME_BYTES: usize = CONTENT_BYTES + 5;

/// Bytes of a message on the wire.
pub const WIRE_BYTES: usize = FRAME_BYTES + 1;

/// Units of a place in a millimetre. A place wraps after 429 m; only differences count.
pub const PLACE_PER_MM: f32 = 1e4;

/// Fastest speed, millimetres per second: as fast as
/// [`SlideRule::Protocol`](crate::settings::SlideRule::Protocol) may be.
pub const SPEED_MAX_MM_S: f32 = 2000.0;

/// First bytes of every message.
const MARK: [u8; 2] = [0xff, 0xff];
/// Third byte of a message with a place, and of one with a speed.
const PLACE: u8 = 4;
const SPEED: u8 = 5;

/// What the robot measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Place along the surface, tenths of a micrometre, wrapping.
    Place(i32),
    /// Speed over the surface, millimetres per second; negative against +x.
    Speed(f32),
}

/// One message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// Its number, one more than that of the message before, wrapping.
    pub number: u16,
    /// When the robot has measured it, by the robot's clock, microseconds, wrapping.
    pub t_us: u32,
    /// What it has measured.
    pub reading: Reading,
}

impl Odometry {
    /// The message as it travels.
    pub fn encode(&self) -> [u8; WIRE_BYTES] {
        let (kind, value) = match self.reading {
            Reading::Place(place) => (PLACE, place.to_le_bytes()),
            Reading::Speed(mm_s) => (SPEED, mm_s.to_le_bytes()),
        };
        let [a, b] = self.number.to_le_bytes();
        let [c, d, e, f] = self.t_us.to_le_bytes();
        let [g, h, i, j] = value;
        let mut wire = [0; WIRE_BYTES];
        // It always fits.
        let _ = framing::encode_bytes(
            &[MARK[0], MARK[1], kind, a, b, c, d, e, f, g, h, i, j],
            &mut wire,
        );
        wire
    }

    /// Whether a stuffed frame without its zero claims to be a message. Its checksum is not looked
    /// at.
    pub fn claims(frame: &[u8]) -> bool {
        frame.len() == FRAME_BYTES && matches!(frame, [_, 0xff, 0xff, PLACE | SPEED, ..])
    }

    /// Decodes a stuffed frame without its zero, in place; none if it is damaged.
    pub fn decode(frame: &mut [u8]) -> Option<Self> {
        let content: &[u8; CONTENT_BYTES] = framing::unseal(frame)?.try_into().ok()?;
        let [mark @ .., _, _, _, _, _, _, _, _, _, _, _] = content;
        let [_, _, kind, a, b, c, d, e, f, value @ ..] = *content;
        if *mark != MARK {
            return None;
        }
        let reading = match kind {
            PLACE => Reading::Place(i32::from_le_bytes(value)),
            SPEED => Reading::Speed(f32::from_le_bytes(value)),
            _ => return None,
        };
        Some(Self {
            number: u16::from_le_bytes([a, b]),
            t_us: u32::from_le_bytes([c, d, e, f]),
            reading,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Request;

    const PLACED: Odometry = Odometry {
        number: 0x0201,
        t_us: 0x0605_0403,
        reading: Reading::Place(-2),
    };

    #[test]
    fn a_message_is_its_table_checksum_and_stuffing() {
        let wire = PLACED.encode();
        // CRC-32 of the thirteen bytes by zlib: 0xb6248b1e. No byte is zero, so COBS counts all of
        // them.
        let expected = [
            18, 255, 255, 4, 1, 2, 3, 4, 5, 6, 0xfe, 255, 255, 255, 0x1e, 0x8b, 0x24, 0xb6, 0,
        ];
        assert_eq!(wire, expected);
    }

    #[test]
    fn messages_survive_the_wire_and_damaged_ones_are_refused() {
        for reading in [
            Reading::Place(0),
            Reading::Place(i32::MIN),
            Reading::Speed(-197.5),
            Reading::Speed(0.0),
        ] {
            for (number, t_us) in [(0, 0), (u16::MAX, u32::MAX), (256, 1 << 24)] {
                let message = Odometry {
                    number,
                    t_us,
                    reading,
                };
                let mut wire = message.encode();
                let frame = &mut wire[..FRAME_BYTES];
                assert!(Odometry::claims(frame) && !frame.contains(&0));
                assert_eq!(Odometry::decode(frame), Some(message));
            }
        }
        for at in 0..FRAME_BYTES {
            for bit in 0..8 {
                let mut wire = PLACED.encode();
                wire[at] ^= 1 << bit;
                assert_eq!(
                    Odometry::decode(&mut wire[..FRAME_BYTES]),
                    None,
                    "bit {bit} of byte {at}"
                );
            }
        }
    }

    /// Neither is taken for the other.
    #[test]
    fn no_message_is_a_request() {
        assert_eq!(
            framing::decode::<Request>(&mut PLACED.encode()[..FRAME_BYTES]),
            None
        );
        let mut wire = [0; 32];
        for number in [0xffff, 0x7fff, 0x3fff] {
            for command in [
                crate::command::Command::Greet,
                crate::command::Command::Raw { frames: u32::MAX },
            ] {
                let used = framing::encode(&Request { number, command }, &mut wire).unwrap();
                assert!(!Odometry::claims(&wire[..used - 1]));
            }
        }
    }
}
