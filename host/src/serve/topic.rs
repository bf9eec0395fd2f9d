//! The topics of a finger: `/<board>/<finger>/<topic>`.

use crate::names::name;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Display;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// Every frame, delivered with best effort; all other topics are reliable.
    Frames,
    /// Touches: contact, motion, slide, release, static image.
    Contact,
    /// Estimates of the tone, and tracks.
    Tone,
    /// Surface under the finger.
    Texture,
    /// Greetings, faults, answers to requests, connections and losses.
    Diagnostics,
    /// Counters and readings, once a second.
    Health,
}

impl Topic {
    pub const ALL: [Self; 6] = [
        Self::Frames,
        Self::Contact,
        Self::Tone,
        Self::Texture,
        Self::Diagnostics,
        Self::Health,
    ];

    pub fn of(kind: &str) -> Self {
        match kind {
            "raw" => Self::Frames,
            "contact" | "moving" | "slide" | "release" | "image" => Self::Contact,
            "estimate" | "track" => Self::Tone,
            "texture" => Self::Texture,
            "health" => Self::Health,
            _ => Self::Diagnostics,
        }
    }

    pub fn name(self) -> &'static str {
        name(self)
    }
}

/// Default name of the board that carries the fingers.
pub const BOARD: &str = "ridgetone";

/// The names in topics.
#[derive(Clone, Debug)]
pub struct Names {
    /// Name of the board that carries the fingers.
    pub board: String,
    pub fingers: Vec<String>,
}

impl Names {
    /// Returns names for a recording, which does not contain its finger's name.
    pub fn unnamed() -> Self {
        Self {
            board: BOARD.to_owned(),
            fingers: vec!["finger".to_owned()],
        }
    }

    /// Returns metadata of a finger for Foxglove and MCAP channels.
    pub fn metadata(&self, finger: usize) -> BTreeMap<String, String> {
        let pairs = [
            ("board", self.board.as_str()),
            ("finger", self.fingers[finger].as_str()),
            ("ridgetone", env!("CARGO_PKG_VERSION")),
        ];
        pairs
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .into()
    }

    /// Returns a topic without the leading slash.
    pub fn path(&self, finger: usize, topic: impl Display) -> String {
        format!("{}/{}/{topic}", self.board, self.fingers[finger])
    }

    /// Returns the topic with the status of this command. It differs from every finger's topic,
    /// which has three parts.
    #[cfg(feature = "mqtt")]
    pub fn status(&self) -> String {
        format!("{}/status", self.board)
    }
}

impl Display for Topic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
