//! All checks, in their order.

use super::observations::Observations;
use super::verdict::{Check, Inputs};
use super::{acquisition, converter, line, processor};

/// Judges what was seen. `inputs` is what is connected to the analog inputs.
pub fn judge(seen: &Observations, inputs: Inputs) -> Vec<Check> {
    let mut checks = processor::checks(seen);
    checks.extend(converter::checks(seen));
    checks.extend(acquisition::checks(seen, inputs));
    checks.extend(line::checks(seen));
    checks
}
