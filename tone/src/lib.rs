//! The common frequency of up to sixteen channels, with its uncertainty.
//!
//! The fit is a joint least squares over all channels: one frequency, harmonics, and a baseline for each channel, each
//! channel weighted by its own noise. It needs no allocation and no operating system, and computes in `f32`.
//!
//! The steps, in the order in which a window walks through them:
//!
//! | step | what happens there |
//! |---|---|
//! | [`source`], [`frame_span`] | where frames come from; a window of them, read block by block |
//! | [`levels`], [`nuisance`], [`waves`], [`moments`] | one pass over the window each: all that the fit needs to know of it |
//! | [`spectrum`], [`search`], [`few_cycles`], [`survey`], [`model`], [`relaxing`], [`fundamental`] | a periodogram over the channels; the line in it, or the drift; the fundamental of that line: the first guess |
//! | [`normal`], [`solve`], [`descent`] | the least-squares solution at one frequency, and the steps towards a better one |
//! | [`residuals`], [`significance`] | what a solution leaves, sample by sample; what noise alone would reach |
//! | [`sine_fit`], [`status`] | the tone: its frequency, its uncertainty, and whether there is one |
//!
//! [`phase`] has cosine and sine.
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
