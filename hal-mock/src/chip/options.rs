//! Options of the simulated chip: its clock, its surroundings, and its behaviour where the
//! datasheet leaves it open.

use super::schedule::Injection;

/// Physical values around and inside the chip; may be changed while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Analog {
    /// Reference voltage VREFP - VREFN in volts, default 4.096.
    pub reference_v: f64,
    /// Analogue supply AVDD - AVSS in volts, default 5.0. Below 4.3 V the SUPPLY flag is set and
    /// all data are invalid.
    pub avdd_v: f64,
    /// Voltage on AINCOM in volts, default 0: single-ended inputs are measured against it.
    pub aincom_v: f64,
    /// Temperature of the chip in degrees Celsius, default 25.
    pub temperature_c: f64,
    /// Slope of the temperature sensor in uV per degree, default 394; 563 where board and chip
    /// share one temperature.
    pub temperature_uv_per_c: f64,
    /// Offset error in volts, default 0. Chopping removes it.
    pub offset_v: f64,
    /// Gain, default 1: what the GAIN reading shows.
    pub gain: f64,
}

impl Default for Analog {
    fn default() -> Self {
        Self {
            reference_v: 4.096,
            avdd_v: 5.0,
            aincom_v: 0.0,
            temperature_c: 25.0,
            temperature_uv_per_c: 394.0,
            offset_v: 0.0,
            gain: 1.0,
        }
    }
}

/// Choices at construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Nominal clock in hertz, default 15,728,640 (32.768 kHz crystal x 480); the chip allows up to
    /// 16,000,000. 0: none yet, see `Ads1258::set_clock`.
    pub clock_hz: u32,
    /// Error of the clock in parts per million; positive is fast. Default 0.
    pub clock_error_ppm: f64,
    /// Physical values; see also `Ads1258::analog_mut`.
    pub analog: Analog,
    /// Gaussian noise of the data rate (12, 7.9, 4.5 or 2.8 uVrms for DRATE 3 to 0, / 1.4 with
    /// CHOP). Default on.
    pub noise: bool,
    /// Seed of noise and poison, default 1.
    pub seed: u64,
    /// The byte that DOUT carries where the datasheet leaves it undefined. `None`, the default:
    /// seeded random bytes.
    pub poison: Option<u8>,
    /// The ID register, default 8Bh. Only bit 4 (0 = ADS1258) is guaranteed by the datasheet.
    pub id: u8,
    /// CHID in the status byte in fixed-channel mode. `None`, the default: poison, as it is not
    /// specified.
    pub fixed_channel_chid: Option<u8>,
    /// True if the scan skips the readings that CHOP excludes or, the default, converts them to
    /// poison; not specified.
    pub chop_skips_internal: bool,
    /// True if the first conversion after START contains the switching delay DLY too; not
    /// specified. Default no.
    pub first_conversion_with_delay: bool,
    /// Clock cycles by which the first result after sleep (IDLMOD = 1) is later. Not in the
    /// sources; default 0.
    pub sleep_wake_cycles: u64,
    /// True if the interface's time-out counts from the frame's start though SCLK runs, as some
    /// have met it (TI's forum, 1213439), or from the byte before; not specified. Default no.
    pub timeout_from_frame_start: bool,
    /// Faults to inject while it runs, by scene time. Default none.
    pub injections: Vec<Injection>,
    /// Clock cycles without answers after construction, or after the first clock. Default 0; 2^18
    /// (16.4 ms) after power-up in the datasheet.
    pub power_up_cycles: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            clock_hz: 15_728_640,
            clock_error_ppm: 0.0,
            analog: Analog::default(),
            noise: true,
            seed: 1,
            poison: None,
            id: 0x8B,
            fixed_channel_chid: None,
            chop_skips_internal: false,
            first_conversion_with_delay: false,
            sleep_wake_cycles: 0,
            timeout_from_frame_start: false,
            injections: Vec::new(),
            power_up_cycles: 0,
        }
    }
}

/// Counts of what the chip has done so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counters {
    /// Conversions finished.
    pub conversions: u64,
    /// Results that were read at least once.
    pub read: u64,
    /// Results that the next one overwrote unread.
    pub lost: u64,
    /// Register bytes written over SPI.
    pub register_writes: u64,
    /// Command bytes that the datasheet does not define or that had no effect: reserved, read by
    /// command without MUL, pulse convert while converting, a direct read or padding behind another
    /// command.
    pub odd_commands: u64,
}
