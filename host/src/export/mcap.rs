//! MCAP (<https://mcap.dev>): the topics, schemas and messages of `serve`, with UTC times. Not
//! compressed, because that would need a C library.

use super::packets::packets;
use crate::digits::time_s;
use crate::events::JsonLines;
use crate::live::Counts;
use crate::serve::message::Streamed;
use crate::serve::schema;
use crate::serve::topic::{Names, Topic};
use crate::settings_form;
use crate::utc::{Receipt, UtcClock};
use anyhow::{Result, bail};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};
use ridgetone_proto::telemetry::{Event, Hello, Packet, Starts};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;

/// Writes all packets. Reads the recording twice: the channels come first in the file, and relating
/// the board's clock to UTC takes the whole recording.
///
/// `log_time` is the UTC time of a message's event, `publish_time` that of its receipt. Without
/// times of receipt both are device time.
pub fn write(path: &Path, out: &mut dyn Write) -> Result<Counts> {
    let mut messages = Messages::default();
    let (mut is_empty, mut hello) = (true, None);
    packets(path, &mut |packet, receipt| {
        messages.learn(packet, receipt);
        is_empty = false;
        if let (Event::Hello(found), None) = (&packet.event, &hello) {
            hello = Some(found.clone());
        }
        Ok(())
    })?;
    if is_empty {
        bail!("{}: holds no packets", path.display());
    }
    let mut file = WriteOptions::new()
        .compression(None)
        .library("ridgetone")
        .disable_seeking(true)
        .create(NoSeek::new(out))?;
    let channels = channels(&mut file, hello.as_ref())?;
    let counts = packets(path, &mut |packet, receipt| {
        let (topic, message) = messages.message(packet, receipt)?;
        let log_time = messages.time_ns;
        let publish_time = receipt.map_or(log_time, |receipt| receipt.utc_ns);
        let header = MessageHeader {
            channel_id: channels[topic as usize],
            sequence: packet.sequence.into(),
            log_time,
            publish_time,
        };
        Ok(file.write_to_known_channel(&header, message.as_bytes())?)
    })?;
    file.finish()?;
    Ok(counts)
}

/// Adds a channel for each topic, in order, with metadata from the board's first greeting.
fn channels<W: Write + Seek>(file: &mut Writer<W>, hello: Option<&Hello>) -> Result<Vec<u16>> {
    let names = Names::unnamed();
    let mut metadata: BTreeMap<String, String> = names.metadata(0);
    if let Some(hello) = hello {
        let version = hello.version.map(|part| part.to_string()).join(".");
        metadata.insert("version".into(), version);
        metadata.insert("protocol".into(), hello.protocol.to_string());
        metadata.insert("settings".into(), settings_form::json(&hello.settings)?);
    }
    let channel = |topic: &Topic| {
        let schema = schema::json(*topic).to_string();
        let name = format!("ridgetone.{topic}");
        let path = format!("/{}", names.path(0, topic));
        let schema = file.add_schema(&name, "jsonschema", schema.as_bytes())?;
        Ok(file.add_channel(schema, &path, "json", &metadata)?)
    };
    Topic::ALL.iter().map(channel).collect()
}

#[derive(Default)]
struct Messages {
    json: JsonLines,
    streamed: Streamed,
    /// The board's clock after each of its starts, as learned in the first pass.
    clocks: Vec<UtcClock>,
    /// Starts found while learning the clocks.
    learned: Starts,
    /// Starts found while writing, and the number of the latest.
    starts: Starts,
    start: usize,
    /// Time of the latest packet that has one: UTC, or device time if nothing was learned.
    time_ns: u64,
}

impl Messages {
    fn learn(&mut self, packet: &Packet, receipt: Option<Receipt>) {
        let Some(receipt) = receipt else { return };
        if self.learned.take(&packet.event) || self.clocks.is_empty() {
            self.clocks.push(UtcClock::default());
        }
        if let Some(clock) = self.clocks.last_mut() {
            clock.take(packet, receipt);
        }
    }

    /// Returns the topic of a packet and its text.
    fn message(&mut self, packet: &Packet, receipt: Option<Receipt>) -> Result<(Topic, String)> {
        let mut message = self.json.message(packet, receipt);
        self.start += usize::from(self.starts.take(&packet.event));
        let clock = self.clocks.get(self.start);
        if let Some(t_s) = time_s(&packet.event) {
            self.time_ns = (t_s * 1e6).round() as u64 * 1000;
            if let Some(utc) = clock.and_then(|clock| clock.utc(t_s)) {
                self.time_ns = utc.utc_ns;
                if let Some(received) = &mut message.receipt {
                    received.utc_s = Some(utc.utc_s());
                    received.utc_sigma_s = utc.sigma_s;
                }
            }
        } else if let Some(receipt) = receipt {
            self.time_ns = receipt.utc_ns;
        }
        let (topic, text, _) = self.streamed.message(serde_json::to_string(&message)?)?;
        Ok((topic, text))
    }
}
