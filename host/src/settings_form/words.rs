//! Descriptions of settings: values, ranges and reasons.

use super::plan;
use ridgetone_proto::settings::{Bounds, Kind, Setting, Settings, SettingsError, TABLE, Value};

/// Returns a value in TOML notation.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Number(value) => format!("{value:?}"),
        Value::Whole(value) => value.to_string(),
        Value::Switch(value) => value.to_string(),
        Value::Mask(mask) => format!("{mask:#06x}"),
        Value::Masks(masks) => {
            let masks: Vec<_> = masks.iter().map(|mask| format!("{mask:#06x}")).collect();
            format!("[{}]", masks.join(", "))
        }
        Value::Word(word) => format!("\"{word}\""),
        Value::Plan(plan) => match plan.name() {
            Some(name) => format!("\"{name}\""),
            None => format!("{plan:?}"),
        },
    }
}

/// Describes the range of a setting. Bounds that depend on other settings are shown for defaults.
pub fn range(setting: &Setting) -> String {
    match (setting.kind, setting.bounds) {
        (Kind::Switch, _) => "true or false".into(),
        (Kind::Mask, _) => "16 bits".into(),
        (Kind::Masks, _) => "four masks, no bit in two".into(),
        (Kind::Word(words), _) => words.join(" or "),
        (Kind::Plan, _) => format!("{}, or its fields", plan::names()),
        (_, bounds) => {
            let limits = bounds.limits(&Settings::DEFAULT);
            let limits = limits.map(|limits| format!("{} to {}", limits.min, limits.max));
            let limits = limits.unwrap_or_default();
            match bounds {
                Bounds::ZeroOr(..) => format!("0, or {limits}"),
                Bounds::By(_) => format!("{limits} with the defaults"),
                _ => limits,
            }
        }
    }
}

/// Describes the accepted values, for an error about a value of the wrong type.
pub fn choices(setting: &Setting) -> String {
    let range = range(setting);
    match setting.kind {
        Kind::Number => format!("a number, {range}"),
        Kind::Whole => format!("a whole number, {range}"),
        _ => range,
    }
}

/// Returns the comment at the end of a setting's line in a file.
pub fn comment(setting: &Setting) -> String {
    match setting.unit {
        "" => setting.sentence().to_owned(),
        unit => format!("{} [{unit}]", setting.sentence()),
    }
}

/// Describes a value out of bounds, with the reason for the bounds.
pub fn explained(error: &SettingsError) -> String {
    explain(&error.field, &error.to_string())
}

/// Returns `text` with the reason for the bounds of a setting.
pub fn explain(name: &str, text: &str) -> String {
    let setting = TABLE.iter().find(|setting| setting.name == name);
    match setting.map_or(plan::reason(name), |setting| setting.reason) {
        "" => text.to_owned(),
        reason => format!("{text} ({reason})"),
    }
}
