#![doc = include_str!("../README.md")]
//!
//! # The way of a window
//!
//! Windows of all lengths take the same steps, in this order:
//!
//! | step | what it does |
//! |---|---|
//! | `source`, `frame_span` | frames, and a window of them, read block by block |
//! | `fitter` | the order of the steps |
//! | `statistics` | the first pass: level, slope and noise of each channel, usable channels, means of a few frames |
//! | `search`, `spectrum` | candidates from three cycles on: lines of a periodogram |
//! | `search`, `grid`, `models` | candidates below four cycles: likelihoods on a grid of frequencies, with `curves` as baselines |
//! | `interferer` | where mains hum is in truth |
//! | `blocks` | a pass for a candidate: its sums over each of a few blocks |
//! | `refine`, `solve`, `normal` | shape of the model, least squares, Gauss-Newton steps to the maximum of the likelihood |
//! | `neighbourhood`, `colour` | the noise next to the lines, and how the tone moves |
//! | `impulses` | single values that are far off, replaced; then all steps once more |
//! | `mixture` | the last steps where channels share their noise, from mixtures of channels that do not |
//! | `found` | which candidates are the likeliest |
//! | `polish` | the last step, from the frames themselves |
//! | `conclude`, `significance` | whether it is a tone, and with what uncertainty |
//! | `trust`, `movement`, `other_lines`, `waves` | status and factor of sigma in noise that is not white; wander; lines beside the tone |
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
// Channels and unknowns are numbered; loops over several arrays at once read better by number.
#![allow(clippy::needless_range_loop)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
// The workspace allows five arguments; this crate is about to be rewritten, and then keeps to it.
#![allow(clippy::too_many_arguments)]

mod abscissa;
mod blocks;
mod cleaned;
mod colour;
mod conclude;
mod covariance;
mod curves;
mod fit;
mod fitter;
mod found;
mod frame_span;
mod grid;
mod impulses;
mod interferer;
mod limits;
mod mixture;
mod models;
mod movement;
mod neighbourhood;
mod normal;
mod other_lines;
pub mod phase;
mod polish;
mod refine;
mod search;
mod significance;
mod solve;
mod source;
mod spectrum;
mod statistics;
mod trust;
mod waves;

pub use fit::{ChannelFit, Fit, Movement, OtherTone, Status};
pub use fitter::{FRAMES_MIN, Fitter};
pub use frame_span::FrameSpan;
pub use limits::{CHANNELS_MAX, HARMONICS_MAX, OVERTONES, POINTS_MAX as FRAMES_MAX};
pub use source::{FrameSource, Frames, Overwritten, Table, Values};
