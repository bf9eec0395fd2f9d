//! `faults`: faults injected into the chip, its bus and its lines, thousands of them, and what became of them.
//!
//! | what | where |
//! |---|---|
//! | what is injected, and by what it is to be noticed | [`family`] |
//! | one run: a touch, and when what is injected | [`plan`] |
//! | the firmware's task_sim on this PC, run as its tasks | [`task_sim`] |
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
pub mod plan;
pub mod row;
mod scan_order;
pub mod task_sim;

pub use campaign::{Campaign, FaultsArgs};
