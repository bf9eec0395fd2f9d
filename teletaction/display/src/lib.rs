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
// `!(a > b)` is intended: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod afterimage;
mod error;
mod grid;
pub mod half_plane;
pub mod half_space;
mod kelvin;
mod limits;
mod matching;
mod nonnegative;
mod packed;
mod sensor_space;
mod set;

pub use afterimage::Afterimage;
pub use error::Error;
pub use grid::{Grid, Quantity};
pub use kelvin::{Kelvin, SUBJECTS};
pub use limits::{Limits, Pins, Steps};
pub use matching::{Matching, PINS_MAX, Solution};
