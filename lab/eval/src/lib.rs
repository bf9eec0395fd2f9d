//! Everything that proves Ridgetone and is not shipped.
//!
//! | what | where |
//! |---|---|
//! | the estimators that one would otherwise pick | [`baselines`] |
//! | information about a frequency | `bound` |
//! | the simulated converter | `simulated` |
//! | the boards' images on the register model | `board` |
//! | noise of sixteen channels | `noise` |
//! | recordings of real touch | `real` |
//! | touches against their truth | `touch` |
//! | the paper's experiment | `reproduce` |
//! | injected faults | `faults` |
#![forbid(unsafe_code)]
// Nobody publishes it: a field whose name and unit say all has no doc.
#![allow(missing_docs)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod baselines;

pub use commands::main;

mod board;
mod bound;
mod commands;
mod draw;
mod faults;
mod noise;
mod page;
mod parallel;
mod real;
mod reproduce;
mod simulated;
mod touch;

#[cfg(test)]
mod tests;
