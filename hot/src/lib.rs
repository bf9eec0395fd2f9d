//! What runs for every conversion, every frame and every frequency tried: the arithmetic of Ridgetone.
//!
//! A crate of its own because it is compiled for speed, and all the rest - which decides, tells and talks - for
//! size: that is how both the image's flash and the fit's instructions stay within their bars. The crate
//! `ridgetone` re-exports these modules under their own names.
#![no_std]
// A panic resets the finger: only tests may.
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
// Taxels and unknowns are numbered; loops over several arrays at once read better by number.
#![allow(clippy::needless_range_loop)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod chance;
pub mod contact;
pub mod dating;
pub mod frame;
pub mod levels;
pub mod moments;
pub mod motion;
pub mod normal;
pub mod nuisance;
pub mod phase;
pub mod residuals;
pub mod settings;
pub mod solve;
pub mod spectrum;
pub mod stretch;
pub mod waves;
pub mod window;
