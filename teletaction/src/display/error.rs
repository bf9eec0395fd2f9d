//! What can be wrong with settings and data.

/// Why nothing was computed. The display keeps its last forces.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A value is no finite number.
    #[error("{what} {index} is no finite number: leave that frame out")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// Its place in the slice.
        index: usize,
    },
    /// A slice has the wrong length.
    #[error("{what}: {found} values where there must be {needed}")]
    Length {
        /// What the slice holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that it must have, or must have at least.
        needed: usize,
    },
    /// A setting is outside of what is possible.
    #[error("{name} = {value}: choose a value from {least} to {greatest}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// What it was set to.
        value: f64,
        /// Least possible value.
        least: f64,
        /// Greatest possible value.
        greatest: f64,
    },
    /// The slew limit forbids the smallest step that the display can make.
    #[error(
        "one level is {quantum_n} N and one update may change {step_n} N: allow a faster slew, or take more levels"
    )]
    Frozen {
        /// Force of one level, newtons.
        quantum_n: f32,
        /// Greatest change in one update, newtons.
        step_n: f32,
    },
    /// Two or more pins do nearly the same, so that their forces are not determined.
    #[error(
        "pin {pin} does nothing that the pins before it do not: raise the regularisation, or set the pins farther apart"
    )]
    Singular {
        /// The pin.
        pin: usize,
    },
}

/// Whether a setting lies between two bounds, both included.
pub(crate) fn within(
    name: &'static str,
    value: f64,
    least: f64,
    greatest: f64,
) -> Result<(), Error> {
    if value >= least && value <= greatest {
        Ok(())
    } else {
        Err(Error::Setting {
            name,
            value,
            least,
            greatest,
        })
    }
}

/// Whether all values are finite.
pub(crate) fn finite(what: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Whether a slice has its length.
pub(crate) fn length(what: &'static str, found: usize, needed: usize) -> Result<(), Error> {
    if found == needed {
        Ok(())
    } else {
        Err(Error::Length {
            what,
            found,
            needed,
        })
    }
}
