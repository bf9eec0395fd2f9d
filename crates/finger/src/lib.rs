//! Ridgetone: the tone of the ridges under a robotic fingertip, measured on the chip.
//!
//! Sixteen piezoresistors under a compliant skin slide over a grating. All of them see one common
//! frequency, f = speed / spatial period. This crate takes the conversions of an ADS1258 one by one
//! and gives events: contact, slide, estimates of that frequency with their uncertainty, release.
//! It needs no operating system, no allocation and no hardware. The firmware and the PC run the
//! same code and get the same numbers to the last bit.
//!
//! # The path of a sample
//!
//! | step | public name | file |
//! |---|---|---|
//! | the converter, as a trait, and the ADS1258 | [`converter`] | `converter.rs` |
//! | read a conversion at DRDY's edge, supervise the chip | [`Acquisition`], [`TimedConversion`] | `acquire.rs` |
//! | sort conversions into frames by the slots of the scan | [`SLOTS`], [`CONVERSION_NS`], [`FRAME_NS`] | `assembler.rs`, `scan.rs` |
//! | keep frames; find contact, slide, hold and release | [`Detector`], [`Ring`] | `detector.rs`, `ring.rs`, `touch/` |
//! | cut windows out of the slide | [`Window`] | `schedule.rs`, `window.rs` |
//! | fit a window | [`Estimator`], [`WindowFit`] | `estimator.rs`, `fit.rs`, crate `ridgetone-tone` |
//! | spatial period, speed and direction from the phases | | `surface/` |
//! | count and report faults, qualify estimates | [`Diagnostics`] | `faults/` |
//! | a fit's values in an event's units | [`movement`], [`other_tone`], [`reported_status`] | `estimator.rs` |
//! | what each task of the firmware does | [`tasks`] | `tasks/` |
//! | all of it in one call, for a PC | [`Pipeline`] | `pipeline.rs` |
//!
//! On a chip the fit is a task of its own: `examples/drdy_loop.rs`. A PC does all in one call:
//!
//! ```
//! use ads1258::{Conversion, Status};
//! use ridgetone_finger::{Pipeline, TimedConversion};
//! use ridgetone_proto::{settings::Settings, telemetry::Event};
//!
//! let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
//! // As read from the chip after an edge of DRDY: status byte with the channel, and the code.
//! let conversion = Conversion { status: Status(0x88), code: 4_000_000 };
//! pipeline.push(TimedConversion::new(197, conversion), &mut |event| println!("{event:?}"));
//! let mut events = Vec::new();
//! pipeline.finish(&mut |event| events.push(event));
//! assert!(matches!(events[..], [Event::Health(_)]));
//! ```
//!
//! The processor needs atomics of 32 bits with compare-and-swap, which a Cortex-M0 lacks.
//!
//! With another converter give frames: `examples/plain_frames.rs`.
//!
//! ```
//! use ridgetone_finger::{Pipeline, PlainFrame};
//! use ridgetone_proto::{plan::Plan, settings::Settings};
//!
//! // Three channels at 1 kHz, in volts within 2.5 V.
//! let plan = Plan::of_frames(1000.0, 3).unwrap();
//! let settings = Settings { vref_v: 2.5, ..Settings::DEFAULT.with_plan(plan) };
//! let mut pipeline = Box::new(Pipeline::new(settings));
//! let frame = PlainFrame { t_us: 0, readings: &[0.1, 0.2, 0.3] };
//! pipeline.push_frame(frame, &mut |event| println!("{event:?}"));
//! ```
//!
//! Method and phases follow Oddo et al., "Artificial roughness encoding with a bio-inspired
//! MEMS-based tactile sensor array", Sensors 9 (2009), 3161-3183, "the paper" in these pages.
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
// Loops over several arrays at once read better by number.
#![allow(clippy::needless_range_loop)]
// `!(a > b)` is meant: a NaN belongs on that side.
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
pub use scan::{CONVERSION_NS, FRAME_NS, SLOTS};
pub use window::Window;
pub use wiring::Wiring;

/// Steps of the path one by one, for this repository's tests and benchmarks.
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
