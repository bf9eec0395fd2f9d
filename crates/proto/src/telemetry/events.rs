//! Properties of events that the decoder needs, for each kind of board.

use super::estimate::Status;
use super::event::{Event, Raw};
use super::packet::{PROTOCOL, Packet};
use crate::fault::FaultKind;
use crate::framing::{self, TooLong, WIRE_MAX};
use serde::de::DeserializeOwned;

/// Log line for an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Headline {
    /// The finger touches.
    Contact,
    /// A slide begins.
    Slide,
    /// A slide ends.
    Stop,
    /// The finger is lifted.
    Release,
    /// Frequency and standard deviation, hertz, with their status.
    Estimate(f32, f32, Status),
    /// A fault begins, or ends.
    Fault(FaultKind, bool),
}

/// Events of one kind of board.
pub trait Events: DeserializeOwned {
    /// Version of the wire protocol of these events.
    const PROTOCOL: u8;

    /// Raw frames, which are sent after all other events and may be dropped.
    type Bulk: Copy + Into<Self>;

    /// Version in a greeting; `None` for other events.
    fn greeting(&self) -> Option<u8>;

    /// Raw frame, if the event is one.
    fn bulk(&self) -> Option<Self::Bulk>;

    /// Device time of the event, microseconds, if it has one.
    fn dated_us(&self) -> Option<u64>;

    /// Device time at which a greeting or `health` was created, microseconds. Other events have the
    /// time of what they report.
    fn made_us(&self) -> Option<u64>;

    /// Line that the log shows for the event, if any.
    fn headline(&self) -> Option<Headline> {
        None
    }

    /// Encodes a packet ([`crate::framing`]) into `wire`. Returns the number of bytes used.
    /// Implemented by the event type, so that it is compiled in the crate of the events, which is
    /// optimised for size.
    fn encode(packet: &Packet<&Self>, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong>;
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

    fn headline(&self) -> Option<Headline> {
        Some(match self {
            Self::Contact(_) => Headline::Contact,
            Self::Slide(slide) if slide.end_us.is_none() => Headline::Slide,
            Self::Slide(_) => Headline::Stop,
            Self::Release(_) => Headline::Release,
            Self::Estimate(one) => Headline::Estimate(one.frequency, one.sigma, one.status),
            Self::Fault(fault) => Headline::Fault(fault.kind, fault.until_us.is_some()),
            _ => return None,
        })
    }

    type Bulk = Raw;

    fn bulk(&self) -> Option<Raw> {
        if let Self::Raw(raw) = self {
            Some(*raw)
        } else {
            None
        }
    }

    fn dated_us(&self) -> Option<u64> {
        self.t_us()
    }

    fn made_us(&self) -> Option<u64> {
        match self {
            Self::Hello(hello) => Some(hello.t_us),
            Self::Health(health) => Some(health.t_us),
            _ => None,
        }
    }

    fn encode(packet: &Packet<&Self>, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong> {
        framing::encode(packet, wire)
    }
}
