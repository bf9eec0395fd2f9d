//! What proves Ridgetone, and is not shipped.
//!
//! | what | where |
//! |---|---|
//! | what one would otherwise pick | [`baselines`] |
//! | the files between the benchmarks in the emulator and the PC | [`workload`] |
#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

#[cfg(any(not(target_os = "none"), feature = "bench-baselines"))]
pub mod baselines;
pub mod workload;

#[cfg(not(target_os = "none"))]
pub mod bench;
#[cfg(not(target_os = "none"))]
pub mod bit_errors;
#[cfg(not(target_os = "none"))]
pub mod bound;
#[cfg(not(target_os = "none"))]
pub mod faults;
#[cfg(not(target_os = "none"))]
mod markdown;
#[cfg(not(target_os = "none"))]
mod parallel;
#[cfg(not(target_os = "none"))]
pub mod reproduce;
#[cfg(not(target_os = "none"))]
pub mod setting;
#[cfg(not(target_os = "none"))]
pub mod simulated;
#[cfg(not(target_os = "none"))]
pub mod trade;
