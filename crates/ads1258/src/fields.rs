//! The values of CONFIG1's bit fields, and SYSRED. Each `Default` is the value after a reset.

/// DRATE\[1:0\]: averaging of the filter, a trade-off between speed and noise.
///
/// The rates listed are from the datasheet's table for 16 MHz, DLY 0 and CHOP 0;
/// [`Config::conversion_rate_hz`](crate::Config::conversion_rate_hz) computes all others. Source:
/// SBAS297G, CONFIG1 register and rate and noise tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum DataRate {
    /// 1831 SPS scanning, 1953 SPS fixed, -3 dB at 869 Hz, 2.8 uVrms.
    Drate0 = 0,
    /// 6168 SPS scanning, 7812.5 SPS fixed, -3 dB at 3418 Hz, 4.5 uVrms.
    Drate1 = 1,
    /// 15123 SPS scanning, 31250 SPS fixed, -3 dB at 12402 Hz, 7.9 uVrms.
    Drate2 = 2,
    /// 23739 SPS scanning, 125000 SPS fixed, -3 dB at 25390 Hz, 12 uVrms. The reset value.
    #[default]
    Drate3 = 3,
}

impl DataRate {
    /// All data rates in the order of their bits.
    pub const ALL: [Self; 4] = [Self::Drate0, Self::Drate1, Self::Drate2, Self::Drate3];

    /// N of the rate formula, 4^(3 - DRATE), in units of 128 tCLK: 64, 16, 4, 1.
    pub(crate) const fn averages(self) -> u32 {
        match self {
            Self::Drate0 => 64,
            Self::Drate1 => 16,
            Self::Drate2 => 4,
            Self::Drate3 => 1,
        }
    }
}

/// DLY\[2:0\]: the time between switching the multiplexer and converting (SBAS297G, CONFIG1
/// register, switch time delay).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Delay {
    /// No delay. The reset value.
    #[default]
    Dly0 = 0,
    /// 128 tCLK (8 us at 16 MHz).
    Dly1 = 1,
    /// 256 tCLK (16 us at 16 MHz).
    Dly2 = 2,
    /// 512 tCLK (32 us at 16 MHz).
    Dly3 = 3,
    /// 1024 tCLK (64 us at 16 MHz).
    Dly4 = 4,
    /// 2048 tCLK (128 us at 16 MHz).
    Dly5 = 5,
    /// 4096 tCLK (256 us at 16 MHz).
    Dly6 = 6,
    /// 6144 tCLK (384 us at 16 MHz).
    Dly7 = 7,
}

impl Delay {
    /// All delays in the order of their bits.
    pub const ALL: [Self; 8] = [
        Self::Dly0,
        Self::Dly1,
        Self::Dly2,
        Self::Dly3,
        Self::Dly4,
        Self::Dly5,
        Self::Dly6,
        Self::Dly7,
    ];

    /// TD of the rate formula in units of 128 tCLK: 0, 1, 2, 4, 8, 16, 32, 48.
    pub(crate) const fn td(self) -> u32 {
        match self {
            Self::Dly0 => 0,
            Self::Dly1 => 1,
            Self::Dly2 => 2,
            Self::Dly3 => 4,
            Self::Dly4 => 8,
            Self::Dly5 => 16,
            Self::Dly6 => 32,
            Self::Dly7 => 48,
        }
    }
}

/// IDLMOD: state of the chip while START is low (SBAS297G, CONFIG1 register).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum IdleMode {
    /// Ready at once, at more supply current.
    Standby = 0,
    /// Less supply current, longer until the first conversion. The reset value.
    #[default]
    Sleep = 1,
}

/// SBCS\[1:0\]: a current through the inputs that reveals a broken wire or sensor (SBAS297G,
/// CONFIG1 register).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum SensorBias {
    /// No current. The reset value.
    #[default]
    Off = 0b00,
    /// 1.5 uA nominal.
    MicroAmps1_5 = 0b01,
    /// 24 uA nominal.
    MicroAmps24 = 0b11,
}

/// SYSRED: `0 0 REF GAIN TEMP VCC 0 OFFSET`, the internal readings in the auto-scan. The default is
/// the reset value 0.
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
    pub const NONE: Self = Self {
        reference: false,
        gain: false,
        temp: false,
        vcc: false,
        offset: false,
    };

    /// All five internal readings.
    pub const ALL: Self = Self {
        reference: true,
        gain: true,
        temp: true,
        vcc: true,
        offset: true,
    };

    /// The register's byte. Its bits follow the order of the channel ids from OFFSET, 0x18.
    pub const fn to_bits(self) -> u8 {
        (self.reference as u8) << 5
            | (self.gain as u8) << 4
            | (self.temp as u8) << 3
            | (self.vcc as u8) << 2
            | self.offset as u8
    }
}
