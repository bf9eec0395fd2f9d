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
    /// Slope of the temperature sensor in uV per degree, default 394; use 563 if board and chip
    /// have the same temperature.
    pub temperature_uv_per_c: f64,
    /// Offset error in volts, default 0. Chopping removes it.
    pub offset_v: f64,
    /// Gain, default 1: the value that the GAIN reading shows.
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

/// Options at construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Nominal clock in hertz, default 15,728,640 (32.768 kHz crystal x 480); the chip allows up to
    /// 16,000,000. 0 means no clock yet: see `Ads1258::set_clock`.
    pub clock_hz: u32,
    /// Error of the clock in parts per million; positive is fast. Default 0.
    pub clock_error_ppm: f64,
    /// Physical values; see also `Ads1258::analog_mut`.
    pub analog: Analog,
    /// True if the Gaussian noise of the data rate is added (12, 7.9, 4.5 or 2.8 uVrms for DRATE 3
    /// to 0, / 1.4 with CHOP). Default true.
    pub noise: bool,
    /// Seed of noise and poison, default 1.
    pub seed: u64,
    /// Poison: the byte that DOUT carries where the datasheet leaves it undefined; `None`, the
    /// default, for seeded random bytes.
    pub poison: Option<u8>,
    /// The ID register, default 8Bh. Only bit 4 (0 = ADS1258) is guaranteed by the datasheet.
    pub id: u8,
    /// CHID in the status byte in fixed-channel mode, which the datasheet does not specify; `None`,
    /// the default, for poison.
    pub fixed_channel_chid: Option<u8>,
    /// True if the scan skips the readings that CHOP excludes; if false, the default, it converts
    /// them to poison. Not specified.
    pub chop_skips_internal: bool,
    /// True if the first conversion after START also contains the switching delay DLY; not
    /// specified. Default false.
    pub first_conversion_with_delay: bool,
    /// Delay of the first result after sleep (IDLMOD = 1), clock cycles. Not in the datasheet;
    /// default 0.
    pub sleep_wake_cycles: u64,
    /// True if the interface's time-out counts from the frame's start even while SCLK runs, as
    /// users report (TI's forum, 1213439); false, the default, if it counts from the previous byte.
    /// Not specified.
    pub timeout_from_frame_start: bool,
    /// Faults to inject, by scene time. Default none.
    pub injections: Vec<Injection>,
    /// Clock cycles after construction or after the first clock during which the chip does not
    /// answer. Default 0; the datasheet specifies 2^18 (16.4 ms) after power-up.
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
    /// Results overwritten by the next one before they were read.
    pub lost: u64,
    /// Register bytes written over SPI.
    pub register_writes: u64,
    /// Command bytes that the datasheet does not define or that had no effect: reserved, read by
    /// command without MUL, pulse convert while converting, a direct read or padding after another
    /// command.
    pub odd_commands: u64,
}
