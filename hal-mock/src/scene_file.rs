//! Reads scenes from short TOML files. The keys are the fields of [`Sliding`], all with defaults;
//! nested structs are tables.
//!
//! ```
//! let scene = hal_mock::parse_scene("a.toml", "period_mm = 2.6\nspeed_mm_s = 15", 241.14)?;
//! assert_eq!((scene.period_mm, scene.ridge_mm), (2.6, 0.6));
//!
//! let error = hal_mock::parse_scene("a.toml", "period_mm = 2.6\nspeed = 15", 241.14).unwrap_err();
//! assert!(error.to_string().starts_with("a.toml: line 2: unknown field `speed`, expected one of `speed_mm_s`, "));
//! # Ok::<(), hal_mock::FileError>(())
//! ```

use crate::file_error::FileError;
use crate::short_text;
use crate::sliding::{Sliding, SlidingScene};
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Reads a scene file, for a scan of `frame_rate_hz`. Errors name the file, the line and the key.
pub fn load_scene(path: impl AsRef<Path>, frame_rate_hz: f64) -> Result<Sliding, FileError> {
    let file = path.as_ref().display().to_string();
    parse_scene(&file, &short_text(&path)?, frame_rate_hz)
}

/// Parses the text of a file named `file`, as [`load_scene`] does.
pub fn parse_scene(file: &str, text: &str, frame_rate_hz: f64) -> Result<Sliding, FileError> {
    let line = |at: Range<usize>| {
        text.get(..at.start)
            .map(|before| before.matches('\n').count() as u64 + 1)
    };
    let scene: Sliding = toml::from_str(text).map_err(|error| {
        let key = error
            .span()
            .and_then(|at| key_of(text, &at))
            .map_or_else(String::new, |key| format!("{key}: "));
        let message = format!("{key}{}", error.message().replace('\n', ", "));
        FileError::new(file, error.span().and_then(line), message)
    })?;
    let keys = DeTable::parse(text).map_or_else(|_| Vec::new(), |table| keys(table.get_ref()));
    let line_of = |name: &str| {
        keys.iter()
            .find(|key| key.name == name)
            .and_then(|key| line(key.span.clone()))
    };
    let refuse = |line: Option<u64>, message: String| Err(FileError::new(file, line, message));

    let beside = ["speed_mm_s", "slide_mm", "stimulator"]
        .into_iter()
        .find(|key| line_of(key).is_some());
    if let (Some(_), Some(key)) = (scene.hand, beside) {
        let message = format!(
            "{key} does not go with [hand], which has a speed of its own: leave one of them out"
        );
        return refuse(line_of(key), message);
    }
    let truth = match SlidingScene::new(scene.clone()) {
        Ok(made) => made.truth(),
        // If the invalid value is a default, name the line of the key that limits it.
        Err(error) => return refuse(error.keys().find_map(line_of), error.to_string()),
    };
    let (frequency_hz, period_mm) = (truth.frequency_hz, scene.period_mm);
    if frequency_hz >= 0.5 * frame_rate_hz {
        let min_mm = frequency_hz * period_mm / (0.5 * frame_rate_hz);
        let message = format!(
            "period_mm = {period_mm}: makes {frequency_hz:.1} Hz, and {frame_rate_hz:.2} frames a second follow less \
             than half their rate: choose more than {min_mm:.3} mm, or a lower speed"
        );
        return refuse(
            ["period_mm", "speed_mm_s", "peak_mm_s"]
                .into_iter()
                .find_map(line_of),
            message,
        );
    }
    Ok(scene)
}

/// A key of the file, with the positions of key and value.
struct Key {
    name: String,
    span: Range<usize>,
    value: Range<usize>,
}

/// Lists the keys of all tables; no key name occurs in two tables.
fn keys(table: &DeTable<'_>) -> Vec<Key> {
    let mut all = Vec::new();
    for (key, value) in table {
        if let DeValue::Table(inner) = value.get_ref() {
            all.extend(keys(inner));
        }
        all.push(Key {
            name: key.get_ref().to_string(),
            span: key.span(),
            value: value.span(),
        });
    }
    all
}

/// Finds the key whose value is at `at`, for messages that do not name it; for a duplicate key,
/// `at` is the key itself.
fn key_of(text: &str, at: &Range<usize>) -> Option<String> {
    match DeTable::parse(text) {
        Ok(table) => keys(table.get_ref())
            .into_iter()
            .find(|key| key.value == *at)
            .map(|key| key.name),
        Err(_) => {
            let is_key = |text: &&str| text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            text.get(at.clone())
                .filter(is_key)
                .filter(|key| !key.is_empty())
                .map(str::to_owned)
        }
    }
}
