//! Textures of files, and those that a finger reports.

mod follower;
mod found;

pub use follower::{Follower, News};
pub use found::found;

use crate::stimulus::{AmplitudeLaw, Texture};
use anyhow::{Context, Result};
use hal_mock::short_text;
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
