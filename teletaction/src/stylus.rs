//! The stylus: renders a texture that a finger has felt under a person's hand. Its image runs on a
//! separate board (`teletaction/image/`).
//!
//! | concept | where |
//! |---|---|
//! | messages on its line | [`message`] |
//! | parameters with their bounds | [`parameters`] |
//! | the sample interrupt: encoder in, code of the converter out | [`sampler`] |
//! | conditions under which it vibrates | [`gate`] |
//! | volts to codes of the converter, within the slew | [`dac`] |
//! | requests, and its reports | [`reports`] |
//!
//! The vibration itself is [`crate::stimulus`]'s; framing and checksums are
//! [`ridgetone_proto::framing`]'s; line, packets and idle time are the finger's own tasks
//! ([`ridgetone_finger::tasks`]).
// A panic resets the stylus, so only tests may panic.
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]
#![cfg_attr(
    not(test),
    deny(clippy::unreachable, clippy::todo, clippy::unimplemented)
)]

pub mod dac;
pub mod gate;
pub mod message;
pub mod parameters;
pub mod reports;
pub mod sampler;

/// Samples per second. Twice the paper's rate (Okamoto et al., section III-A), which halves the
/// converter's steps.
pub const SAMPLE_HZ: u32 = 10_000;

/// Time between samples, microseconds.
pub const SAMPLE_US: u32 = 1_000_000 / SAMPLE_HZ;

/// Number of samples after which the task `requests` runs even without a request: 4 ms, so
/// positions are reported 250 times a second.
pub const REPORT_SAMPLES: u32 = 40;
