//! Numbered messages, framed as on the serial line ([`ridgetone_proto::framing`]), and their
//! counts.

use crate::stimulus::Texture;
use ridgetone_proto::framing::{WIRE_MAX, decode, encode};
use serde::{Deserialize, Serialize};

/// A message. Each direction is numbered separately, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// Run of the sender; each run counts from 0.
    pub run: u32,
    pub number: u32,
    /// Time on the sender's clock, seconds.
    pub t_s: f64,
    pub body: Body,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Body {
    /// Position of the hand, millimetres.
    Position(f64),
    /// Texture under the finger; `None` if the finger has found none or is silent.
    Texture(Option<Texture>),
}

impl Message {
    /// Encodes the message, with the terminating zero.
    pub fn bytes(&self) -> Vec<u8> {
        let mut wire = [0; WIRE_MAX];
        // A message is far shorter than the buffer.
        encode(self, &mut wire).map_or_else(|_| Vec::new(), |used| wire[..used].to_vec())
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub received: u64,
    /// Missing numbers, including messages still on the way.
    pub lost: u64,
    /// Messages that arrived after a later one, and are not used.
    pub late: u64,
    pub doubled: u64,
    pub damaged: u64,
}

/// Recent numbers kept to tell duplicate messages from late ones.
const REMEMBERED: usize = 1024;

/// Receiving end of one direction.
#[derive(Clone, Debug)]
pub struct Receiver {
    pub counts: Counts,
    run: u32,
    /// Next expected number; `None` before the first message of a run, which may have any number.
    next: Option<u32>,
    /// Recently received numbers: number n is at index n modulo [`REMEMBERED`].
    seen: Vec<Option<u32>>,
}

impl Default for Receiver {
    fn default() -> Self {
        Self {
            counts: Counts::default(),
            run: 0,
            next: None,
            seen: vec![None; REMEMBERED],
        }
    }
}

impl Receiver {
    /// Decodes a message; returns it if it is undamaged and newer than all before.
    pub fn take(&mut self, bytes: &[u8]) -> Option<Message> {
        let mut frame = bytes.strip_suffix(&[0]).unwrap_or(bytes).to_vec();
        let message = decode::<Message>(&mut frame).filter(|message| message.is_possible());
        let Some(message) = message else {
            self.counts.damaged += 1;
            return None;
        };
        if message.run != self.run {
            *self = Self {
                counts: self.counts,
                run: message.run,
                ..Self::default()
            };
        }
        let position = message.number as usize % REMEMBERED;
        if self.seen[position] == Some(message.number) {
            self.counts.doubled += 1;
            return None;
        }
        self.seen[position] = Some(message.number);
        let next = self.next.unwrap_or(message.number);
        if message.number < next {
            // This message was counted as lost.
            self.counts.lost = self.counts.lost.saturating_sub(1);
            self.counts.late += 1;
            return None;
        }
        self.counts.lost += u64::from(message.number - next);
        self.counts.received += 1;
        self.next = Some(message.number.saturating_add(1));
        Some(message)
    }
}

impl Message {
    /// Returns true if the values are in range: a 32-bit checksum passes one in four thousand
    /// million damaged messages.
    fn is_possible(&self) -> bool {
        self.t_s.is_finite()
            && match &self.body {
                Body::Position(position_mm) => position_mm.abs() < 1e9,
                Body::Texture(texture) => texture.is_none_or(|texture| texture.check().is_ok()),
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn position(number: u32) -> Message {
        Message {
            run: 7,
            number,
            t_s: 0.004 * f64::from(number),
            body: Body::Position(f64::from(number)),
        }
    }

    #[test]
    fn what_is_lost_late_doubled_or_damaged_is_counted() {
        let mut receiver = Receiver::default();
        for number in [0, 1, 5, 3, 5, 3, 6] {
            let is_new =
                [0, 1, 5, 6].contains(&number) && receiver.next.is_none_or(|next| next <= number);
            assert_eq!(
                receiver.take(&position(number).bytes()).is_some(),
                is_new,
                "{number}"
            );
        }
        // 2 and 4 are missing; 3 came late and twice, and 5 twice.
        let counts = Counts {
            received: 4,
            lost: 2,
            late: 1,
            doubled: 2,
            damaged: 0,
        };
        assert_eq!(receiver.counts, counts);
        let good = position(7).bytes();
        for bit in 0..8 * (good.len() - 1) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(receiver.take(&bad), None, "{bit}");
        }
        assert_eq!(receiver.take(&[]), None);
        assert_eq!(
            receiver.counts,
            Counts {
                damaged: 8 * (good.len() as u64 - 1) + 1,
                ..counts
            }
        );
        assert!(receiver.take(&good).is_some());
        // The sender restarts; then a different sender takes over, which has already sent messages
        // to others. Neither counts as a loss.
        let lost = receiver.counts.lost;
        for (run, number) in [(8, 0), (9, 15_000)] {
            let message = Message {
                run,
                ..position(number)
            };
            assert!(receiver.take(&message.bytes()).is_some());
        }
        assert_eq!(receiver.counts.lost, lost);
    }

    #[test]
    fn impossible_numbers_are_damage() {
        let mut receiver = Receiver::default();
        let texture = |period_mm| Body::Texture(Some(Texture::new(period_mm)));
        let message = |t_s, body| Message {
            t_s,
            body,
            ..position(0)
        };
        for (t_s, body) in [
            (0.0, texture(f32::NAN)),
            (0.0, texture(-1.0)),
            (0.0, texture(1e9)),
            (0.0, Body::Position(f64::NAN)),
            (0.0, Body::Position(1e300)),
            (f64::NAN, Body::Position(0.0)),
        ] {
            assert_eq!(receiver.take(&message(t_s, body).bytes()), None, "{body:?}");
        }
        assert_eq!((receiver.counts.damaged, receiver.counts.received), (6, 0));
        assert!(receiver.take(&message(0.0, texture(1.4)).bytes()).is_some());
    }
}
