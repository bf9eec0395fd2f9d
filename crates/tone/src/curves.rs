//! What a baseline may be beside a straight line: relaxations.
//!
//! A skin that relaxes is a sum of exponentials. Those of time constants from a ninth of half a
//! window on are sums of these three and of a line, but for a part of 300. Along a path the
//! baseline is straight: time bends it, and not the place.

use crate::limits::CURVES_MAX;

/// Half the window over the time constants.
const RATES: [f32; CURVES_MAX] = [1.0, 3.0, 9.0];

/// The functions at a place `u`, and their slopes there. Each is exp(-rate (u + 1)), less the line
/// that it resembles most.
#[inline(never)]
pub fn curves(u: f32) -> [[f32; 2]; CURVES_MAX] {
    // Line by least squares over -1 to 1: sinh(r) / r exp(-r), and 3 (sinh(r) / r - cosh(r)) / r
    // exp(-r).
    const LINES: [[f32; 2]; CURVES_MAX] = [
        [0.432_332_36, -0.406_005_85],
        [0.166_253_54, -0.334_985_83],
        [0.055_555_555, -0.148_148_15],
    ];
    let mut out = [[0.0; 2]; CURVES_MAX];
    for ((out, rate), [level, slope]) in out.iter_mut().zip(RATES).zip(LINES) {
        let value = libm::expf(-rate * (u + 1.0));
        *out = [value - level - slope * u, -rate * value - slope];
    }
    out
}
