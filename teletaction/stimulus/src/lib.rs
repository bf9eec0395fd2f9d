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

mod actuator;
mod bounds;
mod delay;
mod error;
mod hand;
mod law;
mod path;
mod stimulus;
mod texture;
mod vibration;

pub use actuator::Actuator;
pub use delay::Delay;
pub use error::Error;
pub use hand::Encoder;
pub use law::AmplitudeLaw;
pub use path::Path;
pub use stimulus::{Prepared, Stimulus};
pub use texture::{HARMONICS_MAX, Harmonic, Texture};
pub use vibration::Vibration;
