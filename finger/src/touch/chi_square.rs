//! Squared distances in units of the noise. Noise alone makes them a chi-square with a degree of freedom for each taxel.

use ridgetone_proto::scan::INPUTS;
use ridgetone_tone::Values;

/// Squared distance of two levels, each taxel's times its weight.
#[inline]
pub fn distance(weights: &Values, a: &Values, b: &Values) -> f32 {
    weights.iter().zip(a.iter().zip(b)).fold(0.0, |sum, (weight, (a, b))| sum + (a - b) * (a - b) * weight)
}

/// Limit for a sum over the taxels of this scan: so much for each taxel, and a margin. The margin is given for sixteen
/// taxels; it grows with the root of their number, as the standard deviation of the sum does.
pub const fn limit(for_each: f32, margin_of_16: f32) -> f32 {
    limit_of(INPUTS, for_each, margin_of_16)
}

const fn limit_of(taxels: usize, for_each: f32, margin_of_16: f32) -> f32 {
    let share = taxels as f32 / 16.0;
    // Newton's method: there is no root in a constant.
    let (mut root, mut step) = (1.0, 0);
    while step < 8 {
        root = 0.5 * (root + share / root);
        step += 1;
    }
    for_each * taxels as f32 + margin_of_16 * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_follow_the_number_of_taxels() {
        assert_eq!(limit_of(16, 1.0, 45.0), 61.0);
        assert_eq!(limit_of(4, 1.0, 45.0), 26.5);
        assert!((limit_of(1, 1.0, 45.0) - 12.25).abs() < 1e-4);
    }
}
