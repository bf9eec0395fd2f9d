//! `check`: a first power-up in one command. A conversation with the board gives
//! [`Observations`]; each row of the table in [`table`] is a pure function of them.

mod converter;
mod frames;
mod gather;
mod line;
mod observations;
mod processor;
mod report;
mod signals;
pub mod table;

pub use gather::{Plan, gather};
pub use observations::{Exchanged, Inputs, Kept, Observations, Watched};
pub use report::Report;
pub use table::{Check, Verdict, judge};

#[cfg(test)]
mod tests;
