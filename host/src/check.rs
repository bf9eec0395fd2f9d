//! `check`: tests a board at its first power-up. A conversation with the board yields
//! [`Observations`], which each row of [`table::TABLE`] judges.

mod converter;
mod frames;
mod gather;
mod line;
mod observations;
mod processor;
mod report;
mod signals;
pub mod table;
mod verdict;

pub use gather::{Plan, gather};
pub use observations::{Exchanged, Inputs, Kept, Observations, Watched};
pub use report::Report;
pub use table::{Check, judge};
pub use verdict::Verdict;

#[cfg(test)]
mod tests;
