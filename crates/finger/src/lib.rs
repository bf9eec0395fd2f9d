#![doc = include_str!("../README.md")]
#![no_std]
// A panic resets the finger: only tests may panic.
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]
#![cfg_attr(
    not(test),
    deny(clippy::unreachable, clippy::todo, clippy::unimplemented)
)]
#![forbid(unsafe_code)]
// Indexed loops over several arrays read better than zipped iterators.
#![allow(clippy::needless_range_loop)]
// `!(a > b)` is intended: it is also true for NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

#[cfg(not(target_has_atomic = "32"))]
compile_error!(
    "ridgetone needs atomics of 32 bits with compare-and-swap, which this processor lacks (Cortex-M0, M0+)"
);

mod acquire;
mod assembler;
pub mod converter;
mod detector;
mod estimator;
mod event_builder;
mod faults;
mod fit;
mod frame;
mod health;
mod pipeline;
mod ring;
mod samples;
mod scan;
mod schedule;
mod surface;
pub mod tasks;
mod touch;
mod window;
mod wiring;

pub use acquire::Acquisition;
pub use detector::{Detector, Outputs};
pub use estimator::{Estimator, WindowFit, movement, other_tone, reported_status};
pub use faults::diagnostics::Diagnostics;
pub use fit::scene;
pub use frame::{PlainFrame, TimedConversion};
pub use pipeline::Pipeline;
pub use ring::Ring;
pub use samples::SampleQueue;
pub use scan::{CONVERSION_NS, FRAME_NS, SLOTS};
pub use window::Window;
pub use wiring::Wiring;

/// Single steps of the pipeline, for this repository's tests and benchmarks.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub use crate::assembler::Assembler;
    pub use crate::fit::{Fitted, Tracker, fit};
    pub use crate::schedule::{TRIM_FRAMES, window_frames_max};
    pub use crate::surface::{lag::lag, travel::by_phases};
    pub use crate::touch::averages::{Averager, Averages};
    pub use crate::touch::{
        change::Change,
        contact::{ContactDetector, Observed},
    };
}
