//! The ten registers: names, addresses, reset values.

use core::fmt;

/// A register, by the name the datasheet gives it (SBAS297G, register map).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Register {
    /// 0x00: SPIRST, MUXMOD, BYPAS, CLKENB, CHOP, STAT.
    Config0 = 0x00,
    /// 0x01: IDLMOD, DLY, SBCS, DRATE.
    Config1 = 0x01,
    /// 0x02: AINP\[3:0\] and AINN\[3:0\] of the fixed channel.
    Muxsch = 0x02,
    /// 0x03: DIFF7 to DIFF0, the differential pairs of the auto-scan.
    Muxdif = 0x03,
    /// 0x04: AIN7 to AIN0, the lower single-ended inputs of the auto-scan.
    Muxsg0 = 0x04,
    /// 0x05: AIN15 to AIN8, the upper single-ended inputs of the auto-scan.
    Muxsg1 = 0x05,
    /// 0x06: REF, GAIN, TEMP, VCC, OFFSET; see [`Sysred`](crate::Sysred).
    Sysred = 0x06,
    /// 0x07: direction of the eight GPIO pins, 1 = input.
    Gpioc = 0x07,
    /// 0x08: levels of the eight GPIO pins.
    Gpiod = 0x08,
    /// 0x09: read-only. Only bit 4 is guaranteed: 0 = ADS1258, 1 = ADS1158.
    Id = 0x09,
}

impl Register {
    /// All ten in the order of their addresses.
    pub const ALL: [Self; 10] = [
        Self::Config0,
        Self::Config1,
        Self::Muxsch,
        Self::Muxdif,
        Self::Muxsg0,
        Self::Muxsg1,
        Self::Sysred,
        Self::Gpioc,
        Self::Gpiod,
        Self::Id,
    ];

    /// How many registers can be written: all but ID, which is the last.
    pub const WRITABLE: usize = 9;

    /// Address, 0x00 to 0x09.
    #[must_use]
    pub const fn address(self) -> u8 {
        self as u8
    }

    /// Value after a reset. Of ID, 0x8B, only bit 4 is guaranteed.
    #[must_use]
    pub const fn reset_value(self) -> u8 {
        match self {
            Self::Config0 => 0x0A,
            Self::Config1 => 0x83,
            Self::Muxsch | Self::Muxdif | Self::Sysred | Self::Gpiod => 0x00,
            Self::Muxsg0 | Self::Muxsg1 | Self::Gpioc => 0xFF,
            Self::Id => 0x8B,
        }
    }
}

/// The datasheet's names: `CONFIG0`, `MUXSCH`, ...
impl fmt::Display for Register {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Config0 => "CONFIG0",
            Self::Config1 => "CONFIG1",
            Self::Muxsch => "MUXSCH",
            Self::Muxdif => "MUXDIF",
            Self::Muxsg0 => "MUXSG0",
            Self::Muxsg1 => "MUXSG1",
            Self::Sysred => "SYSRED",
            Self::Gpioc => "GPIOC",
            Self::Gpiod => "GPIOD",
            Self::Id => "ID",
        })
    }
}
