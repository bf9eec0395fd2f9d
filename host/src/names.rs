//! Names of enum variants as text, the same as in JSON.

use serde::Serialize;

/// Returns the name of a variant without fields, as `serde` writes it.
pub fn name(variant: impl Serialize) -> &'static str {
    serde_variant::to_variant_name(&variant).unwrap_or("?")
}
