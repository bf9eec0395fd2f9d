//! What can be wrong with a texture, an actuator or an encoder.

/// Why nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A value is outside of what is possible.
    #[error("{name} = {value}: choose a value from {least} to {greatest}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// What it was set to.
        value: f32,
        /// Least possible value.
        least: f32,
        /// Greatest possible value.
        greatest: f32,
    },
}

/// Whether a value lies between two bounds, both included.
pub(crate) fn within(
    name: &'static str,
    value: f32,
    least: f32,
    greatest: f32,
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
