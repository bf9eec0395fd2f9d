//! Scenes from short TOML files: the keys are the fields of [`Sliding`], all with defaults, and its parts are tables.
//!
//! ```
//! let scene = hal_mock::parse_scene("a.toml", "period_mm = 2.6\nspeed_mm_s = 15", 241.14)?;
//! assert_eq!((scene.period_mm, scene.ridge_mm), (2.6, 0.6));
//!
//! let error = hal_mock::parse_scene("a.toml", "period_mm = 2.6\nspeed = 15", 241.14).unwrap_err();
//! assert!(error.to_string().starts_with("a.toml: line 2: unknown field `speed`, expected one of `speed_mm_s`, "));
//! # Ok::<(), hal_mock::SceneFileError>(())
//! ```

use crate::sliding::{ParameterError, Sliding, SlidingScene};
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Why a scene file is none: one line that names the file, and the line and key where there is one.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields are what the messages say")]
pub enum SceneFileError {
    /// The file could not be read.
    #[error("{file}: {error}")]
    Io { file: String, error: std::io::Error },
    /// No TOML, an unknown key, or a value of the wrong kind.
    #[error("{file}: {place}{message}")]
    Toml { file: String, place: String, message: String },
    /// A value that is impossible, by itself or beside the others.
    #[error("{file}: {place}{error}")]
    Parameter { file: String, place: String, error: ParameterError },
    /// Two keys that exclude each other.
    #[error("{file}: {place}{key} does not go with [hand], which has a speed of its own: leave one of them out")]
    Beside { file: String, place: String, key: &'static str },
    /// The grating is too fine for the scan.
    #[error(
        "{file}: {place}period_mm = {period_mm}: makes {frequency_hz:.1} Hz, and {frame_rate_hz:.2} frames a second \
         follow less than half their rate: choose more than {least_mm:.3} mm, or a lower speed"
    )]
    TooFine { file: String, place: String, period_mm: f64, frequency_hz: f64, frame_rate_hz: f64, least_mm: f64 },
}

/// Reads a scene file; `frame_rate_hz` is how often each channel is read.
///
/// # Errors
/// See [`SceneFileError`].
pub fn load_scene(path: impl AsRef<Path>, frame_rate_hz: f64) -> Result<Sliding, SceneFileError> {
    let file = path.as_ref().display().to_string();
    let text = std::fs::read_to_string(&path).map_err(|error| SceneFileError::Io { file: file.clone(), error })?;
    parse_scene(&file, &text, frame_rate_hz)
}

/// Reads a scene from the text of a file of that name.
///
/// # Errors
/// See [`SceneFileError`].
pub fn parse_scene(file: &str, text: &str, frame_rate_hz: f64) -> Result<Sliding, SceneFileError> {
    let file = file.to_owned();
    let scene: Sliding = match toml::from_str(text) {
        Ok(scene) => scene,
        Err(error) => {
            let (place, key) = error.span().map_or_else(Default::default, |at| (line(text, &at), key_of(text, &at)));
            let message = format!("{key}{}", error.message().replace('\n', ", "));
            return Err(SceneFileError::Toml { file, place, message });
        }
    };
    let place = |key: &str| key_span(text, key).map_or_else(String::new, |at| line(text, &at));
    let beside = ["speed_mm_s", "slide_mm", "stimulator"].into_iter().find(|key| key_span(text, key).is_some());
    if let (Some(_), Some(key)) = (scene.hand, beside) {
        return Err(SceneFileError::Beside { file, place: place(key), key });
    }
    let truth = match SlidingScene::new(scene.clone()) {
        Ok(made) => made.truth(),
        Err(error) => {
            // Where the key at fault has its default, the one that limits it is in the file.
            let place = error.keys().map(place).find(|place| !place.is_empty()).unwrap_or_default();
            return Err(SceneFileError::Parameter { file, place, error });
        }
    };
    let (frequency_hz, period_mm) = (truth.frequency_hz, scene.period_mm);
    if frequency_hz >= 0.5 * frame_rate_hz {
        let least_mm = frequency_hz * period_mm / (0.5 * frame_rate_hz);
        let keys = ["period_mm", "speed_mm_s", "peak_mm_s"].into_iter();
        let place = keys.map(place).find(|place| !place.is_empty()).unwrap_or_default();
        return Err(SceneFileError::TooFine { file, place, period_mm, frequency_hz, frame_rate_hz, least_mm });
    }
    Ok(scene)
}

fn line(text: &str, at: &Range<usize>) -> String {
    let before = text.get(..at.start).unwrap_or(text);
    format!("line {}: ", before.matches('\n').count() + 1)
}

/// Walks through all keys of all tables, no two of which have the same name.
fn find<'a>(
    table: &DeTable<'a>,
    wanted: &impl Fn(&str, &Range<usize>, &Range<usize>) -> bool,
) -> Option<(String, Range<usize>)> {
    table.iter().find_map(|(key, value)| {
        let inner = match value.get_ref() {
            DeValue::Table(inner) => find(inner, wanted),
            _ => None,
        };
        inner.or_else(|| {
            wanted(key.get_ref(), &key.span(), &value.span()).then(|| (key.get_ref().to_string(), key.span()))
        })
    })
}

fn key_span(text: &str, key: &str) -> Option<Range<usize>> {
    let table = DeTable::parse(text).ok()?;
    find(table.get_ref(), &|name, _, _| name == key).map(|(_, span)| span)
}

/// The key whose value is at a place, where the message does not name it; a key that is there twice is itself there.
fn key_of(text: &str, at: &Range<usize>) -> String {
    let key = match DeTable::parse(text) {
        Ok(table) => find(table.get_ref(), &|_, _, value| value == at).map(|(key, _)| key),
        Err(_) => text.get(at.clone()).filter(|key| is_key(key)).map(str::to_owned),
    };
    key.map_or_else(String::new, |key| format!("{key}: "))
}

fn is_key(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
