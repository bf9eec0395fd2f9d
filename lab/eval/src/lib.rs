//! The fault campaign: thousands of faults injected into the simulated chip, its bus and its
//! lines. Other campaigns are scripts in `lab`.
#![forbid(unsafe_code)]
// Not published: fields are undocumented if their name and unit say everything.
#![allow(missing_docs)]
// `!(a > b)` is deliberate, because it is also true for NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub use commands::main;

mod commands;
mod draw;
mod faults;
mod page;
mod parallel;

#[cfg(test)]
mod tests;
