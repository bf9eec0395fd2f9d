//! A line that damages bytes on the way to the decoder. The bytes between two zeros are either
//! exactly a frame that was sent, or damaged.

#[allow(dead_code, reason = "a part of it is used here")]
#[path = "touch.rs"]
mod touch;

use ridgetone_finger::Pipeline;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, Packet, WIRE_MAX, encode};
use std::collections::HashMap;
use std::sync::OnceLock;

/// Counts of spans (the bytes between two zeros).
#[derive(Clone, Copy, Debug, Default)]
pub struct Tried {
    /// Frames that arrived whole.
    pub whole: u32,
    /// Spans that are not exactly a frame that was sent.
    pub damaged: u32,
    /// Damaged spans that the decoder accepts as packets, although no such frame was sent. A fuzzer
    /// may construct them; random damage does so once in four thousand million.
    pub forged: u32,
}

/// Telemetry of one touch, from the greeting to the release.
fn telemetry() -> &'static [Event] {
    static EVENTS: OnceLock<Vec<Event>> = OnceLock::new();
    EVENTS.get_or_init(|| {
        let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
        let mut events = vec![pipeline.hello()];
        for conversion in (0..touch::SCANS).flat_map(|scan| touch::scan(scan, scan, 0)) {
            pipeline.push(conversion, &mut |event| events.push(event));
        }
        pipeline.finish(&mut |event| events.push(event));
        events
    })
}

/// The frames sent, and the bytes on the line.
#[derive(Default)]
struct Sent {
    frames: HashMap<Vec<u8>, Packet>,
    line: Vec<u8>,
    number: u16,
    /// Index of the event sent last.
    at: Option<usize>,
    /// True if a frame arrived twice or out of order. The numbers then suggest a loss or a restart.
    shuffled: bool,
}

impl Sent {
    /// Returns the next frame, including its delimiter.
    fn frame(&mut self, which: u8) -> Vec<u8> {
        let (events, which) = (telemetry(), usize::from(which));
        // Starts at any event, but then never goes back in time, which would mean a restart.
        let at = self
            .at
            .map_or(which % events.len(), |at| at + which % 4)
            .min(events.len() - 1);
        self.at = Some(at);
        self.number += 1;
        let packet = Packet {
            sequence: self.number,
            event: events[at].clone(),
        };
        let mut wire = [0; WIRE_MAX];
        let used = encode(&packet, &mut wire).expect("every event fits the wire");
        self.frames.insert(wire[..used - 1].to_vec(), packet);
        wire[..used].to_vec()
    }

    /// Performs the step that the next bytes encode. Returns false at the end.
    fn step(&mut self, bytes: &mut impl Iterator<Item = u8>) -> bool {
        let (Some(what), Some(which)) = (bytes.next(), bytes.next()) else {
            return false;
        };
        let mut frame = self.frame(which);
        let mut at = || {
            bytes
                .next()
                .map_or(0, |byte| usize::from(byte) << 1 | usize::from(which & 1))
        };
        match what % 11 {
            // Truncated at the end or at the start.
            0 => frame.truncate(at() % frame.len()),
            1 => drop(frame.drain(..at() % frame.len())),
            // Bytes missing in the middle.
            2 => {
                let (from, length) = (at() % frame.len(), 1 + at() % 40);
                drop(frame.drain(from..frame.len().min(from + length)));
            }
            // Merged with the next frame, because the delimiter is lost or changed.
            3 => drop(frame.pop()),
            4 => frame
                .last_mut()
                .into_iter()
                .for_each(|last| *last = which | 1),
            // Flipped bits.
            5 | 6 => {
                for _ in 0..=what / 64 {
                    let position = at() % frame.len();
                    frame[position] ^= 1 << (at() % 8);
                }
            }
            // Sent twice.
            7 => {
                self.shuffled = true;
                frame = frame.repeat(2);
            }
            // Swapped with the next frame.
            8 => {
                self.shuffled = true;
                let next = self.frame(which.wrapping_add(1));
                frame = [next, frame].concat();
            }
            // Preceded by arbitrary bytes.
            9 => {
                let length = at() % (2 * WIRE_MAX);
                let filler = bytes.take(1 + length % 16).collect::<Vec<_>>();
                frame = [filler.into_iter().cycle().take(length).collect(), frame].concat();
            }
            _ => {}
        }
        self.line.extend(frame);
        true
    }
}

/// Sends and damages frames as `bytes` encode. Panics if the decoder returns, counts or loses
/// anything wrongly.
pub fn try_line(bytes: &[u8]) -> Tried {
    let mut sent = Sent::default();
    let mut bytes = bytes.iter().copied();
    while sent.step(&mut bytes) {}
    let mut decoder = Decoder::new();
    let (mut tried, mut numbers) = (Tried::default(), Vec::new());
    for span in sent.line.split_inclusive(|byte| *byte == 0) {
        let given: Vec<Packet> = span.iter().filter_map(|byte| decoder.push(*byte)).collect();
        // The last span may lack its delimiter.
        let Some((0, content)) = span.split_last() else {
            assert!(given.is_empty());
            tried.damaged += (span.len() / WIRE_MAX) as u32;
            continue;
        };
        match sent.frames.get(content) {
            Some(packet) => {
                assert_eq!(
                    given,
                    std::slice::from_ref(packet),
                    "a frame that arrived whole is read"
                );
                tried.whole += 1;
                numbers.push(packet.sequence);
            }
            None if given.is_empty() && content.is_empty() => {}
            // A long span counts once for each frame that it could have contained.
            None if given.is_empty() => tried.damaged += (content.len() / WIRE_MAX).max(1) as u32,
            None => {
                let mut wire = [0; WIRE_MAX];
                let used = encode(&given[0], &mut wire).expect("it fitted");
                assert!(
                    given.len() == 1 && wire[..used] == *span,
                    "{given:?} out of {span:?}"
                );
                tried.forged += 1;
            }
        }
    }
    assert_eq!(decoder.damaged, tried.damaged);
    if let (Some(first), Some(last), false, 0) =
        (numbers.first(), numbers.last(), sent.shuffled, tried.forged)
    {
        assert_eq!(
            decoder.missing,
            u32::from(last - first) + 1 - tried.whole,
            "{numbers:?}"
        );
    }
    assert!(
        decoder.missing <= u32::from(sent.number) * 2,
        "{} missing of {}",
        decoder.missing,
        sent.number
    );
    tried
}
