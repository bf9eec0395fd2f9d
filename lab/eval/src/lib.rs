//! The fault campaign: thousands of faults injected into the simulated chip, its bus and its
//! lines. Other campaigns are scripts in `lab`.
#![forbid(unsafe_code)]
// Not published: fields whose name and unit say everything have no doc.
#![allow(missing_docs)]
// `!(a > b)` is deliberate: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub use commands::main;

mod commands;
mod draw;
mod faults;
mod page;
mod parallel;

#[cfg(test)]
mod tests;
