//! Framing on the line, in both directions: postcard, then CRC-32 little endian, both COBS-stuffed,
//! then a zero byte.
//!
//! A reader may start anywhere; it synchronises at the next zero.

use heapless::Vec;
use serde::{Serialize, de::DeserializeOwned};

/// Maximum number of bytes of a message on the wire, including checksum, stuffing and delimiter.
pub const WIRE_MAX: usize = 512;

/// Bytes of the checksum after the content.
const CHECKSUM_BYTES: usize = 4;

/// Maximum number of bytes of a message before stuffing, including the checksum. COBS adds one byte
/// in 254 and one in front; the final zero is one more.
const PLAIN_MAX: usize = WIRE_MAX - WIRE_MAX / 254 - 2;

/// CRC-32 as in Ethernet and zip (polynomial 0x04C11DB7, reflected). Its table takes 1 KiB of flash:
/// without one a checksum was the longest part of an event's encoding, for which `detect` may wait.
pub(crate) static CHECKSUM: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Error: the message is longer on the wire than its buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the message is longer on the wire than its buffer")]
pub struct TooLong;

/// CRC-32 of some bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    CHECKSUM.checksum(bytes)
}

/// Encodes a message into `wire`, unless it is too long. Returns the number of bytes used.
pub fn encode<T: Serialize>(message: &T, wire: &mut [u8]) -> Result<usize, TooLong> {
    let mut plain = [0; PLAIN_MAX];
    let content = plain.get_mut(..PLAIN_MAX - CHECKSUM_BYTES).ok_or(TooLong)?;
    let length = postcard::to_slice(message, content)
        .map_err(|_| TooLong)?
        .len();
    seal(&mut plain, length, wire)
}

/// Encodes content that is not postcard into `wire`, unless it is too long. Returns the number of
/// bytes used.
pub fn encode_bytes(content: &[u8], wire: &mut [u8]) -> Result<usize, TooLong> {
    let mut plain = [0; PLAIN_MAX];
    plain
        .get_mut(..content.len())
        .ok_or(TooLong)?
        .copy_from_slice(content);
    seal(&mut plain, content.len(), wire)
}

/// Adds checksum, stuffing and the zero. Separate from [`encode`], so that it is compiled once for
/// all types.
fn seal(plain: &mut [u8; PLAIN_MAX], length: usize, wire: &mut [u8]) -> Result<usize, TooLong> {
    let checksum = checksum(plain.get(..length).ok_or(TooLong)?).to_le_bytes();
    plain
        .get_mut(length..length + CHECKSUM_BYTES)
        .ok_or(TooLong)?
        .copy_from_slice(&checksum);
    let content = plain.get(..length + CHECKSUM_BYTES).ok_or(TooLong)?;
    let used = cobs::try_encode(content, wire).map_err(|_| TooLong)?;
    *wire.get_mut(used).ok_or(TooLong)? = 0;
    Ok(used + 1)
}

/// Decodes one stuffed frame without its zero, in place; `None` if it is damaged.
pub fn decode<T: DeserializeOwned>(frame: &mut [u8]) -> Option<T> {
    let (message, rest) = postcard::take_from_bytes(unseal(frame)?).ok()?;
    rest.is_empty().then_some(message)
}

/// Returns the content of a stuffed frame, if its checksum matches.
pub fn unseal(frame: &mut [u8]) -> Option<&[u8]> {
    let length = cobs::decode_in_place(frame).ok()?;
    let (content, sum) = frame.get(..length)?.split_last_chunk::<CHECKSUM_BYTES>()?;
    (checksum(content) == u32::from_le_bytes(*sum)).then_some(content)
}

/// State of a frame after a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pushed {
    /// The frame is not complete.
    More,
    /// The frame is complete: [`Inbox::take`] returns it.
    Whole,
    /// The frame is dropped: it was longer than the buffer, lost bytes, or came before the previous
    /// frame was taken.
    Damaged,
}

/// Assembles single bytes into a frame. Holds one frame of up to `N` bytes.
#[derive(Debug, Default)]
pub struct Inbox<const N: usize> {
    bytes: Vec<u8, N>,
    whole: bool,
    /// True while bytes are dropped until the next zero.
    skipping: bool,
}

impl<const N: usize> Inbox<N> {
    /// Creates an empty inbox, which synchronises at the next zero byte.
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            whole: false,
            skipping: false,
        }
    }

    /// Takes one byte.
    pub fn push(&mut self, byte: u8) -> Pushed {
        if byte != 0 {
            if self.whole || self.skipping || self.bytes.push(byte).is_err() {
                self.spoil();
            }
            return Pushed::More;
        }
        if core::mem::take(&mut self.skipping) {
            return Pushed::Damaged;
        }
        // Repeated zeros are an idle line, not a frame.
        if self.whole || self.bytes.is_empty() {
            return Pushed::More;
        }
        self.whole = true;
        Pushed::Whole
    }

    /// Drops the current frame, because a byte of it was lost.
    pub fn spoil(&mut self) {
        self.skipping = true;
        if !self.whole {
            self.bytes.clear();
        }
    }

    /// Returns the complete frame, stuffed and without its zero, if there is one.
    pub fn whole(&self) -> Option<&[u8]> {
        self.whole.then_some(&*self.bytes)
    }

    /// Drops the complete frame, if there is one.
    pub fn drop_whole(&mut self) {
        if core::mem::take(&mut self.whole) {
            self.bytes.clear();
        }
    }

    /// Takes the complete frame, stuffed and without its zero, so that the next one can follow.
    pub fn take(&mut self) -> Option<Vec<u8, N>> {
        core::mem::take(&mut self.whole).then(|| core::mem::take(&mut self.bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    fn frame(number: u32) -> std::vec::Vec<u8> {
        let mut wire = [0; 32];
        let used = encode(&number, &mut wire).unwrap();
        wire[..used].to_vec()
    }

    fn push(inbox: &mut Inbox<16>, bytes: &[u8]) -> std::vec::Vec<Pushed> {
        bytes
            .iter()
            .map(|byte| inbox.push(*byte))
            .filter(|pushed| *pushed != Pushed::More)
            .collect()
    }

    #[test]
    fn a_frame_is_postcard_checksum_and_stuffing() {
        // 7 as a varint; the CRC-32 of one byte 7 is 0x4c667a2e by zlib; there is no zero among
        // these bytes, so COBS puts their number plus one in front.
        assert_eq!(frame(7), [6, 7, 0x2e, 0x7a, 0x66, 0x4c, 0]);
        assert_eq!(encode(&7u32, &mut [0; 6]), Err(TooLong));
    }

    #[test]
    fn one_frame_is_held_and_the_next_is_dropped_and_reported() {
        let mut inbox = Inbox::new();
        assert_eq!(push(&mut inbox, &[0, 0]), []);
        assert_eq!(push(&mut inbox, &frame(1)), [Pushed::Whole]);
        assert_eq!(push(&mut inbox, &frame(2)), [Pushed::Damaged]);
        let third = frame(3);
        assert_eq!(push(&mut inbox, &third[..3]), []);
        assert_eq!(
            inbox.take().and_then(|mut frame| decode::<u32>(&mut frame)),
            Some(1)
        );
        assert!(inbox.take().is_none());
        // The beginning of the frame was lost.
        assert_eq!(push(&mut inbox, &third[3..]), [Pushed::Damaged]);
        assert_eq!(push(&mut inbox, &frame(4)), [Pushed::Whole]);
        assert_eq!(
            inbox.take().and_then(|mut frame| decode::<u32>(&mut frame)),
            Some(4)
        );
    }

    #[test]
    fn a_frame_that_is_too_long_or_lacks_a_byte_is_dropped_and_reported() {
        let mut inbox = Inbox::new();
        assert_eq!(push(&mut inbox, &[1; 40]), []);
        assert_eq!(push(&mut inbox, &[0]), [Pushed::Damaged]);
        push(&mut inbox, &frame(5)[..2]);
        inbox.spoil();
        assert_eq!(push(&mut inbox, &frame(5)[3..]), [Pushed::Damaged]);
        assert_eq!(push(&mut inbox, &frame(6)), [Pushed::Whole]);
        assert_eq!(
            inbox.take().and_then(|mut frame| decode::<u32>(&mut frame)),
            Some(6)
        );
    }
}
