//! Ridgetone: the tone of the ridges under a robotic fingertip, measured on the chip.
//!
//! Sixteen piezoresistors under a compliant skin slide over a grating. All of them see one common
//! frequency, f = speed / spatial period. This crate takes the conversions of an ADS1258 one by one
//! and gives events: contact, slide, estimates of that frequency with their uncertainty, release.
//! It needs no operating system, no allocation and no hardware. The firmware and the PC run the
//! same code and get the same numbers to the last bit.
//!
//! # The way of a sample
//!
//! | step | module |
//! |---|---|
//! | DRDY: read a conversion, supervise the chip | [`acquire`] |
//! | conversions to frames, by the slots of the scan | [`assembler`], [`frame`], [`scan`] |
//! | frames into the ring; contact, slide, hold, release | [`detector`], [`ring`], [`touch`] |
//! | windows of the slide that fall due | [`schedule`], [`window`] |
//! | fit a window, in time or by place | [`estimator`], [`abscissa`], crate `ridgetone-tone` |
//! | phases to spatial period, speed and direction | [`surface`] |
//! | faults: count, report, qualify estimates | [`faults`] |
//! | what each task of the firmware does | [`tasks`] |
//! | all of it in one call, for a PC | [`pipeline`] |
//!
//! On a chip the fit is a task of its own: `examples/drdy_loop.rs`. A PC does all in one call:
//!
//! ```
//! use ads1258::{Conversion, Status};
//! use ridgetone::{frame::TimedConversion, pipeline::Pipeline};
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

pub mod abscissa;
pub mod acquire;
pub mod assembler;
pub mod detector;
pub mod estimator;
pub(crate) mod event_builder;
pub mod faults;
pub mod feeling;
pub mod frame;
pub(crate) mod health;
pub mod pipeline;
pub mod ring;
pub mod scan;
pub mod schedule;
pub mod surface;
pub mod tasks;
pub mod touch;
pub mod window;
