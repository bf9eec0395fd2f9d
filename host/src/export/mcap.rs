//! MCAP (<https://mcap.dev>): a channel of JSON for each kind of packet, with a schema, at UTC. No
//! compression, which would need C.

use super::packets::packets;
use super::schema::Schema;
use crate::digits::time_s;
use crate::events::JsonLines;
use crate::live::Counts;
use crate::utc::{Receipt, UtcClock};
use ::mcap::records::MessageHeader;
use ::mcap::write::{NoSeek, WriteOptions};
use anyhow::{Result, bail};
use ridgetone_proto::telemetry::Packet;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Writes all packets. It reads the recording twice: schemas come first, and what the whole of it
/// says of the board's clock.
///
/// `log_time` is when a message's moment was in UTC, `publish_time` when it was received. Without
/// times of receipt both are device time.
pub fn write(path: &Path, out: &mut dyn Write) -> Result<Counts> {
    let mut schemas: BTreeMap<String, Schema> = BTreeMap::new();
    let mut messages = Messages::default();
    packets(path, &mut |packet, receipt| {
        messages.learn(packet, receipt);
        let (kind, message) = messages.message(packet, receipt)?;
        schemas.entry(kind).or_default().see(&message);
        Ok(())
    })?;
    if schemas.is_empty() {
        bail!("{}: holds no packets", path.display());
    }
    let options = WriteOptions::new()
        .compression(None)
        .library("ridgetone")
        .disable_seeking(true);
    let mut file = options.create(NoSeek::new(out))?;
    let mut channels = BTreeMap::new();
    for (kind, schema) in &schemas {
        let schema = file.add_schema(
            &format!("ridgetone.{kind}"),
            "jsonschema",
            schema.json().to_string().as_bytes(),
        )?;
        let channel = file.add_channel(
            schema,
            &format!("/ridgetone/{kind}"),
            "json",
            &BTreeMap::new(),
        )?;
        channels.insert(kind, channel);
    }
    messages = messages.again();
    let counts = packets(path, &mut |packet, receipt| {
        let (kind, message) = messages.message(packet, receipt)?;
        let Some(channel_id) = channels.get(&kind).copied() else {
            return Ok(());
        };
        let log_time = messages.time_ns;
        let publish_time = receipt.map_or(log_time, |receipt| receipt.utc_ns);
        let header = MessageHeader {
            channel_id,
            sequence: packet.sequence.into(),
            log_time,
            publish_time,
        };
        Ok(file.write_to_known_channel(&header, message.to_string().as_bytes())?)
    })?;
    file.finish()?;
    Ok(counts)
}

/// Turns packets into messages.
#[derive(Default)]
struct Messages {
    json: JsonLines,
    /// The board's clock from each of its starts to the next, as far as it was learned.
    clocks: Vec<UtcClock>,
    /// The start that is being read.
    start: usize,
    /// Time of the latest packet that has one: UTC, or device time if nothing was learned.
    time_ns: u64,
}

impl Messages {
    /// The same from the beginning, with what was learned.
    fn again(self) -> Self {
        Self {
            clocks: self.clocks,
            ..Self::default()
        }
    }

    fn learn(&mut self, packet: &Packet, receipt: Option<Receipt>) {
        let Some(receipt) = receipt else { return };
        if self.clocks.is_empty() || UtcClock::restarts(packet) {
            self.clocks.push(UtcClock::default());
        }
        if let Some(clock) = self.clocks.last_mut() {
            clock.take(packet, receipt);
        }
    }

    /// Kind of a packet and its object of `--json`.
    fn message(&mut self, packet: &Packet, receipt: Option<Receipt>) -> Result<(String, Value)> {
        let mut message = serde_json::to_value(self.json.serializable(packet, receipt))?;
        // A recording may begin with a start of the board, or in the middle of a run.
        self.start += usize::from(UtcClock::restarts(packet));
        let clock = self.clocks.get(self.start.saturating_sub(1));
        if let Some(t_s) = time_s(&packet.event) {
            self.time_ns = (t_s * 1e6).round() as u64 * 1000;
            if let Some(utc) = clock.and_then(|clock| clock.utc(t_s)) {
                self.time_ns = utc.utc_ns;
                message["utc_s"] = utc.utc_s().into();
                message["utc_sigma_s"] = utc.sigma_s.into();
            }
        } else if let Some(receipt) = receipt {
            self.time_ns = receipt.utc_ns;
        }
        let kind = message["type"].as_str().unwrap_or("unknown").to_owned();
        Ok((kind, message))
    }
}
