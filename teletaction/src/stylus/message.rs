//! Messages between a stylus and a PC: requests with replies, and events, each in a numbered
//! packet.
//!
//! Framing, checksum and packets are the finger's ([`ridgetone_proto`]). Every message carries a
//! [`Mark`], so a finger's reader treats a stylus's messages as damaged, and vice versa.

use super::gate::State;
use super::parameters::Parameters;
use crate::stimulus::Texture;
use ridgetone_proto::boot::Boot;
use ridgetone_proto::framing::{self, TooLong};
use ridgetone_proto::settings::SettingsError;
use ridgetone_proto::telemetry::{self, Events, PacketDecoder, WIRE_MAX};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// Version of the stylus's protocol; a reader refuses any other version.
pub const PROTOCOL: u8 = 3;

/// The byte before every command and event, larger than any variant number of the finger's
/// enumerations.
const MARK: u8 = b'S';

/// A command or an event, marked as a stylus's.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark<T>(pub T);

impl<T: Serialize> Serialize for Mark<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (MARK, &self.0).serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Mark<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (mark, content) = <(u8, T)>::deserialize(deserializer)?;
        if mark == MARK {
            Ok(Self(content))
        } else {
            Err(D::Error::custom("not a stylus's message"))
        }
    }
}

/// Type of bulk events, of which a stylus has none.
#[derive(Clone, Copy, Debug)]
pub enum Nothing {}

impl From<Nothing> for Mark<Event> {
    fn from(nothing: Nothing) -> Self {
        match nothing {}
    }
}

pub type Packet = telemetry::Packet<Mark<Event>>;

/// Decodes bytes to packets.
pub type Decoder = PacketDecoder<Mark<Event>>;

impl Events for Mark<Event> {
    const PROTOCOL: u8 = PROTOCOL;

    fn greeting(&self) -> Option<u8> {
        if let Event::Hello(hello) = &self.0 {
            Some(hello.protocol)
        } else {
            None
        }
    }

    /// Events are few and short, so there are no bulk events.
    type Bulk = Nothing;

    fn bulk(&self) -> Option<Nothing> {
        None
    }

    fn dated_us(&self) -> Option<u64> {
        match &self.0 {
            Event::Hello(hello) => Some(hello.t_us),
            Event::Reply(_) => None,
            Event::State(change) => Some(change.t_us),
            Event::Position(position) => Some(position.t_us),
            Event::Health(health) => Some(health.t_us),
        }
    }

    fn made_us(&self) -> Option<u64> {
        self.dated_us()
    }

    fn encode(
        packet: &telemetry::Packet<&Self>,
        wire: &mut [u8; WIRE_MAX],
    ) -> Result<usize, TooLong> {
        framing::encode(packet, wire)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Command {
    /// Use this texture from the next sample on.
    Texture(Texture),
    /// Use these parameters, only at rest (see [`Outcome::NotAtRest`]). The texture is erased, and
    /// the stylus must be enabled again.
    Configure(Parameters),
    /// Vibrate when the hand moves.
    Enable,
    /// Stop softly.
    Disable,
    /// Keep the line alive, as any complete request does. After [`Parameters::silence_s`] without a
    /// request the stylus stops.
    Alive,
}

/// A command with its number, which the reply repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the PC. A repeated number means a repeated request: the stylus replies again, but
    /// executes it only once.
    pub number: u16,
    pub command: Mark<Command>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    pub number: u16,
    pub outcome: Outcome,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    Done,
    /// A value of a texture or a parameter is impossible, such as a NaN; nothing has changed.
    Refused(SettingsError),
    /// Parameters change only while the output rests: send `Disable` first, and wait for
    /// [`Parameters`]' `fade_s`.
    NotAtRest,
}

/// A report of the stylus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// The stylus has started, or has new parameters.
    Hello(Hello),
    Reply(Reply),
    /// The stylus starts or stops vibrating.
    State(Change),
    Position(Position),
    Health(Health),
}

/// First event after start-up, repeated about every ten seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    pub protocol: u8,
    /// Firmware version: major, minor, patch.
    pub version: [u8; 3],
    pub sample_hz: u32,
    pub parameters: Parameters,
    /// Why the board started.
    pub boot: Boot,
    pub t_us: u64,
}

/// The stylus starts or stops vibrating.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    pub t_us: u64,
    pub state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Device time of the sample, microseconds.
    pub t_us: u64,
    /// Counts of the encoder since start-up, wrapping.
    pub counts: i32,
    /// Speed, millimetres per second, signed.
    pub speed_mm_s: f32,
}

/// Counters and readings, about once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    pub t_us: u64,
    /// Samples since start-up, missed ones included, wrapping.
    pub samples: u32,
    /// Samples that were not ready in time: the converter held the previous one.
    pub deadlines_missed: u32,
    /// Maximum time from a sample's trigger to the reading of the encoder, whole microseconds.
    pub latest_reading_us: u32,
    pub state: State,
    /// Current amplitude of the fundamental, volts.
    pub amplitude_v: f32,
    /// Requests that arrived damaged.
    pub requests_damaged: u32,
    /// Bytes of requests lost in the USART because the previous byte was not read in time.
    pub bytes_overrun: u32,
    /// Events dropped because the line was slow.
    pub messages_dropped: u32,
    /// Maximum number of stack bytes used since start-up; zero if not measured, as on a PC.
    pub stack_used_bytes: u32,
    pub stack_bytes: u32,
    /// Fraction of time that the processor was busy, 0 to 1; zero if not measured.
    pub load: f32,
}
