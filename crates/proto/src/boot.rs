//! Parts of `hello`: why the firmware started, how the previous run ended, and the source of its
//! settings.

use serde::{Deserialize, Serialize};

/// Maximum number of bytes of a source file's name in a record, which keeps the name's end.
pub const FILE_BYTES: usize = 24;

/// Cause of the last reset (RM0090, RCC_CSR).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ResetCause {
    /// Not known: a PC, or an emulator without the register.
    #[default]
    Unknown,
    /// Power-up, or a supply below the brown-out level.
    Power,
    /// The pin NRST.
    Pin,
    /// The firmware itself: by the command to restart, or after a panic or a HardFault.
    Software,
    /// The independent watchdog: acquisition or processing has stopped.
    Watchdog,
}

impl ResetCause {
    /// Determines the cause from RCC_CSR's flags (RM0090, 7.3.21). Every reset pulls the pin NRST,
    /// so the pin's flag only counts if it is the only one.
    pub const fn from_flags(csr: u32) -> Self {
        const PIN: u32 = 1 << 26;
        const BROWN_OUT_OR_POWER: u32 = 1 << 25 | 1 << 27;
        const SOFTWARE: u32 = 1 << 28;
        const WATCHDOGS: u32 = 1 << 29 | 1 << 30;
        // A loss of supply explains every other flag.
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

/// Source of the processor's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Oscillator {
    /// Not known: a PC, or an emulator without one.
    #[default]
    Unknown,
    /// The board's crystal or external clock (HSE).
    External,
    /// The chip's own oscillator (HSI): the external one did not start. It is off by up to 1 % at
    /// 25 degrees Celsius and 8 % between -40 and 105 (DS8626, HSI oscillator characteristics), and
    /// so are all times and frequencies.
    Internal,
}

/// The supply voltage below which the processor is held in reset (RM0090, FLASH_OPTCR, BOR_LEV).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BrownOut {
    /// Not known: a PC or an emulator.
    #[default]
    Unknown,
    /// Brown-out reset is off, as the chip is delivered: the processor runs down to 1.8 V.
    Off,
    /// Reset below 2.1 V.
    Level1,
    /// Reset below 2.4 V.
    Level2,
    /// Reset below 2.7 V: the flash is written by words of 32 bits, which is allowed from 2.7 V on.
    Level3,
}

impl BrownOut {
    /// Determines the level from FLASH_OPTCR, bits 2 and 3 (RM0090, 3.9.10).
    pub const fn from_option_bytes(optcr: u32) -> Self {
        match optcr >> 2 & 3 {
            0 => Self::Level3,
            1 => Self::Level2,
            2 => Self::Level1,
            _ => Self::Off,
        }
    }
}

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Death {
    /// A panic.
    Panic,
    /// A HardFault.
    HardFault,
    /// The external oscillator stopped (clock security system).
    Oscillator,
}

/// Record that a crashed run leaves for the next one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// End of the run.
    pub death: Death,
    /// The board's microsecond counter at the end; it wraps after 71.6 minutes.
    pub t_us: u32,
    /// Address of the instruction (HardFault). 0 otherwise, and after a stack overflow, which loses
    /// the address.
    pub pc: u32,
    /// Return address of the function (HardFault), 0 otherwise.
    pub lr: u32,
    /// End of the source file's name (panic).
    pub file: heapless::String<FILE_BYTES>,
    /// Line in the source file (panic), 0 otherwise.
    pub line: u32,
}

/// Where the settings in force come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SettingsSource {
    /// The compiled-in defaults: nothing was ever stored.
    #[default]
    Default,
    /// The flash.
    Stored,
    /// The PC, since start-up.
    Sent,
    /// The compiled-in defaults: what was stored cannot be read.
    Damaged,
    /// The flash, but what was stored last cannot be read: these are the settings stored before
    /// that.
    StoredBefore,
    /// The flash, as another version of the firmware stored them: settings that this one does not
    /// know were skipped, and those that are missing have their defaults.
    Migrated,
}

impl SettingsSource {
    /// True if the settings come from the flash.
    pub const fn is_stored(self) -> bool {
        matches!(self, Self::Stored | Self::StoredBefore | Self::Migrated)
    }
}

/// Reason for the firmware's start, and the conditions at start-up.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Boot {
    /// Cause of the last reset.
    pub cause: ResetCause,
    /// Source of the processor's clock.
    pub oscillator: Oscillator,
    /// Brown-out level of the processor.
    pub brown_out: BrownOut,
    /// End of the previous run, if it crashed.
    pub record: Option<Record>,
}

impl Boot {
    /// A start about which nothing is known.
    pub const UNKNOWN: Self = Self {
        cause: ResetCause::Unknown,
        oscillator: Oscillator::Unknown,
        brown_out: BrownOut::Unknown,
        record: None,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Top byte of RCC_CSR of an STM32F405 (RM0090, 7.3.21): LPWR, WWDG, IWDG, SFT, POR, PIN, BOR,
    /// RMVF.
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
            // Lower bits belong to the oscillator.
            assert_eq!(
                ResetCause::from_flags(flags << 24 | 3),
                cause,
                "{flags:08b}"
            );
        }
    }

    /// A chip as delivered has 0x0FFF_AAED (RM0090, 3.9.10, reset value).
    #[test]
    fn the_brown_out_level_is_read_from_the_option_bytes() {
        assert_eq!(BrownOut::from_option_bytes(0x0fff_aaed), BrownOut::Off);
        let levels = [
            BrownOut::Level3,
            BrownOut::Level2,
            BrownOut::Level1,
            BrownOut::Off,
        ];
        for (bits, level) in levels.into_iter().enumerate() {
            assert_eq!(
                BrownOut::from_option_bytes(0x0fff_aae1 | (bits as u32) << 2),
                level,
                "{bits:02b}"
            );
        }
    }
}
