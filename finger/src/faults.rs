//! What goes wrong: seen, counted, reported, and what it means for an estimate.

pub mod diagnostics;
pub mod episodes;
pub mod log;
pub mod qualify;
