//! `texture`: what a texture is, learned from recordings; and how a finger's power depends on the
//! period.

mod follower;
mod found;
mod law;
mod learn;

pub use follower::{Follower, News};
pub use found::found;
pub use law::law;
pub use learn::{Learned, Speed, learn};

use anyhow::{Context, Result};
use hal_mock::short_text;
use ridgetone_host::output;
use ridgetone_stimulus::{AmplitudeLaw, Texture};
use std::path::Path;

/// Reads a texture's file.
pub fn load(path: &Path) -> Result<Texture> {
    let named = || path.display().to_string();
    let text = short_text(path)?;
    let texture: Texture = toml::from_str(&text).with_context(named)?;
    texture.check().with_context(named)?;
    Ok(texture)
}

/// Reads the file of a law.
pub fn load_law(path: &Path) -> Result<AmplitudeLaw> {
    let named = || path.display().to_string();
    let law: AmplitudeLaw = toml::from_str(&short_text(path)?).with_context(named)?;
    law.check().with_context(named)?;
    Ok(law)
}

/// Writes a value that is read back as it is.
pub fn save(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    output::new_text(path, &toml::to_string(value)?)
}
