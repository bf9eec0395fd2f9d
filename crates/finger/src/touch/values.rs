//! Arithmetic with the values of a frame. The sums are not inlined: unrolled at every call they
//! would take kilobytes.

use crate::touch::chi_square::along;
use core::hint::black_box;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Adds other values.
pub fn add(to: &mut Values, values: &Values) {
    to.iter_mut()
        .zip(values)
        .for_each(|(to, value)| *to += value);
}

/// Adds `times` times other values.
pub fn add_times(to: &mut Values, times: f32, values: &Values) {
    to.iter_mut()
        .zip(values)
        .for_each(|(to, value)| *to += times * value);
}

/// Multiplies all by one number.
pub fn scale(values: &mut Values, by: f32) {
    // The compiler must not know the number of values: it would unroll the loop, which takes five
    // times the flash.
    values
        .iter_mut()
        .take(black_box(TAXELS))
        .for_each(|value| *value *= by);
}

/// Difference of values.
pub fn difference(values: &Values, less: &Values) -> Values {
    core::array::from_fn(|c| values[c] - less[c])
}

/// Length of a vector of values.
pub fn length(values: &Values) -> f32 {
    ridgetone_tone::sqrt(along(values, &[0.0; TAXELS], values))
}

/// `f32::max` is a function call on the chip, because it heeds NaN.
pub const fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// See [`greater`].
pub const fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
