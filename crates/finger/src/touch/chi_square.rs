//! Squared distances in units of the noise. Noise alone makes them a chi-square with a degree of
//! freedom for each taxel.

use ridgetone_tone::Values;

/// Squared distance of two levels, each taxel's times its weight.
pub fn distance(weights: &Values, a: &Values, b: &Values) -> f32 {
    // Four at a time: one at a time takes a third more instructions. In the air and in a hold most
    // of a block's instructions are here.
    let [weights, a, b] = [weights, a, b].map(|values| values.as_chunks::<4>().0);
    weights.iter().zip(a.iter().zip(b)).fold(
        0.0,
        |sum, ([s, t, u, v], ([a, b, c, d], [e, f, g, h]))| {
            sum + (a - e) * (a - e) * s
                + (b - f) * (b - f) * t
                + (c - g) * (c - g) * u
                + (d - h) * (d - h) * v
        },
    )
}

/// Distance from one level to another along a direction that includes the weights.
pub fn along(direction: &Values, from: &Values, to: &Values) -> f32 {
    direction
        .iter()
        .zip(from.iter().zip(to))
        .fold(0.0, |sum, (weight, (from, to))| sum + (to - from) * weight)
}

/// Squared length of a difference, in units of the noise, and its length along the direction that
/// is ignored.
#[derive(Clone, Copy)]
pub struct Apart {
    sum: f32,
    along: f32,
}

impl Apart {
    pub const NONE: Self = Self {
        sum: 0.0,
        along: 0.0,
    };

    /// Adds a taxel's difference.
    #[inline(always)]
    pub fn add(&mut self, off: f32, weight: f32, pull: f32) {
        self.sum += off * off * weight;
        self.along += off * pull;
    }

    /// Square of the length along the ignored direction.
    #[inline(always)]
    pub fn along_square(self) -> f32 {
        self.along * self.along
    }

    /// Square of the length across the ignored direction.
    #[inline(always)]
    pub fn square(self) -> f32 {
        self.sum - self.along * self.along
    }
}

/// Limit for a sum over the taxels of a scan: so much for each taxel, and a margin. The margin is
/// given for sixteen taxels; it grows with the root of their number, as the standard deviation of
/// the sum does.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    for_each: f32,
    margin_of_16: f32,
}

/// See [`Limit`].
pub const fn limit(for_each: f32, margin_of_16: f32) -> Limit {
    Limit {
        for_each,
        margin_of_16,
    }
}

/// Number of taxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taxels {
    pub count: f32,
    /// Root of a sixteenth of the number.
    root: f32,
}

impl Taxels {
    /// Limits for `count` taxels.
    pub const fn new(count: usize) -> Self {
        Self {
            count: count as f32,
            root: root(count as f32 / 16.0),
        }
    }

    /// The limit for these taxels.
    #[inline(always)]
    pub const fn limit(self, limit: Limit) -> f32 {
        limit.for_each * self.count + limit.margin_of_16 * self.root
    }
}

/// The root of a number from 0 to 1, by Newton's method from above: no `sqrt` is `const`.
pub const fn root(square: f32) -> f32 {
    let mut root = 1.0;
    loop {
        let next = 0.5 * (root + square / root);
        if !(next < root) {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_follow_the_number_of_taxels() {
        let limit = |taxels| Taxels::new(taxels).limit(limit(1.0, 45.0));
        assert_eq!((limit(16), limit(4)), (61.0, 26.5));
        assert!((limit(1) - 12.25).abs() < 1e-4);
    }

    #[test]
    fn a_root_is_one() {
        assert_eq!((root(0.0), root(1.0)), (0.0, 1.0));
        for square in (1..1000).map(|n| n as f32 * 1e-3) {
            assert!(
                (root(square) * root(square) / square - 1.0).abs() < 4.0 * f32::EPSILON,
                "{square}"
            );
        }
    }
}
