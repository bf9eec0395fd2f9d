//! Where packets come from: a board on a port, the emulated board, or a recording. One decoder
//! serves all three.
//!
//! A [`Source`] returns bytes; [`Feed`] decodes packets from them, counts losses, and records the
//! bytes on request.

mod decoded;
mod emulated;
mod following;
mod pace;
mod requester;
mod source;
mod strangers;

pub use decoded::Feed;
pub use emulated::{EMULATED, Emulated, Emulation, emulated, end, scene_input, untouched};
pub use following::{Following, RawFrames, SettingsReply};
pub use pace::Pace;
pub use requester::{Requester, new_requests, other_requests, request};
pub use source::{FeedEvent, NoBoard, Source};

#[cfg(test)]
mod tests;
