//! The ten registers: names, addresses, reset values.

use core::fmt;

/// A register, with the datasheet's name; its discriminant is its address (SBAS297G, register map).
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

/// Values of the writable registers, CONFIG0 to GPIOD.
pub(crate) type Image = [u8; Register::WRITABLE];

impl Register {
    /// All registers in the order of their addresses.
    pub const ALL: [Self; 10] = {
        use Register::*;
        [
            Config0, Config1, Muxsch, Muxdif, Muxsg0, Muxsg1, Sysred, Gpioc, Gpiod, Id,
        ]
    };

    /// Values after a reset, in order of address. Of ID, 0x8B, only bit 4 is guaranteed.
    pub const RESET_VALUES: [u8; 10] = [0x0A, 0x83, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x8B];

    /// Number of writable registers: all except ID, the last one.
    pub const WRITABLE: usize = 9;
}

const NAMES: [&str; 10] = [
    "CONFIG0", "CONFIG1", "MUXSCH", "MUXDIF", "MUXSG0", "MUXSG1", "SYSRED", "GPIOC", "GPIOD", "ID",
];

/// The datasheet's names: `CONFIG0`, `MUXSCH`, ...
impl fmt::Display for Register {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NAMES.get(*self as usize).copied().unwrap_or_default())
    }
}
