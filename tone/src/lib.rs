#![doc = include_str!("../README.md")]
//!
//! # The way of a window
//!
//! Steps in their order; each file imports only from files above it and from shared types:
//!
//! | step | what it does |
//! |---|---|
//! | `source`, `frame_span` | frames, and a window of them, read block by block |
//! | `fitter` | the order of the steps |
//! | `coarse`, `levels` | the first pass: levels, noise, usable channels, means of a few frames |
//! | `search`, `spectrum` | the strongest line of a periodogram |
//! | `few_cycles`, `survey`, `relaxing` | below four cycles: all models of tone and baseline, by their likelihoods |
//! | `fundamental` | whether the line is a harmonic of its tone |
//! | `refine`, `descent` | Gauss-Newton steps to the maximum of the likelihood |
//! | `nuisance`, `moments`, `solution` | in each step: one pass for the sums, and the least-squares solution from them |
//! | `conclude`, `residuals` | whether it is a tone, and with what uncertainty |
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

mod abscissa;
mod coarse;
mod conclude;
mod curvature;
mod descent;
mod equations;
mod few_cycles;
mod fit;
mod fitter;
mod frame_span;
mod fundamental;
mod groups;
mod guess;
mod levels;
mod likelihood;
mod limits;
mod means;
mod model;
mod moments;
mod normal;
mod nuisance;
pub mod phase;
mod refine;
mod relaxing;
mod residuals;
mod search;
mod significance;
mod solution;
mod source;
mod spectrum;
mod sums;
mod survey;
mod waves;
mod window;

pub use descent::CYCLES_FOR_SLOPE;
pub use fit::{ChannelFit, Fit, Status};
pub use fitter::{FRAMES_MIN, Fitter};
pub use frame_span::FrameSpan;
pub use limits::{CHANNELS_MAX, HARMONICS_MAX};
pub use source::{FrameSource, Frames, Overwritten, Table, Values};
pub use spectrum::{POINTS_MAX as FRAMES_MAX, Spectrum};
