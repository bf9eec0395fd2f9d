//! Reads JSON messages from MCAP files (<https://mcap.dev/spec>).

use mcap::records::{Record, op};
use mcap::{MAGIC, parse_record};
use std::collections::HashMap;
use thiserror::Error;

#[derive(Debug, Error)]
pub enum McapError {
    #[error("the MCAP file is cut off or damaged")]
    Damaged(#[from] mcap::McapError),
    #[error("its chunks are compressed with {compression:?}, and only uncompressed ones are read")]
    Compressed { compression: String },
}

#[derive(Debug, Default, PartialEq)]
pub struct JsonMessages {
    /// Topics and texts, in the file's order.
    pub messages: Vec<(String, Vec<u8>)>,
    /// Offset in bytes of the first incomplete record, if the file was cut off; `messages` end
    /// there.
    pub cut_at: Option<usize>,
}

/// Returns the JSON messages of an MCAP file. Fails if the file is cut off before the first one.
pub fn json_messages(file: &[u8]) -> Result<JsonMessages, McapError> {
    let records = file.strip_prefix(MAGIC);
    let records = records.ok_or(mcap::McapError::BadMagic)?;
    let mut reader = Reader::default();
    let left = reader.read(records, false)?;
    let cut_at = (!reader.is_over).then_some(file.len() - left);
    if cut_at.is_some() && reader.messages.is_empty() {
        return Err(mcap::McapError::UnexpectedEof.into());
    }
    Ok(JsonMessages {
        messages: reader.messages,
        cut_at,
    })
}

/// Bytes of a record before its content: its kind and its length.
const RECORD_HEAD: usize = 9;

/// Bytes of an uncompressed chunk before its records: two times, a length, a checksum, an empty
/// name, a length.
const CHUNK_HEAD: usize = 40;

/// Bytes of a chunk that hold the length of the compression's name.
const COMPRESSION: core::ops::Range<usize> = 28..32;

#[derive(Default)]
struct Reader {
    /// Topics of the JSON channels, by channel id.
    topics: HashMap<u16, String>,
    messages: Vec<(String, Vec<u8>)>,
    /// True once the end of the data has been read. The summary after the data is not needed.
    is_over: bool,
}

impl Reader {
    /// Reads all complete records. Returns the number of bytes that are left over.
    ///
    /// The library's own reader of chunks would panic at a record that is longer than its chunk.
    fn read(&mut self, mut bytes: &[u8], is_chunk: bool) -> Result<usize, McapError> {
        while let Some((head, rest)) = bytes.split_first_chunk::<RECORD_HEAD>() {
            let [opcode, length @ ..] = *head;
            let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
            if is_chunk && [op::CHUNK, op::DATA_END].contains(&opcode) {
                return Err(mcap::McapError::UnexpectedEoc.into());
            }
            let Some((data, rest)) = rest.split_at_checked(length) else {
                // Reads the complete records of a chunk that is cut off.
                let is_plain = rest.get(COMPRESSION) == Some(&[0; 4]);
                if opcode == op::CHUNK && is_plain {
                    self.read(rest.get(CHUNK_HEAD..).unwrap_or_default(), true)?;
                }
                break;
            };
            self.take(opcode, data)?;
            if self.is_over {
                break;
            }
            bytes = rest;
        }
        Ok(bytes.len())
    }

    fn take(&mut self, opcode: u8, data: &[u8]) -> Result<(), McapError> {
        self.is_over |= opcode == op::DATA_END;
        if ![op::CHANNEL, op::MESSAGE, op::CHUNK].contains(&opcode) {
            return Ok(());
        }
        match parse_record(opcode, data)? {
            Record::Channel(channel) if channel.message_encoding == "json" => {
                self.topics.entry(channel.id).or_insert(channel.topic);
            }
            Record::Message { header, data } => {
                if let Some(topic) = self.topics.get(&header.channel_id) {
                    self.messages.push((topic.clone(), data.into_owned()));
                }
            }
            Record::Chunk { header, .. } if !header.compression.is_empty() => {
                let compression = header.compression;
                return Err(McapError::Compressed { compression });
            }
            Record::Chunk { header, data } => {
                let mut crc = flate2::Crc::new();
                crc.update(&data);
                let (saved, calculated) = (header.uncompressed_crc, crc.sum());
                // 0 means that there is no checksum.
                if saved != 0 && saved != calculated {
                    return Err(mcap::McapError::BadChunkCrc { saved, calculated }.into());
                }
                if self.read(&data, true)? > 0 {
                    return Err(mcap::McapError::UnexpectedEoc.into());
                }
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::WriteOptions;
    use mcap::records::MessageHeader;
    use std::collections::BTreeMap;
    use std::io::Cursor;

    const TOPICS: [&str; 2] = ["/ridgetone/a", "/camera"];

    /// Writes a file with messages of two channels, JSON and CDR.
    fn written(messages: u32, options: WriteOptions) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = options.compression(None).create(&mut file).unwrap();
        let schema = writer.add_schema("a schema", "jsonschema", b"{}").unwrap();
        for (topic, encoding) in TOPICS.into_iter().zip(["json", "cdr"]) {
            let channel_id = writer
                .add_channel(schema, topic, encoding, &BTreeMap::new())
                .unwrap();
            for sequence in 0..messages {
                let header = MessageHeader {
                    channel_id,
                    sequence,
                    log_time: 2,
                    publish_time: 3,
                };
                writer
                    .write_to_known_channel(&header, br#"{"text":"xxxx"}"#)
                    .unwrap();
            }
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    #[test]
    fn messages_of_json_are_read_with_and_without_chunks() {
        for is_chunked in [false, true] {
            let file = written(3, WriteOptions::new().use_chunks(is_chunked));
            let expected = (TOPICS[0].to_owned(), br#"{"text":"xxxx"}"#.to_vec());
            let found = json_messages(&file).unwrap();
            assert_eq!(found.messages, [(); 3].map(|()| expected.clone()));
            assert_eq!(found.cut_at, None);
        }
    }

    #[test]
    fn of_a_file_that_is_cut_off_the_messages_before_are_read() {
        for is_chunked in [false, true] {
            let file = written(10, WriteOptions::new().use_chunks(is_chunked));
            let ends: Vec<usize> = (0..file.len())
                .filter(|end| file[..*end].ends_with(br#"{"text":"xxxx"}"#))
                .collect();
            for length in 0..file.len() {
                // Only the first ten messages are JSON.
                let whole = ends.iter().filter(|end| **end <= length).count().min(10);
                match json_messages(&file[..length]) {
                    Ok(read) => {
                        assert_eq!(read.messages.len(), whole, "{length}");
                        // The summary after the data is not needed.
                        assert!(read.cut_at.is_none_or(|at| at <= length) && whole > 0);
                        assert!(read.cut_at.is_some() || whole == 10, "{length}");
                    }
                    Err(error) => {
                        assert!(
                            matches!(error, McapError::Damaged(_)) && whole == 0,
                            "{length}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn files_that_are_damaged_or_something_else_are_refused() {
        let file = written(10, WriteOptions::new());
        assert!(json_messages(b"time_s,ain0\n").is_err());
        let mut flipped = file.clone();
        let at = file.windows(4).position(|four| four == b"xxxx").unwrap();
        flipped[at] ^= 1;
        assert!(json_messages(&flipped).is_err());
        // Any other damage returns an error or messages, without a panic, even with no checksum.
        let unchecked = written(10, WriteOptions::new().calculate_chunk_crcs(false));
        for file in [file, unchecked] {
            for at in 0..file.len() {
                for bit in 0..8 {
                    let mut flipped = file.clone();
                    flipped[at] ^= 1 << bit;
                    let _ = json_messages(&flipped);
                }
            }
        }
    }
}
