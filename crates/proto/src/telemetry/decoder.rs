//! Decodes bytes into packets.

use super::event::Event;
use super::events::Events;
use super::packet::Packet;
use super::starts::Starts;
use crate::framing::{self, Inbox, Pushed, WIRE_MAX};
use core::marker::PhantomData;

/// Decoder of the finger's events.
pub type Decoder = PacketDecoder<Event>;

/// Assembles packets from single bytes and counts damaged and missing packets.
#[derive(Debug)]
pub struct PacketDecoder<E> {
    inbox: Inbox<WIRE_MAX>,
    /// Bytes since the latest zero, or since bytes were last counted as damaged.
    unended: usize,
    is_counted: bool,
    expected: Option<u16>,
    starts: Starts,
    /// Frames that were skipped because of stuffing, checksum or content. If no frame ever ends, as
    /// at a wrong baud rate, every [`WIRE_MAX`] bytes count as one.
    pub damaged: u32,
    /// Protocol of the device, if it differs from [`Events::PROTOCOL`]: then its packets are not
    /// returned.
    pub foreign: Option<u8>,
    /// Packets that never arrived, according to their sequence numbers. A gap of 32,768 or more
    /// counts modulo 65,536, and only if that is less than 32,768.
    pub missing: u32,
    /// Number of times that the sequence stepped back: packets were repeated, or the greeting of a
    /// restarted device was lost.
    pub stepped_back: u32,
    events: PhantomData<E>,
}

impl<E: Events> Default for PacketDecoder<E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<E: Events> PacketDecoder<E> {
    /// Creates a decoder, which synchronises at the next zero byte.
    pub const fn new() -> Self {
        Self {
            inbox: Inbox::new(),
            unended: 0,
            is_counted: false,
            expected: None,
            starts: Starts::new(),
            damaged: 0,
            foreign: None,
            missing: 0,
            stepped_back: 0,
            events: PhantomData,
        }
    }

    /// Takes one byte; returns a packet when the byte completes one.
    pub fn push(&mut self, byte: u8) -> Option<Packet<E>> {
        if self.is_endless(byte) {
            self.damaged = self.damaged.saturating_add(1);
        }
        let packet = match self.inbox.push(byte) {
            Pushed::More => return None,
            Pushed::Whole => self
                .inbox
                .take()
                .and_then(|mut frame| framing::decode::<Packet<E>>(&mut frame)),
            Pushed::Damaged => None,
        };
        let is_counted = core::mem::take(&mut self.is_counted);
        let Some(packet) = packet else {
            self.damaged = self.damaged.saturating_add(u32::from(!is_counted));
            return None;
        };
        if self.starts.take(&packet.event) {
            // Sequence numbers begin at zero.
            self.expected = Some(0);
        }
        let gap = self
            .expected
            .map_or(0, |expected| packet.sequence.wrapping_sub(expected));
        // A gap of more than half the numbers is a step back, so that a repetition does not count
        // as a loss of 65,535.
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

    /// True after every [`WIRE_MAX`] bytes without a zero, which cannot be a frame.
    fn is_endless(&mut self, byte: u8) -> bool {
        self.unended = if byte == 0 { 0 } else { self.unended + 1 };
        let is_endless = self.unended == WIRE_MAX;
        if is_endless {
            (self.unended, self.is_counted) = (0, true);
        }
        is_endless
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boot::{Boot, SettingsSource};
    use crate::settings::Settings;
    use crate::telemetry::{
        Health, Hello, PROTOCOL, Release, Status, Track, encode, longest_packet,
    };
    extern crate std;
    use std::vec::Vec;

    fn estimate() -> Event {
        longest_packet().event
    }

    fn sent(sequence: u16, event: Event) -> Vec<u8> {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).unwrap();
        wire[..used].to_vec()
    }

    fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Packet> {
        bytes
            .iter()
            .filter_map(|byte| decoder.push(*byte))
            .collect()
    }

    fn release() -> Event {
        Event::Release(Release {
            t_us: 5,
            reported_after_us: 0,
        })
    }

    #[test]
    fn a_track_takes_at_most_32_bytes() {
        let event = Event::Track(Track {
            t_us: u64::MAX,
            frequency: f32::MAX,
            sigma: f32::MAX,
            status: Status::Unsteady,
        });
        let wire = sent(u16::MAX, event.clone());
        assert!(wire.len() <= 32, "{} bytes", wire.len());
        let packets = decode(&mut Decoder::new(), &wire);
        let sequence = u16::MAX;
        assert_eq!(packets, [Packet { sequence, event }]);
    }

    #[test]
    fn the_longest_packet_is_decoded() {
        let (sequence, event) = (u16::MAX, estimate());
        let mut decoder = Decoder::new();
        let packets = decode(&mut decoder, &sent(sequence, event.clone()));
        assert_eq!(packets, [Packet { sequence, event }]);
        assert_eq!((decoder.damaged, decoder.missing), (0, 0));
    }

    #[test]
    fn every_damaged_byte_is_detected_and_the_next_packet_is_decoded() {
        let (bad, good) = (sent(7, estimate()), sent(8, release()));
        for place in 0..bad.len() - 1 {
            let mut bytes = [&bad[..], &good].concat();
            bytes[place] ^= 0x10;
            let mut decoder = Decoder::new();
            let sequences: Vec<_> = decode(&mut decoder, &bytes)
                .iter()
                .map(|packet| packet.sequence)
                .collect();
            assert_eq!(sequences, [8], "byte {place}");
            assert!(decoder.damaged >= 1);
        }
    }

    #[test]
    fn losses_are_counted_by_sequence_and_a_repetition_is_none() {
        for (sequences, missing, stepped_back) in [
            // A gap across the wrap of the numbers.
            (&[65_533, 65_534, 2, 3][..], 3, 0),
            // A restart without greeting: 2 is 25,537 numbers ahead of 40,002, which could be a
            // gap; 4 to 6 are lost.
            (&[40_000, 40_000, 40_001, 2, 3, 7], 25_536 + 3, 1),
        ] {
            let mut decoder = Decoder::new();
            for sequence in sequences {
                decode(&mut decoder, &sent(*sequence, release()));
            }
            let found = (decoder.damaged, decoder.missing, decoder.stepped_back);
            assert_eq!(found, (0, missing, stepped_back));
        }
    }

    #[test]
    fn a_restart_is_time_that_goes_back_and_never_a_number() {
        let mut decoder = Decoder::new();
        for (what, sequence, event, missing) in [
            ("health", 65_533, health(9_000_000), 0),
            (
                "two lost, a greeting numbered zero by wrap",
                0,
                hello(PROTOCOL, 10_000_000),
                2,
            ),
            ("health", 1, health(10_000_000), 2),
            ("a restart", 0, hello(PROTOCOL, 0), 2),
            ("health", 1, health(9_000_000), 2),
            ("a restart whose greeting is lost", 2, health(1_000_000), 4),
        ] {
            decode(&mut decoder, &sent(sequence, event));
            assert_eq!(
                (decoder.missing, decoder.stepped_back),
                (missing, 0),
                "{what}"
            );
        }
    }

    #[test]
    fn a_line_without_an_end_is_damaged() {
        let mut decoder = Decoder::new();
        for _ in 0..10 * WIRE_MAX {
            assert_eq!(decoder.push(0x55), None);
        }
        assert_eq!(decoder.damaged, 10);
        // The frame before this zero was already counted.
        decoder.push(0);
        assert_eq!(decoder.damaged, 10);
    }

    fn health(t_us: u64) -> Event {
        Event::Health(Health {
            t_us,
            ..Health::default()
        })
    }

    fn hello(protocol: u8, t_us: u64) -> Event {
        let (settings, source, boot) =
            (Settings::DEFAULT, SettingsSource::Default, Boot::default());
        Event::Hello(Hello {
            protocol,
            version: [0, 1, 0],
            frame_rate_hz: 241.14,
            settings,
            source,
            boot,
            t_us,
        })
    }

    #[test]
    fn packets_of_another_protocol_are_not_returned() {
        let mut decoder = Decoder::new();
        for (protocol, count, foreign) in
            [(PROTOCOL + 1, 0, Some(PROTOCOL + 1)), (PROTOCOL, 1, None)]
        {
            for (sequence, event) in [(0, hello(protocol, 0)), (1, estimate())] {
                assert_eq!(decode(&mut decoder, &sent(sequence, event)).len(), count);
            }
            assert_eq!(decoder.foreign, foreign);
        }
        assert_eq!((decoder.missing, decoder.damaged), (0, 0));
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
        assert_eq!(decode(&mut decoder, &sent(3, estimate())).len(), 1);
    }
}
