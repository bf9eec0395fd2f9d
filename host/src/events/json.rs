//! One JSON object per packet. f32 values keep their shortest form, which reads back to the same
//! f32.

use super::view::{Message, Received};
use crate::digits::seconds;
use crate::utc::{Receipt, UtcClock};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet};
use serde::Serialize;

/// Formats a packet as one JSON object on one line, without the line end.
pub fn json(packet: &Packet) -> serde_json::Result<String> {
    serde_json::to_string(&serializable(packet))
}

/// Returns a packet in the form of [`json`], for a serializer.
pub fn serializable(packet: &Packet) -> impl Serialize {
    Message::new(packet, None)
}

/// Formats the packets of a board as [`json`] does, with volts next to the codes of raw frames.
/// Needs all packets, because the greeting has the reference voltage.
#[derive(Clone, Debug)]
pub struct JsonLines {
    vref_v: f32,
    clock: UtcClock,
}

impl Default for JsonLines {
    fn default() -> Self {
        Self {
            vref_v: Settings::DEFAULT.vref_v,
            clock: UtcClock::default(),
        }
    }
}

impl JsonLines {
    /// Formats a packet as one JSON object on one line, without the line end.
    pub fn line(
        &mut self,
        packet: &Packet,
        receipt: Option<Receipt>,
    ) -> serde_json::Result<String> {
        serde_json::to_string(&self.message(packet, receipt))
    }

    /// Converts a packet to a serializable message, with UTC times if it has a receipt.
    pub fn message(&mut self, packet: &Packet, receipt: Option<Receipt>) -> Message {
        if let Event::Hello(hello) = &packet.event {
            self.vref_v = hello.settings.vref_v;
        }
        let mut message = Message::new(packet, Some(self.vref_v));
        message.receipt = receipt.map(|receipt| {
            self.clock.take(packet, receipt);
            let utc = packet
                .event
                .t_us()
                .and_then(|t_us| self.clock.utc(seconds(t_us)));
            let is_health = matches!(packet.event, Event::Health(_));
            Received {
                received_utc_s: receipt.utc_s(),
                utc_s: utc.map(|utc| utc.utc_s()),
                utc_sigma_s: utc.and_then(|utc| utc.sigma_s),
                relation: utc.filter(|_| is_health).map(|utc| utc.relation),
            }
        });
        message
    }
}

#[cfg(test)]
mod tests;
