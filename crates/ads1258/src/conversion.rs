//! One result as sent by the chip: a status byte and 24 bits.

use crate::Channel;

/// One conversion as read: status byte and 24-bit two's complement code (SBAS297G, data format).
/// One LSB is VREF / 0x78_0000 (see [`reading`](crate::reading)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Conversion {
    /// Status byte.
    pub status: Status,
    /// Code, -0x80_0000 to 0x7F_FFFF; it clips at both ends.
    pub code: i32,
}

impl Conversion {
    /// Parses the four bytes after the read command: status byte, then the code, big endian. Every
    /// bit pattern is valid.
    ///
    /// ```
    /// use ads1258::Conversion;
    /// assert_eq!(Conversion::from_bytes([0x88, 0xFF, 0xFF, 0xFE]).code, -2);
    /// ```
    #[inline]
    pub const fn from_bytes(bytes: [u8; 4]) -> Self {
        let [status, high, middle, low] = bytes;
        // The code sits in the upper three bytes, so the arithmetic shift extends its sign.
        Self {
            status: Status(status),
            code: i32::from_be_bytes([high, middle, low, 0]) >> 8,
        }
    }
}

/// The status byte in front of every conversion: NEW, OVF, SUPPLY, CHID\[4:0\] (SBAS297G, status
/// byte).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(pub u8);

impl Status {
    /// NEW, bit 7: this conversion has not been read before. A second read of the same data has NEW
    /// cleared.
    #[inline]
    pub const fn is_new(self) -> bool {
        self.0 & 0x80 != 0
    }

    /// OVF, bit 6: the input exceeded about 1.06 VREF. When clear, a short overload is still
    /// possible.
    #[inline]
    pub const fn is_overflow(self) -> bool {
        self.0 & 0x40 != 0
    }

    /// SUPPLY, bit 5: the analogue supply is below about 4.3 V and this data is invalid.
    #[inline]
    pub const fn is_supply_low(self) -> bool {
        self.0 & 0x20 != 0
    }

    /// CHID, bits 4 to 0, as sent: 0 to 0x1F. This is not the number of the AIN pin.
    #[inline]
    pub const fn chid(self) -> u8 {
        self.0 & 0x1F
    }

    /// The channel with this CHID; `None` for the ids that the chip does not use (0x19, 0x1E,
    /// 0x1F), which mean a corrupted transfer.
    ///
    /// Meant for the auto-scan; this driver does not rely on CHID in fixed-channel mode.
    #[inline]
    pub const fn channel(self) -> Option<Channel> {
        Channel::from_id(self.chid())
    }
}
