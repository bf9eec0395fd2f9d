//! From a finger to all sinks: each message gets its number on its topic.

use super::message::{Message, positions_mm};
use super::queue::Queue;
use super::topic::Topic;
use crate::utc::Receipt;
use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;

/// Characters of a line that is no message in the error about it.
const SHOWN: usize = 60;

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
        Self {
            finger,
            queues,
            counts: [0; Topic::ALL.len()],
        }
    }

    /// An object of `--json`. It gets `index`, its number on its topic, from 0; a greeting
    /// `positions_mm`.
    pub fn publish(&mut self, mut json: String) -> Result<()> {
        let head: Head<'_> = serde_json::from_str(&json)
            .with_context(|| json.chars().take(SHOWN).collect::<String>())?;
        let (topic, is_hello) = (Topic::of(head.r#type), head.r#type == "hello");
        let time_s = head.utc_s.or(head.received_utc_s);
        let time_ns =
            time_s.map_or_else(|| Receipt::now(0.0).utc_ns, |time_s| (time_s * 1e9) as u64);
        let count = &mut self.counts[topic as usize];
        // The object's own brace.
        json.truncate(json.trim_end().len() - 1);
        if is_hello {
            json += &format!(r#","positions_mm":{}"#, json!(positions_mm()));
        }
        json += &format!(r#","index":{count}}}"#);
        *count += 1;
        let message = Arc::new(Message {
            finger: self.finger,
            topic,
            json,
            time_ns,
        });
        self.queues
            .iter()
            .for_each(|queue| queue.push(Arc::clone(&message)));
        Ok(())
    }

    /// An object of this command's own.
    pub fn note(&mut self, mut object: Value) -> Result<()> {
        object["received_utc_s"] = Receipt::now(0.0).utc_s().into();
        self.publish(object.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn published(lines: &[&str]) -> Vec<(Topic, Value)> {
        let queue = Arc::new(Queue::new("test", 1));
        let mut publisher = Publisher::new(0, vec![Arc::clone(&queue)]);
        lines
            .iter()
            .for_each(|line| publisher.publish((*line).to_owned()).unwrap());
        queue.close();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let next = || runtime.block_on(queue.next());
        std::iter::from_fn(next)
            .map(|queued| {
                (
                    queued.message.topic,
                    serde_json::from_str(&queued.message.json).unwrap(),
                )
            })
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
        let found: Vec<(Topic, u64)> = all
            .iter()
            .map(|(topic, json)| (*topic, json["index"].as_u64().unwrap()))
            .collect();
        use Topic::{Diagnostics, Frames};
        assert_eq!(
            found,
            [(Frames, 0), (Diagnostics, 0), (Frames, 1), (Diagnostics, 1)]
        );
        assert_eq!(all[1].1["settings"]["array"]["front"], 1);
        assert_eq!(all[1].1["positions_mm"].as_array().unwrap().len(), 16);
    }
}
