//! `check`: a first power-up in one command. One conversation with the board gives [`Observations`]; every [`Check`] is a pure
//! function of them.

mod acquisition;
mod converter;
mod gather;
mod lengths;
mod line;
mod observations;
mod processor;
mod report;
mod signals;
mod verdict;

pub use gather::{Plan, gather};
pub use observations::{Exchanged, Kept, Observations, Watched};
pub use report::Report;
pub use verdict::{Check, Inputs, Verdict};

/// Judges what was seen. `inputs` is what is connected to the analog inputs.
pub fn judge(seen: &Observations, inputs: Inputs) -> Vec<Check> {
    let mut checks = processor::checks(seen);
    checks.extend(converter::checks(seen));
    checks.extend(acquisition::checks(seen, inputs));
    checks.extend(line::checks(seen));
    checks
}

#[cfg(test)]
mod tests;
