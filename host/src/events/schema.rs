//! JSON schemas of the messages, by their `type`. `schema.json` is generated from the views; the
//! unit tests compare them, and `cargo xtask events` rewrites it.

use serde_json::{Map, Value};
use std::sync::LazyLock;

/// The version of JSON schema.
pub const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

static SCHEMAS: LazyLock<Map<String, Value>> = LazyLock::new(|| {
    // The unit tests write this file.
    serde_json::from_str(include_str!("schema.json")).unwrap_or_default()
});

/// Returns schemas of messages by `type`, in the order of the views, except for the object of
/// `fit`.
pub fn messages() -> impl Iterator<Item = (&'static str, &'static Value)> {
    let all = SCHEMAS.iter().map(|(kind, schema)| (kind.as_str(), schema));
    all.filter(|(kind, _)| *kind != "fit")
}

pub fn of(kind: &str) -> Option<&'static Value> {
    SCHEMAS.get(kind)
}
