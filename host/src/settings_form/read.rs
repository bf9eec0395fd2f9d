//! Reads values of settings from TOML, JSON and the command line.

use super::{plan, rows, split, tables, words};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Kind, Setting, Settings, TABLE, Value as Found};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Replaces values in `all` by those in `given`, table by table.
pub fn merge(all: &mut Table, given: Table) {
    for (name, value) in given {
        match (all.get_mut(&name), value) {
            (Some(Value::Table(all)), Value::Table(given)) => merge(all, given),
            (_, value) => drop(all.insert(name, value)),
        }
    }
}

/// Converts a JSON value to TOML by hand, because other formats do not accept serde_json's numbers.
pub fn of_json(value: serde_json::Value) -> Option<Value> {
    Some(match value {
        serde_json::Value::Null => return None,
        serde_json::Value::Bool(value) => value.into(),
        serde_json::Value::Number(value) => match value.as_i64() {
            Some(whole) => whole.into(),
            None => value.as_f64()?.into(),
        },
        serde_json::Value::String(value) => value.into(),
        serde_json::Value::Array(values) => {
            Value::Array(values.into_iter().filter_map(of_json).collect())
        }
        serde_json::Value::Object(fields) => {
            let fields = fields
                .into_iter()
                .filter_map(|(name, value)| Some((name, of_json(value)?)));
            Value::Table(fields.collect())
        }
    })
}

/// Returns the values by the full names of the settings. Fails if a setting does not exist.
pub fn leaves(given: Table) -> Result<BTreeMap<String, Value>, String> {
    let mut leaves = BTreeMap::new();
    for (name, value) in given {
        match value {
            value if is_setting(&name) => drop(leaves.insert(name, value)),
            Value::Table(fields) if tables().contains(&name.as_str()) => {
                for (field, value) in fields {
                    let name = format!("{name}.{field}");
                    if !is_setting(&name) {
                        return Err(unknown(&name));
                    }
                    leaves.insert(name, value);
                }
            }
            value if tables().contains(&name.as_str()) => {
                return Err(format!("{name} = {value}: {}", members(Some(&name))));
            }
            _ => return Err(unknown(&name)),
        }
    }
    Ok(leaves)
}

fn is_setting(name: &str) -> bool {
    TABLE.iter().any(|setting| setting.name == name)
}

fn unknown(name: &str) -> String {
    format!("no setting `{name}`: {}", members(split(name).0))
}

fn members(table: Option<&str>) -> String {
    let mut names: Vec<_> = rows(table).map(|setting| setting.name).collect();
    let others: Vec<_> = tables().iter().map(|name| format!("{name}.*")).collect();
    if table.is_none() {
        names.extend(others.iter().map(String::as_str));
    }
    format!("choose from {}", names.join(", "))
}

/// Converts a value to the setting's type. Bounds are checked elsewhere.
pub fn value(setting: &Setting, given: &Value, settings: &Settings) -> Result<Found, String> {
    let found = match (setting.kind, given) {
        (Kind::Number, Value::Float(number)) => Some(Found::Number(*number as f32)),
        (Kind::Number, Value::Integer(number)) => Some(Found::Number(*number as f32)),
        (Kind::Whole, Value::Integer(number)) => u8::try_from(*number).ok().map(Found::Whole),
        (Kind::Switch, Value::Boolean(value)) => Some(Found::Switch(*value)),
        (Kind::Mask, given) => mask(given).map(Found::Mask),
        (Kind::Masks, Value::Array(given)) => {
            let masks: Option<Vec<u16>> = given.iter().map(mask).collect();
            masks
                .and_then(|masks| masks.try_into().ok())
                .map(Found::Masks)
        }
        (Kind::Word(words), Value::String(given)) => words
            .iter()
            .find(|word| *word == given)
            .map(|word| Found::Word(word)),
        (Kind::Plan, given) => return with_fields(&settings.plan, given).map(Found::Plan),
        _ => None,
    };
    found.ok_or_else(|| refusal(setting, &given.to_string()))
}

pub fn from_text(setting: &Setting, text: &str) -> Result<Found, String> {
    let given = format!("it={text}").parse::<Table>().ok();
    let given = given.and_then(|mut table| table.remove("it"));
    let given = given.unwrap_or_else(|| Value::String(text.to_owned()));
    value(setting, &given, &Settings::DEFAULT)
}

fn refusal(setting: &Setting, given: &str) -> String {
    format!(
        "{} = {given}: choose {}",
        setting.name,
        words::choices(setting)
    )
}

fn mask(given: &Value) -> Option<u16> {
    given.as_integer().and_then(|mask| u16::try_from(mask).ok())
}

/// Returns a plan by its name, or `plan` with the given fields changed.
fn with_fields(plan: &Plan, given: &Value) -> Result<Plan, String> {
    let fields = match given {
        Value::Table(given) => plan::Fields::for_table(plan, given),
        _ => plan::Fields::of(plan),
    };
    let expected = || format!("a name, or the table plan with {}", fields.names());
    match given {
        // A plan's name does not include the board's clock, so the current one is kept.
        Value::String(name) => Plan::named(name)
            .map(|named| match named.own.converter == plan.own.converter {
                true => named.with_clock(plan.adc_clock_hz),
                false => named,
            })
            .ok_or_else(|| format!("no plan `{name}`: choose one of {}", plan::names())),
        Value::Table(given) => {
            let mut all = Table::try_from(&fields).map_err(|error| error.to_string())?;
            merge(&mut all, given.clone());
            let fields = fields.read(all);
            fields
                .map_err(|error| format!("plan: {}: choose {}", error.message(), expected()))?
                .plan()
                .map_err(|error| words::explained(&error.into()))
        }
        other => Err(format!("plan = {other}: choose {}", expected())),
    }
}
