//! A touch as conversions, without a chip: idle, contact, hold, a slide of two seconds, hold,
//! release.

use ads1258::{Conversion, Status};
use ridgetone_finger::converter::SCAN;
use ridgetone_finger::{CONVERSION_NS, SLOTS, TimedConversion};
use std::f64::consts::TAU;

/// Number of scans in a touch; the slide lasts from 0.8 s to 2.8 s.
pub const SCANS: u64 = 820;

pub const TONE_HZ: f64 = 8.3;

/// The chip's internal readings (SBAS297G): offset 0, supply 5 V, 25 degrees, gain 1, reference
/// 4.096 V.
const OWN: [i32; 5] = [0, 3_932_160, 322_560, 7_864_320, 3_221_225];

/// Returns scan `scan` of the touch, with the times of scan `number` on a wrapping counter that
/// starts at `start_us`.
pub fn scan(
    scan: u64,
    number: u64,
    start_us: u32,
) -> impl Iterator<Item = TimedConversion> + Clone {
    let ids = (0..32u8).filter(|id| SCAN.channel_mask() & 1 << id != 0);
    ids.zip(0u64..).map(move |(id, slot)| {
        let ns = |scan: u64| (scan * SLOTS as u64 + slot) * CONVERSION_NS;
        // New data from this channel.
        let status = Status(0x80 | id);
        let code = if slot < 16 {
            code(slot, ns(scan) as f64 * 1e-9)
        } else {
            OWN[slot as usize - 16]
        };
        let t_us = start_us.wrapping_add((ns(number) / 1000) as u32);
        TimedConversion::new(t_us, Conversion { status, code })
    })
}

fn code(taxel: u64, t_s: f64) -> i32 {
    let sign = if taxel.is_multiple_of(2) { 1.0 } else { -1.0 };
    let load = if (0.3..3.1).contains(&t_s) {
        50_000.0 + 30_000.0 * (-(t_s - 0.3) / 0.03).exp()
    } else {
        0.0
    };
    let slid_s = (t_s - 0.8).clamp(0.0, 2.0);
    let tone = if load > 0.0 {
        5000.0 * (TAU * TONE_HZ * slid_s + taxel as f64).sin()
    } else {
        0.0
    };
    // Hashed noise: the same in every run, without generator state.
    let hash = mixed((t_s * 1e9) as u64 ^ taxel << 56);
    let noise = ((hash >> 40) as f64 / (1u64 << 24) as f64 - 0.5) * 200.0;
    (4e6 + sign * (load + tone) + noise).round() as i32
}

/// Output function of SplitMix64. A multiplication alone would map evenly spaced times to a line.
fn mixed(state: u64) -> u64 {
    let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
