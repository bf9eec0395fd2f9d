//! A message on its way from a finger to the sinks: an object of `--json` with its topic, and its number there.

use super::queue::{Lost, Queue};
use super::topic::Topic;
use crate::static_image::{PLACES, UNIT_PITCH_MM};
use crate::utc::Receipt;
use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;

/// Characters of a line that is no message in the error about it.
const SHOWN: usize = 60;

#[derive(Clone, Debug)]
pub struct Message {
    /// Whose, by its place in [`Names`](super::topic::Names).
    pub finger: usize,
    pub topic: Topic,
    /// One object on one line.
    pub json: String,
    /// When it happened, nanoseconds since 1970.
    pub time_ns: u64,
}

/// Fields that decide where a message goes.
#[derive(Deserialize)]
struct Head<'a> {
    r#type: &'a str,
    utc_s: Option<f64>,
    received_utc_s: Option<f64>,
}

/// Gives a finger's messages to all sinks.
pub struct Publisher {
    finger: usize,
    queues: Vec<Arc<Queue>>,
    /// Messages on each topic so far.
    counts: [u64; Topic::ALL.len()],
}

impl Publisher {
    pub fn new(finger: usize, queues: Vec<Arc<Queue>>) -> Self {
        Self { finger, queues, counts: [0; Topic::ALL.len()] }
    }

    /// An object of `--json`. It gets `index`, its number on its topic, from 0; a greeting `positions_mm`.
    pub fn publish(&mut self, mut json: String) -> Result<()> {
        let head: Head<'_> =
            serde_json::from_str(&json).with_context(|| json.chars().take(SHOWN).collect::<String>())?;
        let (topic, is_hello) = (Topic::of(head.r#type), head.r#type == "hello");
        let time_s = head.utc_s.or(head.received_utc_s);
        let time_ns = time_s.map_or_else(|| Receipt::now(0.0).utc_ns, |time_s| (time_s * 1e9) as u64);
        let count = &mut self.counts[topic as usize];
        // The object's own brace.
        json.truncate(json.trim_end().len() - 1);
        if is_hello {
            json += &format!(r#","positions_mm":{}"#, json!(positions_mm()));
        }
        json += &format!(r#","index":{count}}}"#);
        *count += 1;
        let message = Arc::new(Message { finger: self.finger, topic, json, time_ns });
        self.queues.iter().for_each(|queue| queue.push(Arc::clone(&message)));
        Ok(())
    }

    /// An object of this command's own.
    pub fn note(&mut self, mut object: Value) -> Result<()> {
        object["received_utc_s"] = Receipt::now(0.0).utc_s().into();
        self.publish(object.to_string())
    }
}

/// What a sink has lost of a finger. It is for that sink alone, and so has no number on its topic.
pub fn lost(finger: usize, sink: &str, lost: Lost) -> Message {
    let Lost { frames, events, unconfirmed } = lost;
    let now = Receipt::now(0.0);
    let json = json!({"type": "lost", "at": sink, "frames": frames, "events": events,
        "frames_unconfirmed": unconfirmed, "received_utc_s": now.utc_s()});
    Message { finger, topic: Topic::Diagnostics, json: json.to_string(), time_ns: now.utc_ns }
}

/// The centre of each taxel's unit: along the sliding direction and across, millimetres from the array's centre. The four
/// taxels of a unit lie around it, on a cross whose size the paper does not give.
pub fn positions_mm() -> Vec<[f64; 2]> {
    let places = || {
        PLACES
            .iter()
            .enumerate()
            .flat_map(|(row, taxels)| taxels.iter().enumerate().map(move |(column, taxel)| (*taxel, row, column)))
    };
    let mut all = vec![[0.0; 2]; places().count()];
    for (taxel, row, column) in places() {
        let off = |place: usize| UNIT_PITCH_MM * ((place / 2) as f64 - 0.5);
        all[taxel] = [off(column), -off(row)];
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn published(lines: &[&str]) -> Vec<(Topic, Value)> {
        let queue = Arc::new(Queue::new("test", 1));
        let mut publisher = Publisher::new(0, vec![Arc::clone(&queue)]);
        lines.iter().for_each(|line| publisher.publish((*line).to_owned()).unwrap());
        queue.close();
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let next = || runtime.block_on(queue.next());
        std::iter::from_fn(next)
            .map(|taken| (taken.message.topic, serde_json::from_str(&taken.message.json).unwrap()))
            .collect()
    }

    #[test]
    fn messages_are_numbered_by_topic() {
        let all = published(&[
            r#"{"type":"raw","volts":[1,null]}"#,
            r#"{"type":"hello","settings":{"array":{"front":1}}}"#,
            r#"{"type":"raw"}"#,
            r#"{"type":"fault","t_s":1}"#,
        ]);
        let found: Vec<(Topic, u64)> =
            all.iter().map(|(topic, json)| (*topic, json["index"].as_u64().unwrap())).collect();
        use Topic::{Diagnostics, Frames};
        assert_eq!(found, [(Frames, 0), (Diagnostics, 0), (Frames, 1), (Diagnostics, 1)]);
        assert_eq!(all[1].1["settings"]["array"]["front"], 1);
        assert_eq!(all[1].1["positions_mm"].as_array().unwrap().len(), 16);
    }

    /// The front column of the default settings is that of the map.
    #[test]
    fn the_front_units_are_a_pitch_further_along_x() {
        let front = ridgetone_proto::settings::Array::DEFAULT.front;
        for (taxel, [x_mm, y_mm]) in positions_mm().into_iter().enumerate() {
            assert_eq!(x_mm, if front >> taxel & 1 != 0 { 1.15 } else { -1.15 });
            assert_eq!(y_mm, if taxel < 8 { 1.15 } else { -1.15 });
        }
    }
}
