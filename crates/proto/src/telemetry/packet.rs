//! The packet: an event with its number.

use super::estimate::{
    Channel, Direction, Estimate, Movement, OtherTone, Span, Status, Travel, TravelStatus,
};
use super::event::Event;
use crate::fault::FaultSet;
use crate::framing::{self, TooLong, WIRE_MAX};
use crate::settings::TAXELS;
use serde::{Deserialize, Serialize};

/// Version of the wire protocol; readers refuse any other.
pub const PROTOCOL: u8 = 12;

/// An event with its number, so that a reader detects every loss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packet<E = Event> {
    /// Number of the packet since start-up, wrapping.
    pub sequence: u16,
    /// The event.
    pub event: E,
}

/// Encodes a packet ([`crate::framing`]) into `wire`. Returns the number of bytes used. Every event
/// fits.
pub fn encode(packet: &Packet, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong> {
    framing::encode(packet, wire)
}

/// Returns a packet whose fields all have their maximum length, for tests of buffers.
pub fn longest_packet() -> Packet {
    let channel = |taxel| Channel {
        taxel,
        offset_v: 2.5,
        amplitude_v: 1e-3,
        phase_rad: -3.1,
        residual_v: 5e-6,
    };
    let estimate = Estimate {
        t_us: u64::MAX,
        window_s: 1.0,
        span: Span::Slide,
        status: Status::Good,
        frequency: 8.333_333,
        sigma: 1e-3,
        movement: Movement {
            wander: 0.02,
            wander_sigma: 1e-3,
            chirp: 0.3,
            chirp_sigma: 1e-2,
        },
        other_tone: Some(OtherTone {
            frequency: 12.5,
            fraction: 0.4,
        }),
        interferer_hz: Some(50.02),
        harmonics: 5,
        frames_missing: u16::MAX,
        faults: FaultSet::NONE,
        travel: Travel {
            status: TravelStatus::Contradicted,
            direction: Direction::Backward,
            spatial_period_mm: 3.6,
            spatial_period_sigma_mm: 1e-3,
            speed_mm_s: 30.0,
            speed_sigma_mm_s: 1e-2,
        },
        channels: (0..TAXELS as u8).map(channel).collect(),
    };
    Packet {
        sequence: u16::MAX,
        event: Event::Estimate(estimate),
    }
}
