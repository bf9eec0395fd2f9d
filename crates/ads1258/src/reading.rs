//! Converts codes to volts and degrees.
//!
//! Source of the scales: SBAS297G, data format and internal readings. All have the form code x
//! constant.
//!
//! # Rounding
//!
//! A 24-bit code is exact in `f32`, but the volts are rounded to a relative error within 6e-8, near
//! full scale about half an LSB. So compute a small difference of two large readings, or a sum of
//! many, in integers: see [`volts_above`].

/// Code at an input of VREF, 7864320. One LSB is VREF divided by this (SBAS297G, data format).
pub const CODES_PER_VREF: i32 = 0x78_0000;

/// Codes per volt in the VCC and REF readings, for any VREF (SBAS297G, internal readings).
pub const CODES_PER_SUPPLY_VOLT: i32 = 786_432;

/// Output of the temperature sensor at 25 C in uV (SBAS297G, temperature reading).
pub const TEMP_AT_25_C_UV: f32 = 168_000.0;

/// Slope in uV per degree if only the chip changes its temperature (SBAS297G, temperature reading).
pub const TEMP_SLOPE_UV_PER_C: f32 = 394.0;

/// Slope in uV per degree if board and chip have the same temperature (SBAS297G, temperature
/// reading).
pub const TEMP_SLOPE_BOARD_UV_PER_C: f32 = 563.0;

/// Input voltage in V. `vref_v` is the reference voltage in V.
///
/// ```
/// assert_eq!(ads1258::reading::volts(-0x3C_0000, 5.0), -2.5);
/// ```
pub const fn volts(code: i32, vref_v: f32) -> f32 {
    code as f32 * (vref_v / CODES_PER_VREF as f32)
}

/// Input voltage in V above that of `base_code`, such as the OFFSET reading or a sensor at rest:
/// subtracted in codes, so that rounding loses nothing. `vref_v` is the reference voltage in V.
pub const fn volts_above(code: i32, base_code: i32, vref_v: f32) -> f32 {
    volts(code.saturating_sub(base_code), vref_v)
}

/// Supply voltage in V (AVDD - AVSS) from the VCC reading: code / 786432.
pub const fn supply_v(code: i32) -> f32 {
    code as f32 / CODES_PER_SUPPLY_VOLT as f32
}

/// Reference voltage in V from the REF reading: code / 786432.
pub const fn reference_v(code: i32) -> f32 {
    code as f32 / CODES_PER_SUPPLY_VOLT as f32
}

/// The converter's gain from the GAIN reading, ideally 1: code / 7864320.
pub const fn gain(code: i32) -> f32 {
    code as f32 / CODES_PER_VREF as f32
}

/// The converter's offset in V from the OFFSET reading, ideally 0. `vref_v` is the reference
/// voltage in V.
pub const fn offset_v(code: i32, vref_v: f32) -> f32 {
    volts(code, vref_v)
}

/// Temperature in C from the TEMP reading, at 394 uV/C: (uV - 168000) / 394 + 25.
///
/// Use this if the chip is warmer or colder than its board. `vref_v` is the reference voltage in V.
/// The rounding error stays below 0.001 C, far below the sensor's accuracy.
pub const fn temperature_c(code: i32, vref_v: f32) -> f32 {
    temperature_at_slope_c(code, vref_v, TEMP_SLOPE_UV_PER_C)
}

/// Temperature in C like [`temperature_c`], at 563 uV/C: for board and chip at the same
/// temperature.
pub const fn temperature_board_c(code: i32, vref_v: f32) -> f32 {
    temperature_at_slope_c(code, vref_v, TEMP_SLOPE_BOARD_UV_PER_C)
}

const fn temperature_at_slope_c(code: i32, vref_v: f32, slope_uv_per_c: f32) -> f32 {
    (volts(code, vref_v) * 1e6 - TEMP_AT_25_C_UV) / slope_uv_per_c + 25.0
}
