//! Ridgetone: the tone of the ridges under a robotic fingertip, measured on the chip.
//!
//! Sixteen piezoresistors under a compliant skin slide over a grating; all of them see one common
//! frequency, f = speed / spatial period. This crate takes the conversions of an ADS1258 one by one
//! and gives events: contact, slide, estimates of that frequency with their uncertainty, release.
//! It needs no operating system, no allocation and no hardware; the firmware and the PC run it alike
//! and get the same numbers to the last bit.
//!
//! The rooms, in the order in which a sample walks through them:
//!
//! | room | what happens there |
//! |---|---|
//! | [`settings`] | what a user may set, with units, bounds and where each default comes from |
//! | [`acquire`] | conversions are read from the chip and queued; the chip is watched and set up anew |
//! | [`frame`] | conversions become 16-channel frames, by the chip's own channel id |
//! | [`motion`], [`contact`], [`dating`] | is anything moving; idle, contact spike, hold, slide, release; since when |
//! | [`window`] | the sliding phase in a fixed buffer, window by window |
//! | [`detector`] | composes the rooms so far: conversions give events and windows that are due |
//! | [`stretch`], [`levels`], [`nuisance`], [`waves`], [`moments`] | a window block by block; one pass over it each: all that the fit needs to know of it |
//! | [`spectrum`], [`search`], [`few_cycles`], [`survey`], [`model`], [`relaxing`], [`fundamental`] | a periodogram over the channels; the line in it, or the drift; the fundamental of that line: the first guess |
//! | [`solve`], [`descent`] | the least-squares solution at one frequency, and the steps towards a better one |
//! | [`residuals`], [`chance`] | what a solution leaves, sample by sample; what noise alone would reach |
//! | [`sine_fit`] | the tone: its frequency, its uncertainty, and whether there is one |
//! | [`lag`], [`travel`] | how far the tone of one column of units is behind the other's; from that the spatial period, speed and direction |
//! | [`pipeline`] | composes all of it: push(conversion) gives events |
//! | [`telemetry`], [`wire`] | the events, and how they travel |
//!
//! What goes wrong is named in [`fault`] and casts [`doubt`] on estimates, how a run began in [`boot`], what a PC may ask for
//! in [`command`]; [`order`] carries it out, [`store`] keeps settings.
//!
//! Besides them: [`phase`] (cosine and sine), [`normal`] (normal equations), what the firmware's tasks
//! share ([`queues`], [`outbox`], [`tally`], [`ledger`], [`load`], [`stack_depth`], [`vitals`]), what a dying run leaves ([`crash`]), [`bridge`] (the wire between the emulated board and the
//! simulated chip) and [`workload`] (the files between the benchmark in the emulator and the PC).
//!
//! The rooms that run for every conversion, every frame and every frequency tried are a crate of their own,
//! [`ridgetone_hot`], which is compiled for speed and the rest for size; what travels and what is kept are another, [`ridgetone_wire`], for
//! the least size. Here they have their places all the same.
//!
//! Method and phases follow Oddo et al., "Artificial roughness encoding with a bio-inspired
//! MEMS-based tactile sensor array", Sensors 9 (2009), 3161-3183, "the paper" in these pages.
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

pub mod abscissa;
pub mod acquire;
pub mod bridge;
pub mod descent;
pub mod detector;
pub mod doubt;
pub mod few_cycles;
pub mod fundamental;
pub mod lag;
pub mod ledger;
pub mod load;
pub mod model;
pub mod order;
pub mod outbox;
pub mod pipeline;
pub mod queues;
pub mod relaxing;
pub mod search;
pub mod sine_fit;
pub mod stack_depth;
pub mod survey;
pub mod tally;
pub mod travel;
pub mod vitals;
pub mod window;
pub mod workload;

pub use ridgetone_hot::{
    chance, contact, dating, frame, levels, moments, motion, normal, nuisance, phase, residuals, settings, solve,
    spectrum, stretch, waves,
};
pub use ridgetone_wire::{boot, command, crash, fault, profile, store, telemetry, wire};
