//! Widths of memory accesses.

/// Width of a load or store, and how a load extends the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    Byte,
    SignedByte,
    Half,
    SignedHalf,
    Word,
}

impl Width {
    pub const fn bytes(self) -> u32 {
        match self {
            Self::Byte | Self::SignedByte => 1,
            Self::Half | Self::SignedHalf => 2,
            Self::Word => 4,
        }
    }

    /// Extends the lowest bits of a word to a whole word.
    pub const fn extend(self, value: u32) -> u32 {
        match self {
            Self::Byte => value & 0xFF,
            Self::SignedByte => value as u8 as i8 as u32,
            Self::Half => value & 0xFFFF,
            Self::SignedHalf => value as u16 as i16 as u32,
            Self::Word => value,
        }
    }
}
