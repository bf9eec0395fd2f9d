//! Packets as lines of text for people and as JSON for programs.

mod json;
mod text;

pub use json::{JsonLines, json, serializable};
pub use text::{given, outcome, text};
