#![doc = include_str!("../README.md")]
#![no_std]
// A panic resets a board: only tests may.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented
    )
)]
#![forbid(unsafe_code)]
// Receptors and indices are numbered; loops over several arrays at once are easier to read by
// number.
#![allow(clippy::needless_range_loop)]

mod firing;
mod mean;
mod receptor;
mod reference;
mod score;
mod windows;

pub use firing::{Absent, Firing};
pub use mean::MeanFiring;
pub use receptor::{RECEPTORS, Receptor};
pub use reference::{Reference, SpectralLine};
pub use score::{INDICES, Indices, ROUGH, SOFT, Score};
pub use windows::{PAPER_WINDOW_S, Windows};

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f32,
    /// Standard deviation of `value`.
    pub sigma: f32,
}
