//! Everything that proves Ridgetone and is not shipped.
//!
//! | what | where |
//! |---|---|
//! | the estimators that one would otherwise pick | [`baselines`] |
//! | the bound that no unbiased estimator can beat | `bound` |
//! | many estimates against the truth and the bound | `accuracy` |
//! | simulated windows with their truth | `simulated`, `setting` |
//! | cost beside accuracy | `trade` |
//! | noise that is not white, and what is no tone | `noise` |
//! | injected faults | `faults` |
#![forbid(unsafe_code)]
// Nobody publishes it: a field whose name and unit say all has no doc.
#![allow(missing_docs)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod baselines;

pub use commands::main;

mod accuracy;
mod bound;
mod commands;
mod draw;
mod faults;
mod noise;
mod page;
mod parallel;
mod setting;
mod simulated;
mod trade;

#[cfg(test)]
mod tests;
