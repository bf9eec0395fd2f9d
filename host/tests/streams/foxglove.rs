//! A client of Foxglove's WebSocket protocol, written from its specification
//! (docs.foxglove.dev/docs/sdk/websocket-server) to check the crate's output independently.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Operation codes of WebSocket frames (RFC 6455, 5.2).
const TEXT: u8 = 1;
const BINARY: u8 = 2;

/// First byte of a message on a channel.
const MESSAGE_DATA: u8 = 1;

pub struct Viewer {
    stream: BufReader<TcpStream>,
    /// Advertised channels, by topic.
    pub channels: BTreeMap<String, Value>,
    /// Topics by the number of the subscription.
    subscribed: Vec<String>,
}

impl Viewer {
    pub fn connect(port: u16) -> Self {
        let begun = Instant::now();
        let stream = loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(stream) => break stream,
                Err(error) => assert!(begun.elapsed() < Duration::from_secs(20), "{error}"),
            }
            sleep(Duration::from_millis(20));
        };
        stream
            .set_read_timeout(Some(Duration::from_secs(20)))
            .expect("a limit");
        let mut stream = BufReader::new(stream);
        let request = format!(
            "GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        stream
            .get_mut()
            .write_all(request.as_bytes())
            .expect("sent");
        let mut answer = String::new();
        while !answer.ends_with("\r\n\r\n") {
            stream.read_line(&mut answer).expect("an answer");
        }
        // Answer to the example key in RFC 6455, 1.3.
        assert!(
            answer.starts_with("HTTP/1.1 101") && answer.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="),
            "{answer}"
        );
        Self {
            stream,
            channels: BTreeMap::new(),
            subscribed: Vec::new(),
        }
    }

    /// Waits until `count` channels are advertised, and subscribes to all.
    pub fn subscribe_to(&mut self, count: usize) {
        while self.channels.len() < count {
            let (code, content) = self.frame().expect("a frame");
            assert_eq!(code, TEXT);
            let message: Value = serde_json::from_slice(&content).expect("JSON");
            for channel in message["channels"].as_array().into_iter().flatten() {
                self.channels.insert(
                    channel["topic"].as_str().expect("a topic").to_owned(),
                    channel.clone(),
                );
            }
        }
        self.subscribed = self.channels.keys().cloned().collect();
        let wanted = self.subscribed.iter().enumerate();
        let wanted: Vec<Value> = wanted
            .map(|(number, topic)| json!({"id": number, "channelId": self.channels[topic]["id"]}))
            .collect();
        self.send(&json!({"op": "subscribe", "subscriptions": wanted}).to_string());
    }

    /// Returns topic, time in nanoseconds since 1970, and object of the next message, or `None` at
    /// the end.
    pub fn next(&mut self) -> Option<(String, u64, Value)> {
        loop {
            let (code, content) = self.frame()?;
            if code == BINARY && content[0] == MESSAGE_DATA {
                let number = u32::from_le_bytes(content[1..5].try_into().expect("four bytes"));
                let log_ns = u64::from_le_bytes(content[5..13].try_into().expect("eight bytes"));
                let message = serde_json::from_slice(&content[13..]).expect("JSON");
                return Some((self.subscribed[number as usize].clone(), log_ns, message));
            }
        }
    }

    /// Reads an unmasked, whole frame from the server. Returns `None` at the end.
    fn frame(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut head = [0; 2];
        self.stream.read_exact(&mut head).ok()?;
        assert!(head[0] & 0x80 != 0 && head[1] & 0x80 == 0, "{head:?}");
        let mut length = [0; 8];
        let extended = match head[1] {
            126 => 2,
            127 => 8,
            short => {
                length[7] = short;
                0
            }
        };
        self.stream
            .read_exact(&mut length[8 - extended..])
            .expect("a length");
        let mut content = vec![0; u64::from_be_bytes(length) as usize];
        self.stream.read_exact(&mut content).expect("a content");
        Some((head[0] & 0x0f, content))
    }

    /// Sends a client's frame, with a mask of zeros, which changes nothing.
    fn send(&mut self, text: &str) {
        let length = u16::try_from(text.len()).expect("short").to_be_bytes();
        let head = [0x80 | TEXT, 0x80 | 126, length[0], length[1], 0, 0, 0, 0];
        self.stream
            .get_mut()
            .write_all(&[&head[..], text.as_bytes()].concat())
            .expect("sent");
    }
}
