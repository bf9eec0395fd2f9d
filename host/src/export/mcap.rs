//! MCAP (<https://mcap.dev>): a channel of JSON for each kind of packet, with a schema, at device time. No compression, which would
//! need C.

use super::packets::packets;
use super::schema::Schema;
use crate::events::JsonLines;
use crate::live::{Counts, time_s};
use ::mcap::records::MessageHeader;
use ::mcap::write::{NoSeek, WriteOptions};
use anyhow::{Result, bail};
use ridgetone_proto::telemetry::Packet;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Writes all packets. It reads the recording twice: schemas come first.
pub fn write(path: &Path, out: &mut dyn Write) -> Result<Counts> {
    let mut schemas: BTreeMap<String, Schema> = BTreeMap::new();
    let mut messages = Messages::new();
    packets(path, &mut |packet| {
        let (kind, message) = messages.message(packet)?;
        schemas.entry(kind).or_default().see(&message);
        Ok(())
    })?;
    if schemas.is_empty() {
        bail!("{}: holds no packets", path.display());
    }
    let options = WriteOptions::new().compression(None).library("ridgetone").disable_seeking(true);
    let mut file = options.create(NoSeek::new(out))?;
    let mut channels = BTreeMap::new();
    for (kind, schema) in &schemas {
        let schema =
            file.add_schema(&format!("ridgetone.{kind}"), "jsonschema", schema.json().to_string().as_bytes())?;
        let channel = file.add_channel(schema, &format!("/ridgetone/{kind}"), "json", &BTreeMap::new())?;
        channels.insert(kind, channel);
    }
    let mut messages = Messages::new();
    let counts = packets(path, &mut |packet| {
        let (kind, message) = messages.message(packet)?;
        let Some(channel_id) = channels.get(&kind).copied() else { return Ok(()) };
        let time = messages.time_ns;
        let header = MessageHeader { channel_id, sequence: packet.sequence.into(), log_time: time, publish_time: time };
        Ok(file.write_to_known_channel(&header, message.to_string().as_bytes())?)
    })?;
    file.finish()?;
    Ok(counts)
}

/// Turns packets into messages.
struct Messages {
    json: JsonLines,
    /// Device time of the latest packet that has one.
    time_ns: u64,
}

impl Messages {
    fn new() -> Self {
        Self { json: JsonLines::default(), time_ns: 0 }
    }

    /// Kind of a packet and its object of `--json`.
    fn message(&mut self, packet: &Packet) -> Result<(String, Value)> {
        if let Some(t_s) = time_s(&packet.event) {
            self.time_ns = (t_s * 1e6).round() as u64 * 1000;
        }
        let message = serde_json::to_value(self.json.serializable(packet))?;
        let kind = message["type"].as_str().unwrap_or("unknown").to_owned();
        Ok((kind, message))
    }
}
