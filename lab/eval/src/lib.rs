//! Everything that proves Ridgetone and is not shipped.
//!
//! | what | where |
//! |---|---|
//! | the estimators that one would otherwise pick | [`baselines`] |
//! | the bound that no unbiased estimator can beat | `bound` |
//! | many estimates against the truth and the bound | `accuracy` |
//! | simulated windows with their truth | `simulated`, `setting` |
//! | instructions, counted in the emulator | `bench`; the files between the emulator and the PC: [`workload`] |
//! | cost beside accuracy | `trade` |
//! | the boards' images on the register model | `board` |
//! | noise that is not white, and what is no tone | `noise` |
//! | recordings of real touch | `real` |
//! | touches against their truth | `touch` |
//! | the paper's experiment | `reproduce` |
//! | injected faults | `faults` |
#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]
// Nobody publishes it: a field whose name and unit say all has no doc.
#![allow(missing_docs)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

#[cfg(any(not(target_os = "none"), feature = "bench-baselines"))]
pub mod baselines;
pub mod workload;

#[cfg(not(target_os = "none"))]
pub use commands::main;

#[cfg(not(target_os = "none"))]
mod accuracy;
#[cfg(not(target_os = "none"))]
mod bench;
#[cfg(not(target_os = "none"))]
mod board;
#[cfg(not(target_os = "none"))]
mod bound;
#[cfg(not(target_os = "none"))]
mod commands;
#[cfg(not(target_os = "none"))]
mod draw;
#[cfg(not(target_os = "none"))]
mod faults;
#[cfg(not(target_os = "none"))]
mod noise;
#[cfg(not(target_os = "none"))]
mod page;
#[cfg(not(target_os = "none"))]
mod parallel;
#[cfg(not(target_os = "none"))]
mod real;
#[cfg(not(target_os = "none"))]
mod reproduce;
#[cfg(not(target_os = "none"))]
mod setting;
#[cfg(not(target_os = "none"))]
mod simulated;
#[cfg(not(target_os = "none"))]
mod touch;
#[cfg(not(target_os = "none"))]
mod trade;

#[cfg(test)]
mod tests;
