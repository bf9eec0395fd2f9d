//! Detection, counting and reporting of faults, and their effect on an estimate.

pub mod diagnostics;
pub mod episodes;
pub mod found;
pub mod log;
pub mod qualify;
