//! Files of this writer in front of the format's own library, and the other way round.

use super::*;
use ::mcap::read::Summary;
use ::mcap::{MessageStream, WriteOptions};

const TOPICS: [&str; 2] = ["/ridgetone/a", "/ridgetone/b"];

/// A file of several chunks: every third message is of the second channel.
fn written(messages: u32) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer = Writer::new(&mut file, "a test").unwrap();
    let metadata = BTreeMap::from([("board".to_owned(), "left".to_owned())]);
    let channels = TOPICS.map(|topic| {
        let schema = &br#"{"type":"object"}"#[..];
        writer
            .add_channel(topic, "a schema", schema, &metadata)
            .unwrap()
    });
    for sequence in 0..messages {
        let data = format!("{{\"text\":\"{}\"}}", "x".repeat(1000));
        let message = Message {
            channel: channels[usize::from(sequence % 3 == 0)],
            sequence,
            log_time: 1000 + u64::from(sequence),
            publish_time: 7,
            data: data.as_bytes(),
        };
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    file
}

#[test]
fn the_formats_own_library_reads_what_is_written() {
    let file = written(3000);
    let messages: Vec<_> = MessageStream::new(&file)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(messages.len(), 3000);
    for (message, number) in messages.iter().zip(0u32..) {
        assert_eq!(
            (message.sequence, message.log_time),
            (number, 1000 + u64::from(number))
        );
        assert_eq!(message.channel.topic, TOPICS[usize::from(number % 3 == 0)]);
        assert_eq!(message.channel.metadata["board"], "left");
        assert_eq!(
            message.channel.schema.as_ref().unwrap().encoding,
            "jsonschema"
        );
    }
    let summary = Summary::read(&file).unwrap().expect("a summary");
    let statistics = summary.stats.as_ref().expect("statistics");
    assert_eq!(
        (statistics.message_count, statistics.channel_count),
        (3000, 2)
    );
    assert_eq!(
        (statistics.message_start_time, statistics.message_end_time),
        (1000, 3999)
    );
    assert_eq!(summary.chunk_indexes.len(), 3);
    let mut found = 0;
    for chunk in &summary.chunk_indexes {
        found += summary.stream_chunk(&file, chunk).unwrap().count();
        let places = summary.read_message_indexes(&file, chunk).unwrap();
        for (channel, places) in places {
            for place in places {
                let message = summary.seek_message(&file, chunk, &place).unwrap();
                assert_eq!(message.channel.topic, channel.topic);
                assert_eq!(message.log_time, place.log_time);
            }
        }
    }
    assert_eq!(found, 3000);
}

#[test]
fn what_another_writer_made_is_read() {
    for is_chunked in [false, true] {
        let mut file = std::io::Cursor::new(Vec::new());
        let options = WriteOptions::new().compression(None).use_chunks(is_chunked);
        let mut writer = options.create(&mut file).unwrap();
        let schema = writer.add_schema("a schema", "jsonschema", b"{}").unwrap();
        for (topic, encoding) in [(TOPICS[0], "json"), ("/camera", "cdr")] {
            let channel = writer
                .add_channel(schema, topic, encoding, &BTreeMap::new())
                .unwrap();
            let header = ::mcap::records::MessageHeader {
                channel_id: channel,
                sequence: 1,
                log_time: 2,
                publish_time: 3,
            };
            writer.write_to_known_channel(&header, b"{}").unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let messages = json_messages(file.get_ref()).unwrap();
        assert_eq!(
            messages,
            [(TOPICS[0].to_owned(), &b"{}"[..])],
            "chunks: {is_chunked}"
        );
    }
}

#[test]
fn files_that_are_damaged_cut_off_or_something_else_are_refused() {
    let file = written(10);
    assert_eq!(json_messages(&file).unwrap().len(), 10);
    assert_eq!(json_messages(b"time_s,ain0\n"), Err(McapError::Other));
    for length in MAGIC.len()..file.len() {
        let read = json_messages(&file[..length]);
        let is_damaged = matches!(read, Err(McapError::Damaged { at }) if at <= length);
        // What comes after the data is not needed.
        assert!(
            is_damaged || read.is_ok_and(|messages| messages.len() == 10),
            "{length}"
        );
    }
    let mut flipped = file.clone();
    let at = file.windows(4).position(|four| four == b"xxxx").unwrap();
    flipped[at] ^= 1;
    assert!(matches!(
        json_messages(&flipped),
        Err(McapError::Damaged { .. })
    ));
    // Any other damage gives an error or messages, and no panic.
    for at in 0..file.len().min(2000) {
        for bit in [0, 7] {
            let mut flipped = file.clone();
            flipped[at] ^= 1 << bit;
            let _ = json_messages(&flipped);
        }
    }
}
