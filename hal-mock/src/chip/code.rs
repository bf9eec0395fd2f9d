//! Converts physical values to the 24-bit code and its flags.

use super::options::Analog;
use super::slot::{GAIN, OFFSET, REF, SINGLE, Slot, TEMP, VCC};

/// Code of +VREF: 1 LSB = VREF / 780000h.
pub(crate) const VREF_CODE: f64 = 7_864_320.0;
/// Code of one volt in the VCC and REF readings.
const SYSTEM_CODE_PER_VOLT: f64 = 786_432.0;
const MAX_CODE: f64 = 8_388_607.0;
const MIN_CODE: f64 = -8_388_608.0;
/// Fraction of VREF beyond which OVF is set.
const OVERFLOW: f64 = 1.06;
/// TEMP reading in microvolts at 25 degrees Celsius.
const TEMP_UV_AT_25_C: f64 = 168_000.0;

/// Ideal code of a slot, neither rounded nor clipped. `input` returns an external input's volts.
pub(crate) fn ideal(
    slot: Slot,
    analog: &Analog,
    chop: bool,
    mut input: impl FnMut(u8) -> f64,
) -> f64 {
    let per_volt = VREF_CODE / analog.reference_v;
    let offset = if chop {
        0.0
    } else {
        analog.offset_v * per_volt
    };
    let volts = match slot {
        Slot::Fixed { ainp, ainn } => input(ainp) - input(ainn),
        Slot::Scanned(pair) if pair < SINGLE => input(2 * pair) - input(2 * pair + 1),
        Slot::Scanned(single) if single < OFFSET => input(single - SINGLE) - analog.aincom_v,
        Slot::Scanned(GAIN) => analog.reference_v,
        Slot::Scanned(VCC) => return analog.avdd_v * SYSTEM_CODE_PER_VOLT,
        Slot::Scanned(REF) => return analog.reference_v * SYSTEM_CODE_PER_VOLT,
        Slot::Scanned(TEMP) => {
            let uv = TEMP_UV_AT_25_C + analog.temperature_uv_per_c * (analog.temperature_c - 25.0);
            return uv * 1e-6 * per_volt;
        }
        // OFFSET.
        Slot::Scanned(_) => 0.0,
    };
    volts * analog.gain * per_volt + offset
}

/// Standard deviation of the noise in codes, from the datasheet for each data rate.
pub(crate) fn noise_sigma(drate: u8, chop: bool, analog: &Analog) -> f64 {
    const UV_RMS: [f64; 4] = [2.8, 4.5, 7.9, 12.0];
    let uv = UV_RMS[usize::from(drate & 3)] / if chop { 1.4 } else { 1.0 };
    uv * 1e-6 / analog.reference_v * VREF_CODE
}

/// Rounds to the nearest code and clips; the flag is OVF.
pub(crate) fn quantise(code: f64) -> (i32, bool) {
    (
        code.round_ties_even().clamp(MIN_CODE, MAX_CODE) as i32,
        code.abs() > OVERFLOW * VREF_CODE,
    )
}
