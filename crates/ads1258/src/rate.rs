//! Duration of conversions.
//!
//! With N = 4^(3 - DRATE) and the delay TD = 0, 1, 2, 4, 8, 16, 32, 48 for DLY 0 to 7:
//!
//! - auto-scan: fCLK / (128 (N + 4.265625 + TD) 2^CHOP) conversions/s
//! - fixed channel: fCLK / (128 (N + CHOP (4.265625 + TD)) 2^CHOP) conversions/s
//!
//! 128 x 4.265625 = 546 exactly, so every conversion takes a whole number of clock periods. Rates
//! are divided once at the end: in `f32` they are correctly rounded.
//!
//! Source: SBAS297G, data rate equations and tables; a test of this crate reproduces every entry of
//! the rate table.

use crate::{DataRate, Delay};

/// Clock periods per unit of N and TD (SBAS297G, data rate equations).
const TICKS_PER_UNIT: u32 = 128;

/// Clock periods of multiplexer and filter around each conversion, 128 x 4.265625 (SBAS297G, data
/// rate equations).
const TICKS_OVERHEAD: u32 = 546;

/// Clock periods (tCLK) per conversion: 674 to 29764 in auto-scan, 128 to 29764 on a fixed channel.
pub(crate) const fn ticks(is_fixed: bool, data_rate: DataRate, delay: Delay, chop: bool) -> u32 {
    let converting = TICKS_PER_UNIT.saturating_mul(data_rate.averages());
    if is_fixed && !chop {
        return converting;
    }
    let settling = TICKS_OVERHEAD.saturating_add(TICKS_PER_UNIT.saturating_mul(delay.td()));
    // A chopped conversion consists of two.
    converting
        .saturating_add(settling)
        .saturating_mul(if chop { 2 } else { 1 })
}

/// Repetitions per second of something that takes `ticks` clock periods, in Hz; 0 if `ticks` is 0.
pub(crate) const fn per_second(clock_hz: u32, ticks: u32) -> f32 {
    // Both are below 2^24 for this chip, so both are exact in f32.
    if ticks == 0 {
        0.0
    } else {
        clock_hz as f32 / ticks as f32
    }
}
