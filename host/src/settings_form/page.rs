//! Describes the settings, so that the page can make its form.

use super::{range, shown, split};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Bounds, Kind, Setting, TABLE};
use serde::Serialize;

/// An input of the form.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    pub name: &'static str,
    pub unit: &'static str,
    /// Description of the setting with range and default.
    pub title: String,
    /// `number`, `whole`, `switch`, `word` or `plan`.
    pub kind: &'static str,
    /// Bounds, unless they depend on other settings.
    pub min: Option<f32>,
    pub max: Option<f32>,
    /// Values to choose from, with their labels.
    pub choices: Vec<Choice>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Choice {
    pub value: &'static str,
    pub text: String,
}

/// Returns the inputs for settings of windows and slides, in the order of the table. Masks and
/// properties of a finger or scene are set with a file.
pub fn entries() -> Vec<Entry> {
    let is_shown = |setting: &&Setting| matches!(split(setting.name).0, None | Some("slide"));
    TABLE.iter().filter(is_shown).filter_map(entry).collect()
}

fn entry(setting: &Setting) -> Option<Entry> {
    let limits = match setting.bounds {
        Bounds::Between(min, max) => Some((min, max)),
        Bounds::ZeroOr(_, max) => Some((0.0, max)),
        Bounds::By(_) | Bounds::Any => None,
    };
    let (kind, choices) = match setting.kind {
        Kind::Number => ("number", Vec::new()),
        Kind::Whole => ("whole", Vec::new()),
        Kind::Switch => ("switch", Vec::new()),
        Kind::Mask | Kind::Masks => return None,
        Kind::Word(words) => ("word", words.iter().map(|word| named(word, word)).collect()),
        Kind::Plan => ("plan", plans()),
    };
    Some(Entry {
        name: setting.name,
        unit: setting.unit,
        title: format!(
            "{} {}; default: {}",
            setting.sentence(),
            range(setting),
            shown(&setting.default())
        ),
        kind,
        min: limits.map(|(min, _)| min),
        max: limits.map(|(_, max)| max),
        choices,
    })
}

fn named(value: &'static str, text: &str) -> Choice {
    Choice {
        value,
        text: text.to_owned(),
    }
}

/// Returns the named plans, labelled with their channels and frame rate.
fn plans() -> Vec<Choice> {
    Plan::NAMED
        .iter()
        .map(|(name, plan)| {
            let (channels, rate_hz) = (plan.channels(), plan.frame_rate_hz());
            let rate = if rate_hz < 1000.0 {
                format!("{rate_hz:.0} Hz")
            } else {
                format!("{:.1} kHz", 1e-3 * rate_hz)
            };
            named(name, &format!("{name}: {channels} × {rate}"))
        })
        .collect()
}
