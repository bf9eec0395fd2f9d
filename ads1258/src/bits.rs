//! CONFIG0, CONFIG1 and SYSRED bit by bit, with the fields named as in the datasheet's register map (SBAS297G).
//!
//! The other registers are plain masks and need no type.

use crate::{DataRate, Delay, IdleMode, SensorBias};

/// CONFIG0: `0 SPIRST MUXMOD BYPAS CLKENB CHOP STAT 0`. The default is the reset value 0x0A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config0 {
    /// The SPI port resets itself when SCLK rests for 256 tCLK (set) or 4096 tCLK (clear).
    pub spirst: bool,
    /// Fixed channel (set) or auto-scan (clear).
    pub muxmod: bool,
    /// The converter is connected to the pins ADCIN (set) or to the multiplexer (clear).
    pub bypas: bool,
    /// CLKIO puts out the clock when the crystal is in use.
    pub clkenb: bool,
    /// Chopping: every conversion is the mean of two with the inputs swapped.
    pub chop: bool,
    /// The status byte precedes the data of a direct read, too.
    pub stat: bool,
}

impl Config0 {
    /// The byte for the register.
    #[must_use]
    pub const fn to_bits(self) -> u8 {
        (self.spirst as u8) << 6
            | (self.muxmod as u8) << 5
            | (self.bypas as u8) << 4
            | (self.clkenb as u8) << 3
            | (self.chop as u8) << 2
            | (self.stat as u8) << 1
    }

    /// From the register, `None` if bit 7 or 0 is set: both must be 0.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Option<Self> {
        if bits & 0x81 != 0 {
            return None;
        }
        Some(Self {
            spirst: bits & 0x40 != 0,
            muxmod: bits & 0x20 != 0,
            bypas: bits & 0x10 != 0,
            clkenb: bits & 0x08 != 0,
            chop: bits & 0x04 != 0,
            stat: bits & 0x02 != 0,
        })
    }
}

impl Default for Config0 {
    fn default() -> Self {
        Self { spirst: false, muxmod: false, bypas: false, clkenb: true, chop: false, stat: true }
    }
}

/// CONFIG1: `IDLMOD DLY[2:0] SBCS[1:0] DRATE[1:0]`. The default is the reset value 0x83.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config1 {
    /// What the chip does when START is low.
    pub idlmod: IdleMode,
    /// Time between switching the multiplexer and converting.
    pub dly: Delay,
    /// Sensor bias current.
    pub sbcs: SensorBias,
    /// Data rate.
    pub drate: DataRate,
}

impl Config1 {
    /// The byte for the register.
    #[must_use]
    pub const fn to_bits(self) -> u8 {
        (self.idlmod as u8) << 7 | (self.dly as u8) << 4 | (self.sbcs as u8) << 2 | self.drate as u8
    }

    /// From the register, `None` if SBCS has the undefined value 10.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Option<Self> {
        let Some(sbcs) = SensorBias::from_bits(bits >> 2) else { return None };
        Some(Self {
            idlmod: if bits & 0x80 == 0 { IdleMode::Standby } else { IdleMode::Sleep },
            dly: Delay::from_bits(bits >> 4),
            sbcs,
            drate: DataRate::from_bits(bits),
        })
    }
}

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

    /// From the register, `None` if bit 7, 6 or 1 is set: they must be 0.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Option<Self> {
        if bits & 0xC2 != 0 {
            return None;
        }
        Some(Self {
            reference: bits & 0x20 != 0,
            gain: bits & 0x10 != 0,
            temp: bits & 0x08 != 0,
            vcc: bits & 0x04 != 0,
            offset: bits & 0x01 != 0,
        })
    }

    /// Whether one of those readings is selected that CHOP excludes: REF, GAIN, TEMP or VCC.
    #[must_use]
    pub const fn excludes_chop(self) -> bool {
        self.reference || self.gain || self.temp || self.vcc
    }
}
