//! From bytes back to packets.

use super::event::Event;
use super::packet::{self, PROTOCOL, Packet};
use crate::framing::{self, Inbox, Pushed, TooLong, WIRE_MAX};
use core::marker::PhantomData;
use serde::de::DeserializeOwned;

/// The events of a kind of board.
pub trait Events: DeserializeOwned {
    /// Version of their wire contract.
    const PROTOCOL: u8;

    /// The version that a greeting names; none for other events. A greeting with number zero means
    /// a restart.
    fn greeting(&self) -> Option<u8>;

    /// Encodes a packet ([`crate::framing`]). Returns the bytes used of `wire`. Here, so that it is
    /// compiled, small, where the event is.
    fn encode(packet: &Packet<Self>, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong>;
}

impl Events for Event {
    const PROTOCOL: u8 = PROTOCOL;

    fn greeting(&self) -> Option<u8> {
        if let Self::Hello(hello) = self {
            Some(hello.protocol)
        } else {
            None
        }
    }

    fn encode(packet: &Packet, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong> {
        packet::encode(packet, wire)
    }
}

/// The finger's.
pub type Decoder = PacketDecoder<Event>;

/// Assembles packets from single bytes and counts the damaged and the missing ones.
#[derive(Debug)]
pub struct PacketDecoder<E> {
    inbox: Inbox<WIRE_MAX>,
    expected: Option<u16>,
    /// Frames that failed stuffing, checksum or content and were skipped.
    pub damaged: u32,
    /// Protocol of the device, if it is not [`Events::PROTOCOL`]: then its packets are not
    /// returned.
    pub foreign: Option<u8>,
    /// Packets that never arrived, by their sequence numbers. Of a gap of 32,768 or more only what
    /// is beyond whole multiples of 65,536 counts, if that is less than 32,768.
    pub missing: u32,
    /// Times that the numbers stepped back: the line repeated itself, or a restarted device's
    /// greeting was lost.
    pub stepped_back: u32,
    events: PhantomData<E>,
}

impl<E: Events> Default for PacketDecoder<E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<E: Events> PacketDecoder<E> {
    /// A new decoder; it finds its place at the next zero byte.
    pub const fn new() -> Self {
        Self {
            inbox: Inbox::new(),
            expected: None,
            damaged: 0,
            foreign: None,
            missing: 0,
            stepped_back: 0,
            events: PhantomData,
        }
    }

    /// Takes one byte; returns a packet when the byte completes one.
    pub fn push(&mut self, byte: u8) -> Option<Packet<E>> {
        let packet = match self.inbox.push(byte) {
            Pushed::More => return None,
            Pushed::Whole => self
                .inbox
                .take()
                .and_then(|mut frame| framing::decode::<Packet<E>>(&mut frame)),
            Pushed::Damaged => None,
        };
        let Some(packet) = packet else {
            self.damaged = self.damaged.saturating_add(1);
            return None;
        };
        let gap = match self.expected {
            // A greeting with number zero means a restart.
            Some(expected) if !(packet.sequence == 0 && packet.event.greeting().is_some()) => {
                packet.sequence.wrapping_sub(expected)
            }
            _ => 0,
        };
        // A gap of more than half the numbers is a step back: one repetition is not a loss of
        // 65,535.
        if gap <= u16::MAX / 2 {
            self.missing = self.missing.saturating_add(gap as u32);
        } else {
            self.stepped_back = self.stepped_back.saturating_add(1);
        }
        self.expected = Some(packet.sequence.wrapping_add(1));
        if let Some(protocol) = packet.event.greeting() {
            self.foreign = (protocol != E::PROTOCOL).then_some(protocol);
        }
        self.foreign.is_none().then_some(packet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boot::{Boot, SettingsSource};
    use crate::settings::Settings;
    use crate::telemetry::{Hello, Release, encode, longest_packet};
    extern crate std;

    fn estimate() -> Event {
        longest_packet().event
    }

    fn sent(sequence: u16, event: Event) -> std::vec::Vec<u8> {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).unwrap();
        wire[..used].to_vec()
    }

    #[test]
    fn the_longest_packet_is_decoded() {
        let bytes = sent(u16::MAX, estimate());
        let mut decoder = Decoder::new();
        let packets: std::vec::Vec<_> = bytes.iter().filter_map(|b| decoder.push(*b)).collect();
        assert_eq!(
            packets,
            [Packet {
                sequence: u16::MAX,
                event: estimate()
            }]
        );
        assert_eq!((decoder.damaged, decoder.missing), (0, 0));
    }

    #[test]
    fn every_damaged_byte_is_detected_and_the_next_packet_is_decoded() {
        let (bad, good) = (
            sent(7, estimate()),
            sent(8, Event::Release(Release { t_us: 5 })),
        );
        for place in 0..bad.len() - 1 {
            let mut bytes = bad.clone();
            bytes[place] ^= 0x10;
            bytes.extend(&good);
            let mut decoder = Decoder::new();
            let packets: std::vec::Vec<_> = bytes.iter().filter_map(|b| decoder.push(*b)).collect();
            assert_eq!(packets.len(), 1, "byte {place}");
            assert_eq!(packets[0].sequence, 8);
            assert!(decoder.damaged >= 1);
        }
    }

    #[test]
    fn losses_are_counted_by_sequence_across_the_wrap() {
        let mut decoder = Decoder::new();
        for sequence in [65_533, 65_534, 2, 3] {
            for byte in sent(sequence, Event::Release(Release { t_us: 5 })) {
                decoder.push(byte);
            }
        }
        assert_eq!((decoder.damaged, decoder.missing), (0, 3));
    }

    #[test]
    fn a_repetition_and_a_restart_without_greeting_are_no_losses() {
        let mut decoder = Decoder::new();
        for sequence in [40_000, 40_000, 40_001, 2, 3, 7] {
            for byte in sent(sequence, Event::Release(Release { t_us: 5 })) {
                decoder.push(byte);
            }
        }
        // 2 is 25,537 numbers ahead of 40,002, which a gap may be; 4 to 6 are lost.
        assert_eq!(
            (decoder.damaged, decoder.missing, decoder.stepped_back),
            (0, 25_536 + 3, 1)
        );
    }

    #[test]
    fn packets_of_another_protocol_are_not_returned() {
        let hello = |protocol| {
            let (settings, source, boot) =
                (Settings::DEFAULT, SettingsSource::Default, Boot::default());
            Event::Hello(Hello {
                protocol,
                version: [0, 1, 0],
                frame_rate_hz: 241.14,
                settings,
                source,
                boot,
            })
        };
        let mut decoder = Decoder::new();
        let received = |decoder: &mut Decoder, sequence, event| {
            sent(sequence, event)
                .iter()
                .filter_map(|byte| decoder.push(*byte))
                .count()
        };
        assert_eq!(received(&mut decoder, 0, hello(PROTOCOL + 1)), 0);
        assert_eq!(received(&mut decoder, 1, estimate()), 0);
        assert_eq!(decoder.foreign, Some(PROTOCOL + 1));
        assert_eq!(received(&mut decoder, 0, hello(PROTOCOL)), 1);
        assert_eq!(received(&mut decoder, 1, estimate()), 1);
        assert_eq!(
            (decoder.foreign, decoder.missing, decoder.damaged),
            (None, 0, 0)
        );
    }

    #[test]
    fn random_bytes_leave_the_decoder_ready() {
        let mut decoder = Decoder::new();
        let mut x = 1u32;
        for _ in 0..1_000_000 {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            assert_eq!(decoder.push((x >> 24) as u8), None);
        }
        decoder.push(0);
        let packets: std::vec::Vec<_> = sent(3, estimate())
            .iter()
            .filter_map(|b| decoder.push(*b))
            .collect();
        assert_eq!(packets.len(), 1);
    }
}
