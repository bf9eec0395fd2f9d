//! Why the firmware started, what it died of before, and where its settings come from: said in `hello`.

use serde::{Deserialize, Serialize};

/// Bytes of a source file's name that a record keeps: its end.
pub const FILE_BYTES: usize = 24;

/// What the processor was reset by (RM0090, RCC_CSR).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Not known: a PC, or an emulator without the register.
    #[default]
    Unknown,
    /// Power came, or went below the brown-out level.
    Power,
    /// The pin NRST.
    Pin,
    /// The firmware itself: the command to restart, or after a panic or a fault.
    Software,
    /// The independent watchdog: acquisition or processing stood still.
    Watchdog,
}

/// How the firmware died.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Death {
    /// A panic.
    Panic,
    /// A HardFault.
    HardFault,
}

/// What is left of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// How.
    pub death: Death,
    /// The board's microsecond counter then; it wraps after 71.6 minutes.
    pub t_us: u32,
    /// Address of the instruction (HardFault), 0 otherwise.
    pub pc: u32,
    /// Address it was called from (HardFault), 0 otherwise.
    pub lr: u32,
    /// End of the source file's name (panic).
    pub file: heapless::String<FILE_BYTES>,
    /// Line in it (panic), 0 otherwise.
    pub line: u32,
}

/// Where the settings in force come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SettingsSource {
    /// Compiled in, or nothing was ever stored.
    #[default]
    Default,
    /// Stored before.
    Stored,
    /// Sent by the PC since start-up.
    Sent,
    /// Something was stored and cannot be read: these are the defaults.
    Damaged,
}

/// What `hello` says of the start.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Boot {
    /// What the processor was reset by.
    pub cause: ResetCause,
    /// What the run before died of, if it did.
    pub record: Option<Record>,
}
