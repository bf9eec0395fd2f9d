//! The internal readings of the auto-scan.

/// SYSRED: `0 0 REF GAIN TEMP VCC 0 OFFSET`, the internal readings in the auto-scan. The default is the reset value 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sysred {
    /// REF: the reference voltage. (`ref` is a keyword.)
    pub reference: bool,
    /// GAIN: the converter's gain.
    pub gain: bool,
    /// TEMP: the temperature of the die.
    pub temp: bool,
    /// VCC: the analogue supply voltage.
    pub vcc: bool,
    /// OFFSET: the converter's offset.
    pub offset: bool,
}

impl Sysred {
    /// No internal reading.
    pub const NONE: Self = Self { reference: false, gain: false, temp: false, vcc: false, offset: false };

    /// All five internal readings.
    pub const ALL: Self = Self { reference: true, gain: true, temp: true, vcc: true, offset: true };

    /// The byte for the register. Its bits follow the order of the channel ids from OFFSET, 0x18, on.
    #[must_use]
    pub const fn to_bits(self) -> u8 {
        (self.reference as u8) << 5
            | (self.gain as u8) << 4
            | (self.temp as u8) << 3
            | (self.vcc as u8) << 2
            | self.offset as u8
    }

    /// Whether a reading is selected that CHOP excludes: REF, GAIN, TEMP or VCC.
    pub(crate) const fn excludes_chop(self) -> bool {
        self.reference || self.gain || self.temp || self.vcc
    }
}
