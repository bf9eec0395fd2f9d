//! Settings as they are stored: pairs of a setting's id and value.
//!
//! Each pair is the id, the number of bytes of the value, and the value in postcard. A reader skips
//! unknown ids and uses the default for missing ones, so that settings survive updates and
//! downgrades of the firmware. A list without pairs stands for the defaults of any firmware.

use super::{COUNT, Settings};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Id that ends the list; no setting has it.
const END: u8 = 0;

/// Content of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kept {
    /// Empty: the defaults apply.
    Defaults,
    /// All settings of this firmware, and no others.
    Settings(Settings),
    /// Settings of a different firmware: some were skipped, or are missing and have their defaults.
    Migrated(Settings),
}

impl Kept {
    /// Reads a list of pairs. `None` if it is damaged, or if the settings contradict each other.
    pub fn read(mut list: &[u8]) -> Option<Self> {
        let mut settings = Settings::DEFAULT;
        let (mut known, mut skipped) = (0, 0);
        while let [id, bytes, rest @ ..] = list
            && *id != END
        {
            let (value, rest) = rest.split_at_checked((*bytes).into())?;
            if settings.read(*id, value) {
                known += 1;
            } else {
                skipped += 1;
            }
            list = rest;
        }
        settings.validate().ok()?;
        Some(match (known, skipped) {
            (0, 0) => Self::Defaults,
            (COUNT, 0) => Self::Settings(settings),
            _ => Self::Migrated(settings),
        })
    }

    /// Writes all settings, or no pairs for the defaults, into a zeroed buffer. `None` if they do
    /// not fit.
    pub fn write(settings: Option<&Settings>, to: &mut [u8]) -> Option<()> {
        let mut pairs = Writer { free: to };
        settings
            .is_none_or(|settings| settings.write(&mut pairs))
            .then_some(())
    }
}

/// Appends pairs to a buffer.
pub(crate) struct Writer<'a> {
    free: &'a mut [u8],
}

impl Writer<'_> {
    /// Appends a pair. Returns false if there is no room for it.
    pub fn push<T: Serialize>(&mut self, id: u8, value: &T) -> bool {
        let free = core::mem::take(&mut self.free);
        let Some((head, value_place)) = free.split_first_chunk_mut::<2>() else {
            return false;
        };
        let Ok(used) = postcard::to_slice(value, value_place).map(|value| value.len()) else {
            return false;
        };
        *head = [id, used as u8];
        self.free = value_place.get_mut(used..).unwrap_or_default();
        true
    }
}

/// Decodes a value into `place`. Returns false and leaves `place` unchanged if the bytes are not
/// exactly one `T`.
pub(crate) fn value<T: DeserializeOwned>(bytes: &[u8], place: &mut T) -> bool {
    let read = postcard::take_from_bytes(bytes);
    let read = read.ok().filter(|(_, rest)| rest.is_empty());
    read.map(|(value, _)| *place = value).is_some()
}
