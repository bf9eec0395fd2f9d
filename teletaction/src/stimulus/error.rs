//! Values and their ranges.

/// A value out of range; nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: choose a value from {min} to {max}")]
pub struct Error {
    pub name: &'static str,
    pub value: f32,
    pub min: f32,
    pub max: f32,
}

/// Checks that a value is from `min` to `max`.
pub(crate) fn within(name: &'static str, value: f32, min: f32, max: f32) -> Result<(), Error> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(Error {
            name,
            value,
            min,
            max,
        })
    }
}

/// Clamps a value; a NaN becomes the lower bound. `clamp` may panic, which a board's image must not
/// contain; `max` and `min` are calls on a Cortex-M4F.
pub(crate) fn between(value: f32, min: f32, max: f32) -> f32 {
    if !(value >= min) {
        min
    } else if value > max {
        max
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_clamped_and_nan_is_the_lower_bound() {
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
