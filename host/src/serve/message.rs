//! A message on its way from a finger to the sinks: an object of `--json` with its topic.

use super::topic::Topic;
use crate::static_image::{PLACES, UNIT_PITCH_MM};
use crate::utc::Receipt;
use serde_json::json;

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

/// Messages of a finger that a sink has lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    pub frames: u64,
    pub events: u64,
    /// Frames that were handed over to a connection that broke: nobody knows whether they have
    /// arrived.
    pub unconfirmed: u64,
}

impl Lost {
    pub fn add(&mut self, other: Self) {
        self.frames += other.frames;
        self.events += other.events;
        self.unconfirmed += other.unconfirmed;
    }
}

/// Reports the messages of a finger that a sink has lost. It is for that sink alone, and so has no
/// number on its topic.
pub fn lost(finger: usize, sink: &str, lost: Lost) -> Message {
    let Lost {
        frames,
        events,
        unconfirmed,
    } = lost;
    let now = Receipt::now(0.0);
    let json = json!({"type": "lost", "at": sink, "frames": frames, "events": events,
        "frames_unconfirmed": unconfirmed, "received_utc_s": now.utc_s()});
    Message {
        finger,
        topic: Topic::Diagnostics,
        json: json.to_string(),
        time_ns: now.utc_ns,
    }
}

/// The centre of each taxel's unit: along the sliding direction and across, millimetres from the
/// array's centre. The four taxels of a unit lie around it, on a cross whose size the paper does
/// not give.
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
