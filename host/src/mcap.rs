//! JSON messages of MCAP files (<https://mcap.dev/spec>).

use mcap::parse_record;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use thiserror::Error;

/// Reasons why a file cannot be read.
#[derive(Debug, Error)]
pub enum McapError {
    #[error("the MCAP file is cut off or damaged")]
    Damaged(#[from] mcap::McapError),
    #[error("its chunks are compressed with {compression:?}, and only uncompressed ones are read")]
    Compressed { compression: String },
}

/// Returns the JSON messages of an MCAP file with their topics, in the file's order.
pub fn json_messages(file: &[u8]) -> Result<Vec<(String, Vec<u8>)>, McapError> {
    let mut reader = Reader::default();
    if reader.read(file, false)? {
        Ok(reader.messages)
    } else {
        Err(mcap::McapError::UnexpectedEof.into())
    }
}

#[derive(Default)]
struct Reader {
    /// Topics of the channels of JSON.
    topics: HashMap<u16, String>,
    messages: Vec<(String, Vec<u8>)>,
}

impl Reader {
    /// Reads the records of a file or of a chunk. Returns true if the end of the data was among
    /// them: the summary after it is not needed.
    ///
    /// The library's own reader of chunks would panic at a record that is longer than its chunk.
    fn read(&mut self, bytes: &[u8], is_chunk: bool) -> Result<bool, McapError> {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_skip_start_magic(is_chunk)
            .with_skip_end_magic(true)
            .with_record_length_limit(bytes.len());
        let (mut reader, mut rest) = (LinearReader::new_with_options(options), bytes);
        while let Some(event) = reader.next_event() {
            let (opcode, data) = match event? {
                LinearReadEvent::ReadRequest(length) => {
                    let (now, later) = rest.split_at(length.min(rest.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    rest = later;
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            match opcode {
                op::DATA_END => return Ok(true),
                op::CHANNEL | op::MESSAGE | op::CHUNK => {}
                _ => continue,
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
                    // 0 stands for no checksum.
                    if saved != 0 && saved != calculated {
                        return Err(mcap::McapError::BadChunkCrc { saved, calculated }.into());
                    }
                    self.read(&data, true)?;
                }
                _ => {}
            }
        }
        Ok(false)
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

    /// A file with messages of two channels, JSON and CDR.
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
            assert_eq!(
                json_messages(&file).unwrap(),
                [(); 3].map(|()| expected.clone())
            );
        }
    }

    #[test]
    fn files_that_are_damaged_cut_off_or_something_else_are_refused() {
        let file = written(10, WriteOptions::new());
        assert!(json_messages(b"time_s,ain0\n").is_err());
        for length in 0..file.len() {
            // The summary after the data is not needed.
            let read = json_messages(&file[..length]);
            assert!(
                matches!(read, Err(McapError::Damaged(_)))
                    || read.is_ok_and(|messages| messages.len() == 10),
                "{length}"
            );
        }
        let mut flipped = file.clone();
        let at = file.windows(4).position(|four| four == b"xxxx").unwrap();
        flipped[at] ^= 1;
        assert!(json_messages(&flipped).is_err());
        // Any other damage gives an error or messages, and no panic, even where no checksum finds it.
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
