//! Passes messages from a finger to all sinks, numbered by topic.

use super::message::{Message, Streamed, noted};
use super::queue::Queue;
use crate::events::view::Note;
use crate::utc::Receipt;
use anyhow::Result;
use std::sync::Arc;

pub struct Publisher {
    finger: usize,
    queues: Vec<Arc<Queue>>,
    streamed: Streamed,
}

impl Publisher {
    pub fn new(finger: usize, queues: Vec<Arc<Queue>>) -> Self {
        Self {
            finger,
            queues,
            streamed: Streamed::default(),
        }
    }

    /// Publishes an object of `--json`.
    pub fn publish(&mut self, json: String) -> Result<()> {
        let (topic, json, head) = self.streamed.message(json)?;
        let time_s = head.utc_s.or(head.received_utc_s);
        let time_ns =
            time_s.map_or_else(|| Receipt::now(0.0).utc_ns, |time_s| (time_s * 1e9) as u64);
        let message = Arc::new(Message {
            finger: self.finger,
            topic,
            json,
            time_ns,
            index: Some(head.index),
            is_state: head.is_state(),
        });
        self.queues
            .iter()
            .for_each(|queue| queue.push(Arc::clone(&message)));
        Ok(())
    }

    /// Publishes a message of this command itself.
    pub fn note(&mut self, note: Note) -> Result<()> {
        self.publish(noted(note, Receipt::now(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::topic::Topic;
    use super::*;
    use serde_json::Value;

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
            r#"{"type":"raw","volts":[1,null],"utc_s":null}"#,
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
        assert_eq!(
            all[0].1,
            serde_json::json!({"type": "raw", "volts": [1, null], "index": 0}),
            "a field that is null is left out"
        );
        assert_eq!(all[1].1["settings"]["array"]["front"], 1);
        assert_eq!(all[1].1["positions_mm"].as_array().unwrap().len(), 16);
    }
}
