//! `check`: a first power-up in one command. One conversation with the board gives
//! [`Observations`]; every [`Check`] is a pure function of them.

mod acquisition;
mod converter;
mod gather;
mod judge;
mod lengths;
mod line;
mod observations;
mod processor;
mod report;
mod signals;
mod verdict;

pub use gather::{Plan, gather};
pub use judge::judge;
pub use observations::{Exchanged, Kept, Observations, Watched};
pub use report::Report;
pub use verdict::{Check, Inputs, Verdict};

#[cfg(test)]
mod tests;
