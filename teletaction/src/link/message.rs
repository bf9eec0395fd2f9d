//! Numbered messages, framed as on the serial line ([`ridgetone_proto::framing`]), and their
//! counts.

use crate::stimulus::Texture;
use ridgetone_proto::framing::{WIRE_MAX, decode, encode};
use serde::{Deserialize, Serialize};

/// A message. Each way has numbers of its own, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// Run of the sender: a new run counts from 0 again.
    pub run: u32,
    pub number: u32,
    /// Clock of the sender, seconds.
    pub t_s: f64,
    pub body: Body,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Body {
    /// Position of the hand, millimetres.
    Position(f64),
    /// Texture under the finger; `None` until the finger has found one, or if it is silent.
    Texture(Option<Texture>),
}

impl Message {
    /// Encodes the message, with the zero at the end.
    pub fn bytes(&self) -> Vec<u8> {
        let mut wire = [0; WIRE_MAX];
        // It is far shorter than the buffer.
        encode(self, &mut wire).map_or_else(|_| Vec::new(), |used| wire[..used].to_vec())
    }
}

/// Counts of one way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub received: u64,
    /// Numbers that have not come, or not yet.
    pub lost: u64,
    /// After a later one: they are not used.
    pub late: u64,
    pub doubled: u64,
    pub damaged: u64,
}

/// Numbers that are remembered, to tell what is doubled from what is late.
const REMEMBERED: usize = 1024;

/// Receiving end of one direction.
#[derive(Clone, Debug)]
pub struct Receiver {
    pub counts: Counts,
    run: u32,
    /// The number that is expected; `None` before the first message of a run, whatever its number.
    next: Option<u32>,
    /// Which of the latest numbers have come, by their remainder.
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
    /// Takes the bytes of a message; gives it if it is whole, and later than all before it.
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
            // It was counted as lost.
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
    /// Checks the numbers: a checksum of 32 bits lets one damaged message of four thousand millions
    /// through.
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
        // The sender begins anew; then another one, which sent to others before: nothing is lost.
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
