#![doc = include_str!("../README.md")]
#![no_std]
// A panic resets the board, so only tests may panic.
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
#![deny(unsafe_code)]
// Indexed loops over several arrays of channels or unknowns read better than zipped iterators.
#![allow(clippy::needless_range_loop)]

mod blocks;
mod comb;
mod conclude;
mod covariance;
mod domain;
mod fit;
mod fitter;
mod frame;
mod frame_span;
mod hum;
mod hypotheses;
mod impulses;
mod late;
mod lean;
mod legendre;
mod limits;
mod lines;
mod matrix;
mod mean;
mod movement;
mod noise_bins;
mod normal;
mod nyquist;
pub mod phase;
mod refine;
mod residual;
mod root;
mod rows;
mod scene;
mod search;
mod significance;
mod solve;
mod source;
mod spectrum;
mod statistics;
mod totals;
mod trajectory;
mod window_frames;
mod workspace;

pub use fit::{ChannelFit, Fit, Movement, OtherTone, Status, Tests};
pub use fitter::Fitter;
pub use frame_span::FrameSpan;
pub use late::Delays;
pub use lean::follow::Tracked;
pub use limits::{CHANNELS_MAX, FRAMES_MAX, FRAMES_MIN, HARMONICS_MAX, OVERTONES};
pub use root::sqrt;
pub use scene::{Band, Baseline, Channels, Noise, Scene, Speed};
pub use source::{FrameSource, Frames, Overwritten, Table, Values};
