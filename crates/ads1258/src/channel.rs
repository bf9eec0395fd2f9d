//! Channels that the multiplexer can connect to the converter, and their ids.

use core::fmt;

/// A channel of the auto-scan (SBAS297G, channel id codes of the status byte).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// DIFF0 to DIFF7: the pair AIN(2n) minus AIN(2n + 1). The number is 0 to 7.
    Differential(u8),
    /// AIN0 to AIN15 against AINCOM. The number is 0 to 15.
    Single(u8),
    /// The converter's own offset, ideally code 0.
    Offset,
    /// The analogue supply voltage, see [`reading::supply_v`](crate::reading::supply_v).
    Vcc,
    /// The temperature of the die, see [`reading::temperature_c`](crate::reading::temperature_c).
    Temp,
    /// The gain, see [`reading::gain`](crate::reading::gain).
    Gain,
    /// The reference voltage, see [`reading::reference_v`](crate::reading::reference_v).
    Ref,
}

/// The one id below 0x1E that the chip never sends (SBAS297G, channel id codes).
const UNUSED_ID: u8 = 0x19;

impl Channel {
    /// CHID, 0 to 0x1D: DIFF0-7 = 0x00-0x07, AIN0-15 = 0x08-0x17, OFFSET 0x18, VCC 0x1A, TEMP 0x1B,
    /// GAIN 0x1C, REF 0x1D.
    ///
    /// A number out of range, such as `Single(16)`, returns 0x19, which the chip does not use.
    #[inline]
    pub const fn id(self) -> u8 {
        match self {
            Self::Differential(number) if number < 8 => number,
            Self::Single(number) if number < 16 => number.wrapping_add(8),
            Self::Differential(_) | Self::Single(_) => UNUSED_ID,
            Self::Offset => 0x18,
            Self::Vcc => 0x1A,
            Self::Temp => 0x1B,
            Self::Gain => 0x1C,
            Self::Ref => 0x1D,
        }
    }

    /// The bit of this channel in [`Config::channel_mask`](crate::Config::channel_mask).
    pub(crate) const fn bit(self) -> u32 {
        1_u32.wrapping_shl(self.id() as u32)
    }

    /// The channel with a CHID; `None` for 0x19 and everything above 0x1D.
    #[inline]
    pub const fn from_id(id: u8) -> Option<Self> {
        match id {
            0x00..=0x07 => Some(Self::Differential(id)),
            0x08..=0x17 => Some(Self::Single(id.wrapping_sub(8))),
            0x18 => Some(Self::Offset),
            0x1A => Some(Self::Vcc),
            0x1B => Some(Self::Temp),
            0x1C => Some(Self::Gain),
            0x1D => Some(Self::Ref),
            _ => None,
        }
    }
}

/// The datasheet's names: `DIFF0`, `AIN15`, `OFFSET`, ...
impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Differential(number) => write!(f, "DIFF{number}"),
            Self::Single(number) => write!(f, "AIN{number}"),
            Self::Offset => f.write_str("OFFSET"),
            Self::Vcc => f.write_str("VCC"),
            Self::Temp => f.write_str("TEMP"),
            Self::Gain => f.write_str("GAIN"),
            Self::Ref => f.write_str("REF"),
        }
    }
}
