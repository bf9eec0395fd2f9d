//! MCAP files (<https://mcap.dev/spec>) of what `export` needs: JSON messages in chunks without
//! compression, an index of the chunks, and checksums.

use crc::{CRC_32_ISO_HDLC, Crc};
use std::collections::BTreeMap;
use std::io::{self, Write};
use thiserror::Error;

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A chunk ends with the message by which it exceeds this, bytes.
const CHUNK_BYTES: usize = 1 << 20;

/// What the records of a file are called, by their codes.
mod code {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const STATISTICS: u8 = 0x0B;
    pub const SUMMARY_OFFSET: u8 = 0x0E;
    pub const DATA_END: u8 = 0x0F;
}

/// Content of a record.
#[derive(Default)]
struct Content(Vec<u8>);

impl Content {
    fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }

    fn u16(self, value: u16) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u32(self, value: u32) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u64(self, value: u64) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    /// Text, a list or a map: its length in bytes comes first.
    fn sized(self, bytes: &[u8]) -> Self {
        self.u32(bytes.len() as u32).bytes(bytes)
    }

    fn append_to(&self, out: &mut Vec<u8>, code: u8) {
        out.push(code);
        out.extend((self.0.len() as u64).to_le_bytes());
        out.extend_from_slice(&self.0);
    }
}

/// A message of a channel.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    pub channel: u16,
    pub sequence: u32,
    /// Nanoseconds, as is the next.
    pub log_time: u64,
    pub publish_time: u64,
    pub data: &'a [u8],
}

/// Times of the earliest and the latest message.
#[derive(Clone, Copy, Debug, Default)]
struct Times(Option<(u64, u64)>);

impl Times {
    fn see(&mut self, time: u64) {
        let (first, last) = self.0.unwrap_or((time, time));
        self.0 = Some((first.min(time), last.max(time)));
    }
}

/// Writes a file from its beginning to its end.
pub struct Writer<W> {
    out: W,
    written: u64,
    schemas: Vec<u8>,
    channels: Vec<u8>,
    chunk_indexes: Vec<u8>,
    chunks: u32,
    /// Messages of the whole file, by channel.
    counts: Vec<u64>,
    times: Times,
    /// Records of the chunk that is not written yet.
    chunk: Vec<u8>,
    chunk_times: Times,
    /// For each channel, times and offsets of its messages in that chunk.
    places: Vec<Vec<u8>>,
}

impl<W: Write> Writer<W> {
    pub fn new(out: W, library: &str) -> io::Result<Self> {
        let mut writer = Self {
            out,
            written: 0,
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            chunks: 0,
            counts: Vec::new(),
            times: Times::default(),
            chunk: Vec::new(),
            chunk_times: Times::default(),
            places: Vec::new(),
        };
        let mut start = MAGIC.to_vec();
        let header = Content::default().sized(b"").sized(library.as_bytes());
        header.append_to(&mut start, code::HEADER);
        writer.put(&start)?;
        Ok(writer)
    }

    /// Adds a channel of JSON with the name and the text of its schema, and metadata; the result is
    /// its number for messages.
    pub fn add_channel(
        &mut self,
        topic: &str,
        schema: &str,
        json: &[u8],
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<u16> {
        let channel = self.counts.len() as u16;
        let mut pairs = Content::default();
        for (key, value) in metadata {
            pairs = pairs.sized(key.as_bytes()).sized(value.as_bytes());
        }
        // Number 0 means that there is no schema.
        let mut records = Vec::new();
        Content::default()
            .u16(channel + 1)
            .sized(schema.as_bytes())
            .sized(b"jsonschema")
            .sized(json)
            .append_to(&mut records, code::SCHEMA);
        self.schemas.extend_from_slice(&records);
        let schema_bytes = records.len();
        Content::default()
            .u16(channel)
            .u16(channel + 1)
            .sized(topic.as_bytes())
            .sized(b"json")
            .sized(&pairs.0)
            .append_to(&mut records, code::CHANNEL);
        self.channels.extend_from_slice(&records[schema_bytes..]);
        self.counts.push(0);
        self.places.push(Vec::new());
        self.put(&records)?;
        Ok(channel)
    }

    /// Writes a message of a channel that was added.
    pub fn write(&mut self, message: &Message) -> io::Result<()> {
        let at = usize::from(message.channel);
        let (Some(count), Some(places)) = (self.counts.get_mut(at), self.places.get_mut(at)) else {
            return Err(io::Error::other("a message of a channel that is not there"));
        };
        *count += 1;
        places.extend(message.log_time.to_le_bytes());
        places.extend((self.chunk.len() as u64).to_le_bytes());
        self.chunk_times.see(message.log_time);
        self.times.see(message.log_time);
        Content::default()
            .u16(message.channel)
            .u32(message.sequence)
            .u64(message.log_time)
            .u64(message.publish_time)
            .bytes(message.data)
            .append_to(&mut self.chunk, code::MESSAGE);
        if self.chunk.len() > CHUNK_BYTES {
            self.end_chunk()?;
        }
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.written += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    /// Writes the chunk and the indexes of its messages.
    fn end_chunk(&mut self) -> io::Result<()> {
        let Some((first, last)) = std::mem::take(&mut self.chunk_times).0 else {
            return Ok(());
        };
        let (chunk, start) = (std::mem::take(&mut self.chunk), self.written);
        let length = chunk.len() as u64;
        let mut records = Vec::new();
        Content::default()
            .u64(first)
            .u64(last)
            .u64(length)
            .u32(CRC.checksum(&chunk))
            .sized(b"")
            .u64(length)
            .bytes(&chunk)
            .append_to(&mut records, code::CHUNK);
        let chunk_length = records.len() as u64;
        let mut index_offsets = Content::default();
        for (channel, places) in self.places.iter_mut().enumerate() {
            if places.is_empty() {
                continue;
            }
            index_offsets = index_offsets
                .u16(channel as u16)
                .u64(start + records.len() as u64);
            Content::default()
                .u16(channel as u16)
                .sized(&std::mem::take(places))
                .append_to(&mut records, code::MESSAGE_INDEX);
        }
        Content::default()
            .u64(first)
            .u64(last)
            .u64(start)
            .u64(chunk_length)
            .sized(&index_offsets.0)
            .u64(records.len() as u64 - chunk_length)
            .sized(b"")
            .u64(length)
            .u64(length)
            .append_to(&mut self.chunk_indexes, code::CHUNK_INDEX);
        self.chunks += 1;
        self.put(&records)
    }

    /// Writes what is left, and the summary by which readers find messages.
    pub fn finish(mut self) -> io::Result<()> {
        self.end_chunk()?;
        let mut end = Vec::new();
        // The data have the checksums of their chunks; 0 says that the whole has none.
        Content::default()
            .u32(0)
            .append_to(&mut end, code::DATA_END);
        self.put(&end)?;
        let (first, last) = self.times.0.unwrap_or_default();
        let mut channel_counts = Content::default();
        for (channel, count) in self.counts.iter().enumerate() {
            channel_counts = channel_counts.u16(channel as u16).u64(*count);
        }
        let mut statistics = Vec::new();
        Content::default()
            .u64(self.counts.iter().sum())
            .u16(self.counts.len() as u16)
            .u32(self.counts.len() as u32)
            .u32(0)
            .u32(0)
            .u32(self.chunks)
            .u64(first)
            .u64(last)
            .sized(&channel_counts.0)
            .append_to(&mut statistics, code::STATISTICS);
        let (mut summary, mut offsets, start) = (Vec::new(), Vec::new(), self.written);
        for (group_code, group) in [
            (code::SCHEMA, &self.schemas),
            (code::CHANNEL, &self.channels),
            (code::STATISTICS, &statistics),
            (code::CHUNK_INDEX, &self.chunk_indexes),
        ] {
            if !group.is_empty() {
                Content::default()
                    .bytes(&[group_code])
                    .u64(start + summary.len() as u64)
                    .u64(group.len() as u64)
                    .append_to(&mut offsets, code::SUMMARY_OFFSET);
                summary.extend_from_slice(group);
            }
        }
        let offsets_start = start + summary.len() as u64;
        summary.extend_from_slice(&offsets);
        let footer = Content::default().u64(start).u64(offsets_start).u32(0);
        footer.append_to(&mut summary, code::FOOTER);
        // The checksum is of all before it, the beginning of the footer included.
        let checksum_at = summary.len() - size_of::<u32>();
        let checksum = CRC.checksum(&summary[..checksum_at]);
        summary[checksum_at..].copy_from_slice(&checksum.to_le_bytes());
        summary.extend_from_slice(&MAGIC);
        self.put(&summary)?;
        self.out.flush()
    }
}

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum McapError {
    #[error("no MCAP file: it does not begin as one")]
    Other,
    #[error("the MCAP file is cut off or damaged at byte {at}")]
    Damaged { at: usize },
    #[error("its chunks are compressed with {compression:?}, and only uncompressed ones are read")]
    Compressed { compression: String },
}

/// JSON messages of an MCAP file with their topics, in the file's order.
pub fn json_messages(file: &[u8]) -> Result<Vec<(String, &[u8])>, McapError> {
    let records = file.strip_prefix(&MAGIC).ok_or(McapError::Other)?;
    let mut reader = Reader {
        channels: Vec::new(),
        messages: Vec::new(),
    };
    if !reader.read(records, file.len())? {
        return Err(McapError::Damaged { at: file.len() });
    }
    Ok(reader.messages)
}

struct Reader<'a> {
    /// Numbers and topics of channels of JSON.
    channels: Vec<(u16, String)>,
    messages: Vec<(String, &'a [u8])>,
}

impl<'a> Reader<'a> {
    /// Reads the records of the file or of a chunk, which ends at a byte of the file. Whether the
    /// end of the data was among them.
    fn read(&mut self, records: &'a [u8], end: usize) -> Result<bool, McapError> {
        let mut rest = Fields {
            bytes: records,
            end,
        };
        while !rest.bytes.is_empty() {
            let code = rest.take(1)?[0];
            let length = rest.u64()?;
            let content = rest.take(length)?;
            let end = rest.end - rest.bytes.len();
            let mut fields = Fields {
                bytes: content,
                end,
            };
            match code {
                code::CHANNEL => {
                    let (number, _) = (fields.u16()?, fields.u16()?);
                    let (topic, encoding) = (fields.text()?, fields.text()?);
                    if encoding == "json" && !self.channels.iter().any(|known| known.0 == number) {
                        self.channels.push((number, topic));
                    }
                }
                code::MESSAGE => {
                    let number = fields.u16()?;
                    fields.take(4 + 8 + 8)?;
                    if let Some((_, topic)) = self.channels.iter().find(|known| known.0 == number) {
                        self.messages.push((topic.clone(), fields.bytes));
                    }
                }
                code::CHUNK => {
                    fields.take(8 + 8 + 8)?;
                    let (checksum, compression) = (fields.u32()?, fields.text()?);
                    if !compression.is_empty() {
                        return Err(McapError::Compressed { compression });
                    }
                    let length = fields.u64()?;
                    let records = fields.take(length)?;
                    // 0 says that there is no checksum.
                    if checksum != 0 && checksum != CRC.checksum(records) {
                        return Err(fields.damaged());
                    }
                    self.read(records, end)?;
                }
                code::DATA_END => return Ok(true),
                _ => {}
            }
        }
        Ok(false)
    }
}

/// Fields of a record that are not read yet.
struct Fields<'a> {
    bytes: &'a [u8],
    /// Their end as a byte of the file.
    end: usize,
}

impl<'a> Fields<'a> {
    fn damaged(&self) -> McapError {
        McapError::Damaged {
            at: self.end - self.bytes.len(),
        }
    }

    fn take(&mut self, length: u64) -> Result<&'a [u8], McapError> {
        let split = usize::try_from(length)
            .ok()
            .and_then(|length| self.bytes.split_at_checked(length));
        let (taken, rest) = split.ok_or_else(|| self.damaged())?;
        self.bytes = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], McapError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N as u64)?);
        Ok(array)
    }

    fn u16(&mut self) -> Result<u16, McapError> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Result<u32, McapError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64, McapError> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    fn text(&mut self) -> Result<String, McapError> {
        let length = self.u32()?;
        let text = std::str::from_utf8(self.take(length.into())?);
        text.map(str::to_owned).map_err(|_| self.damaged())
    }
}

#[cfg(test)]
mod tests;
