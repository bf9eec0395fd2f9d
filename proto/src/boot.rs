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

impl ResetCause {
    /// By RCC_CSR's flags (RM0090, 7.3.21). The pin NRST is pulled by every reset, so it counts only alone.
    pub const fn from_flags(csr: u32) -> Self {
        const PIN: u32 = 1 << 26;
        const BROWN_OUT_OR_POWER: u32 = 1 << 25 | 1 << 27;
        const SOFTWARE: u32 = 1 << 28;
        const WATCHDOGS: u32 = 1 << 29 | 1 << 30;
        // A supply that went away explains whatever else happened then.
        if csr & BROWN_OUT_OR_POWER != 0 {
            Self::Power
        } else if csr & WATCHDOGS != 0 {
            Self::Watchdog
        } else if csr & SOFTWARE != 0 {
            Self::Software
        } else if csr & PIN != 0 {
            Self::Pin
        } else {
            Self::Unknown
        }
    }
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
    /// Address of the instruction (HardFault), 0 otherwise, and 0 if the stack overflowed: then nothing could keep it.
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
    /// What was stored last cannot be read: these were stored before that.
    StoredBefore,
}

/// What `hello` says of the start.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Boot {
    /// What the processor was reset by.
    pub cause: ResetCause,
    /// What the run before died of, if it did.
    pub record: Option<Record>,
}

impl Boot {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { cause: ResetCause::Unknown, record: None };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an STM32F405 has in the top byte of RCC_CSR (RM0090, 7.3.21): LPWR, WWDG, IWDG, SFT, POR, PIN, BOR, RMVF.
    #[test]
    fn the_cause_is_read_from_the_flags() {
        let cases = [
            (0b0000_1110, ResetCause::Power),
            (0b0000_0110, ResetCause::Power),
            (0b0000_0100, ResetCause::Pin),
            (0b0001_0100, ResetCause::Software),
            (0b0010_0100, ResetCause::Watchdog),
            (0b0100_0100, ResetCause::Watchdog),
            (0b1000_0000, ResetCause::Unknown),
            (0, ResetCause::Unknown),
        ];
        for (flags, cause) in cases {
            // The bits below are the oscillator's.
            assert_eq!(ResetCause::from_flags(flags << 24 | 3), cause, "{flags:08b}");
        }
    }
}
