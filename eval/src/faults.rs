//! `faults`: faults injected into the chip, its bus and its lines, thousands of them, and what became of them.
//!
//! | what | where |
//! |---|---|
//! | what is injected, and by what it is to be noticed | [`family`] |
//! | one run: a touch, and when what is injected | [`plan`] |
//! | the firmware's rooms on this PC, run as its tasks | [`rooms`] |
//! | the image on the emulated chip | [`emulated`] |
//! | what a run showed, fault for fault | [`judge`] |
//! | the line, both ways, and power lost while settings are stored | [`lines`] |
//! | rows of the table | [`row`] |
//! | all of it: so many runs of each family | [`campaign`] |
//! | the document | `document` |
//!
//! Judged is what a reader of the telemetry gets, against what the simulated chip knows.

pub mod campaign;
mod document;
mod draw;
pub mod emulated;
pub mod family;
pub mod judge;
pub mod lines;
mod order;
pub mod plan;
pub mod rooms;
pub mod row;

pub use campaign::{Campaign, FaultsArgs};
