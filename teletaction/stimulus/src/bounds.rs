//! A value between two bounds.

/// A value, or the nearer bound; a NaN becomes the least. `clamp` may panic, and a board's image
/// must not hold that; `max` and `min` are calls on a Cortex-M4F.
pub(crate) fn between(value: f32, least: f32, most: f32) -> f32 {
    if !(value >= least) {
        least
    } else if value > most {
        most
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_between_stays_and_a_nan_is_the_least() {
        for (value, expected) in [
            (1.5, 1.5),
            (0.0, 1.0),
            (3.0, 2.0),
            (f32::NAN, 1.0),
            (f32::INFINITY, 2.0),
        ] {
            assert_eq!(between(value, 1.0, 2.0), expected, "{value}");
        }
    }
}
