//! Driver for the ADS1258 (stub).
#![no_std]
#![forbid(unsafe_code)]

/// One conversion as read: status byte and 24-bit two's complement code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Conversion {
    /// Status byte.
    pub status: Status,
    /// Code, -0x80_0000 to 0x7F_FFFF.
    pub code: i32,
}

/// The status byte in front of every conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(pub u8);
