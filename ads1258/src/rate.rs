//! How fast the chip converts.
//!
//! With N = 4^(3 - DRATE) and the delay TD = 0, 1, 2, 4, 8, 16, 32, 48 for DLY 0 to 7:
//!
//! - auto-scan: fCLK / (128 (N + 4.265625 + TD) 2^CHOP) conversions/s
//! - fixed channel: fCLK / (128 (N + CHOP (4.265625 + TD)) 2^CHOP) conversions/s
//!
//! 128 x 4.265625 = 546 exactly, so every conversion takes a whole number of clock periods. The functions count in
//! those (`ticks` of tCLK) and divide once at the end: the rates in `f32` are correctly rounded.
//!
//! Source: SBAS297G, data rate equations and tables; a test of this crate reproduces every entry of the rate table.

use crate::{DataRate, Delay};

/// Clock periods per unit of N and TD (SBAS297G, data rate equations).
const TICKS_PER_UNIT: u32 = 128;

/// Clock periods of the multiplexer and the filter around each conversion in auto-scan, 128 x 4.265625 (SBAS297G, data
/// rate equations).
const TICKS_OVERHEAD: u32 = 546;

/// Clock periods (tCLK) per conversion in auto-scan: 674 to 29764.
#[must_use]
pub const fn auto_scan_ticks(data_rate: DataRate, delay: Delay, chop: bool) -> u32 {
    chopped(converting(data_rate).saturating_add(settling(delay)), chop)
}

/// Clock periods (tCLK) per conversion on a fixed channel: 128 to 29764. The delay counts with `chop` only.
#[must_use]
pub const fn fixed_channel_ticks(data_rate: DataRate, delay: Delay, chop: bool) -> u32 {
    let settling = if chop { settling(delay) } else { 0 };
    chopped(converting(data_rate).saturating_add(settling), chop)
}

/// Conversions per second in auto-scan, in Hz, over all channels together.
///
/// `clock_hz` is fCLK in Hz; the result is correctly rounded up to the chip's 16 MHz.
///
/// ```
/// use ads1258::{DataRate, Delay, rate};
/// const RATE_HZ: f32 = rate::auto_scan_hz(16_000_000, DataRate::Drate3, Delay::Dly0, false);
/// assert_eq!(RATE_HZ.round(), 23739.0);
/// ```
#[must_use]
pub const fn auto_scan_hz(clock_hz: u32, data_rate: DataRate, delay: Delay, chop: bool) -> f32 {
    per_second(clock_hz, auto_scan_ticks(data_rate, delay, chop))
}

/// Conversions per second on a fixed channel, in Hz.
///
/// `clock_hz` is fCLK in Hz; the result is correctly rounded up to the chip's 16 MHz.
#[must_use]
pub const fn fixed_channel_hz(clock_hz: u32, data_rate: DataRate, delay: Delay, chop: bool) -> f32 {
    per_second(clock_hz, fixed_channel_ticks(data_rate, delay, chop))
}

/// How often per second something happens that takes `ticks` clock periods, in Hz; 0 if it takes none.
#[must_use]
pub(crate) const fn per_second(clock_hz: u32, ticks: u32) -> f32 {
    // Both are below 2^24 for this chip, so both are exact in f32.
    if ticks == 0 { 0.0 } else { clock_hz as f32 / ticks as f32 }
}

const fn converting(data_rate: DataRate) -> u32 {
    TICKS_PER_UNIT.saturating_mul(data_rate.averages())
}

const fn settling(delay: Delay) -> u32 {
    TICKS_OVERHEAD.saturating_add(TICKS_PER_UNIT.saturating_mul(delay.td()))
}

/// A chopped conversion is made of two.
const fn chopped(ticks: u32, chop: bool) -> u32 {
    if chop { ticks.saturating_mul(2) } else { ticks }
}
