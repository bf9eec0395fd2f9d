//! Messages from a finger to the sinks, or into an MCAP file: an object of `--json` with its topic.

use super::topic::Topic;
use crate::events::view::{self, Note};
use crate::static_image::{PLACES, UNIT_PITCH_MM};
use crate::utc::Receipt;
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Maximum number of characters quoted in an error about an invalid message.
const SHOWN: usize = 60;

#[derive(Clone, Debug)]
pub struct Message {
    /// Index of the finger in [`Names`](super::topic::Names).
    pub finger: usize,
    pub topic: Topic,
    /// One object on one line.
    pub json: String,
    /// Time of the event, nanoseconds since 1970.
    pub time_ns: u64,
    /// Number of the message on its topic; `None` for a message to a single sink.
    pub index: Option<u64>,
    /// True if the message is valid until the next one of its topic and type: a greeting with the
    /// settings, a texture, or a health message.
    pub is_state: bool,
}

/// Latest states of the fingers, for receivers that connect later.
#[cfg(any(feature = "foxglove", feature = "mqtt"))]
#[derive(Debug, Default)]
pub struct Latest(std::collections::BTreeMap<(usize, Topic), std::sync::Arc<Message>>);

#[cfg(any(feature = "foxglove", feature = "mqtt"))]
impl Latest {
    /// Keeps the message if it is a state. Each topic has one type of state.
    pub fn take(&mut self, message: &std::sync::Arc<Message>) {
        if message.is_state {
            let key = (message.finger, message.topic);
            self.0.insert(key, std::sync::Arc::clone(message));
        }
    }

    pub fn all(&self) -> impl Iterator<Item = &std::sync::Arc<Message>> {
        self.0.values()
    }
}

/// Messages of a finger that a sink has lost since the command started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Lost {
    pub frames: u64,
    pub events: u64,
    /// Frames passed to a connection that broke, which may or may not have arrived.
    #[serde(rename = "frames_unconfirmed")]
    pub unconfirmed: u64,
}

impl Lost {
    pub fn add(&mut self, other: Self) {
        self.frames += other.frames;
        self.events += other.events;
        self.unconfirmed += other.unconfirmed;
    }
}

/// Creates the report of messages of a finger that a sink has lost. Only that sink gets the report,
/// which therefore has no number on its topic.
pub fn lost(finger: usize, sink: &str, lost: Lost) -> Message {
    let Lost {
        frames,
        events,
        unconfirmed,
    } = lost;
    let now = Receipt::now(0.0);
    let lost = view::Lost {
        at: sink.to_owned(),
        frames: Some(frames),
        events: Some(events),
        frames_unconfirmed: Some(unconfirmed),
        ..view::Lost::default()
    };
    Message {
        finger,
        topic: Topic::Diagnostics,
        json: noted(Note::Lost(lost), now),
        time_ns: now.utc_ns,
        index: None,
        is_state: false,
    }
}

pub fn noted(note: Note, at: Receipt) -> String {
    #[derive(Serialize)]
    struct Noted {
        #[serde(flatten)]
        note: Note,
        received_utc_s: f64,
    }
    let noted = Noted {
        note,
        received_utc_s: at.utc_s(),
    };
    // Serializing these fields cannot fail.
    json!(noted).to_string()
}

/// Fields that decide the topic and the time of a message.
#[derive(Deserialize)]
pub struct Head {
    r#type: String,
    pub utc_s: Option<f64>,
    pub received_utc_s: Option<f64>,
    /// Number on the topic.
    #[serde(skip)]
    pub index: u64,
}

impl Head {
    pub fn is_state(&self) -> bool {
        matches!(self.r#type.as_str(), "hello" | "texture" | "health")
    }
}

/// Turns the objects of `--json` into messages for streams and MCAP files.
///
/// Each message gets an `index`, which counts from 0 on its topic; a greeting also gets
/// `positions_mm`. Viewers allow only one type per field, so null fields are omitted.
#[derive(Clone, Debug, Default)]
pub struct Streamed {
    /// Number of messages on each topic so far.
    counts: [u64; Topic::ALL.len()],
}

impl Streamed {
    /// Returns the topic, text and head of a message; `json` is one object on one line.
    pub fn message(&mut self, mut json: String) -> Result<(Topic, String, Head)> {
        let named = || json.chars().take(SHOWN).collect::<String>();
        let mut head: Head = serde_json::from_str(&json).with_context(named)?;
        let topic = Topic::of(&head.r#type);
        if json.contains(":null") {
            let mut object: Value = serde_json::from_str(&json).with_context(named)?;
            drop_nulls(&mut object);
            json = object.to_string();
        }
        // Remove the closing brace of the object.
        json.truncate(json.trim_end().len() - 1);
        if head.r#type == "hello" {
            json += &format!(r#","positions_mm":{}"#, json!(positions_mm()));
        }
        let count = &mut self.counts[topic as usize];
        json += &format!(r#","index":{count}}}"#);
        head.index = *count;
        *count += 1;
        Ok((topic, json, head))
    }
}

/// Removes null fields; null items of lists stay, so that the other items keep their positions.
fn drop_nulls(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(drop_nulls);
        }
        Value::Array(items) => items.iter_mut().for_each(drop_nulls),
        _ => {}
    }
}

/// Returns the centre of each taxel's unit, along and across the sliding direction, millimetres
/// from the array's centre. The four taxels of a unit lie around the unit's centre, on a cross
/// whose size the paper does not state.
pub fn positions_mm() -> Vec<[f64; 2]> {
    let places = || {
        PLACES.iter().enumerate().flat_map(|(row, taxels)| {
            taxels
                .iter()
                .enumerate()
                .map(move |(column, taxel)| (*taxel, row, column))
        })
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

    /// Checks that the default settings and the map agree on which taxels are in the front column.
    #[test]
    fn the_front_units_are_a_pitch_further_along_x() {
        let front = ridgetone_proto::settings::Array::DEFAULT.front;
        for (taxel, [x_mm, y_mm]) in positions_mm().into_iter().enumerate() {
            assert_eq!(x_mm, if front >> taxel & 1 != 0 { 1.15 } else { -1.15 });
            assert_eq!(y_mm, if taxel < 8 { 1.15 } else { -1.15 });
        }
    }
}
