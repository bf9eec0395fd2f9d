//! Faults: noticed, counted, reported, and their effect on an estimate.

pub mod diagnostics;
pub mod episodes;
pub mod found;
pub mod log;
pub mod qualify;
