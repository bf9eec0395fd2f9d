//! What the paper did, and what it found.

use std::ops::RangeInclusive;

/// The scales, mm; a ridge is half as wide (section III-B). Figures 8 and 9 begin at 0.5 mm, Figure
/// 11 at 0.8.
pub const WAVELENGTHS_MM: [f64; 10] = [0.5, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0];
/// The mean of a hand's speed, and two standard deviations to each side, mm/s (section IV-A).
pub const SPEEDS_MM_S: [f64; 3] = [73.5, 125.4, 177.4];
/// Width of the ridges of its sensor's skin, mm (section III-B). It does not say how wide the
/// grooves between them are.
pub const SKIN_RIDGE_MM: f64 = 0.6;
/// Length of a scan, mm (section IV-A).
pub const SCAN_MM: f64 = 175.0;
/// Its window, the best of four by its own search, and the longest of these, seconds.
pub const WINDOW_S: f64 = 0.032;
pub const LONGEST_S: f64 = 0.128;
/// The accuracy that the longer window is chosen by, as a share of the wavelength.
pub const ACCURACY: f32 = 0.005;
/// Fewest cycles in a window that is judged: fewer may be a single bump.
pub const CYCLES: f64 = 1.5;
/// Powers of Figure 11, in its unit, as its equation 2 has them.
pub const POLYNOMIAL: [f64; 5] = [72_298.0, -248_938.0, 309_743.0, -162_663.0, 30_770.0];

/// Wavelengths that it was fitted over, and its coefficient of determination.
pub const FITTED_MM: RangeInclusive<f64> = 0.8..=2.0;
pub const R2: f64 = 0.94;
