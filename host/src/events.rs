//! Packets as lines of text for people and as JSON for programs.

mod json;
mod pin_forces;
mod text;

pub use json::{JsonLines, json, serializable};
pub use pin_forces::PinForces;
pub use text::{given, outcome, text};
