//! Totals of messages published and lost since this command started, for the status. A subscriber
//! that was disconnected compares them with the messages that it received.

use super::super::message::{Lost, Message};
use super::super::topic::{Names, Topic};
use crate::utc::Receipt;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;

#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Publishes {
    Online,
    Offline,
}

pub struct Totals {
    begun_utc_s: f64,
    /// Messages by topic, for each finger.
    published: Vec<BTreeMap<Topic, u64>>,
}

impl Totals {
    pub fn new(fingers: usize) -> Self {
        Self {
            begun_utc_s: Receipt::now(0.0).utc_s(),
            published: vec![BTreeMap::new(); fingers],
        }
    }

    /// Counts a message as published; one that is published again is counted once.
    pub fn publish(&mut self, message: &Message) {
        if let Some(index) = message.index {
            self.published[message.finger].insert(message.topic, index + 1);
        }
    }

    /// Takes a message back out of the published count, because it will be published again.
    pub fn take_back(&mut self, message: &Message) {
        if let Some(index) = message.index
            && let Some(count) = self.published[message.finger].get_mut(&message.topic)
        {
            *count = index.min(*count);
        }
    }

    pub fn status(&self, state: Publishes, names: &Names, lost: &[Lost]) -> String {
        let finger = |(published, lost)| json!({"published": published, "lost": lost});
        let fingers = self.published.iter().zip(lost).map(finger);
        let fingers: BTreeMap<&String, _> = names.fingers.iter().zip(fingers).collect();
        json!({"state": state, "begun_utc_s": self.begun_utc_s, "fingers": fingers}).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn what_is_published_again_is_counted_once() {
        let message = |index| Message {
            finger: 0,
            topic: Topic::Tone,
            json: String::new(),
            time_ns: 0,
            index: Some(index),
            is_state: false,
        };
        let mut totals = Totals::new(1);
        let published = |totals: &Totals| {
            let status = totals.status(Publishes::Online, &Names::unnamed(), &[Lost::default()]);
            let status: Value = serde_json::from_str(&status).unwrap();
            status["fingers"]["finger"]["published"]["tone"].clone()
        };
        (0..5).for_each(|index| totals.publish(&message(index)));
        assert_eq!(published(&totals), 5);
        (3..5).for_each(|index| totals.take_back(&message(index)));
        assert_eq!(published(&totals), 3);
        (3..6).for_each(|index| totals.publish(&message(index)));
        assert_eq!(published(&totals), 6);
    }
}
