//! Settings as text: TOML in files, the same names in JSON, `name=value` on the command line.
//!
//! ```toml
//! window_s = 0.5
//! interferer_hz = 50
//!
//! [slide]
//! rule = "protocol" # or "found": in the signal
//! speed_mm_s = 30
//!
//! [array]
//! period_most_mm = 3.5
//!
//! [feel]
//! volts_per_um = 0.002
//! ```
//!
//! Settings that are left out keep their value: in a file the default ([`Settings::DEFAULT`]), on
//! the command line the board's.

mod words;

use crate::usage::UsageError;
use anyhow::{Context, Result, anyhow};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Array, Feeling, Settings, SlideRule};
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::{Table, Value};
use words::meaning;

pub use words::{explain, explained};

/// The form of [`Settings`]: the rule of the slide is a table with its name.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Settings", deny_unknown_fields)]
pub struct SettingsForm {
    window_s: f32,
    hop_s: f32,
    harmonics: u8,
    accuracy: f32,
    interferer_hz: f32,
    vref_v: f32,
    #[serde(with = "plan_form")]
    plan: Plan,
    #[serde(with = "SlideForm")]
    slide: SlideRule,
    array: Array,
    feel: Feeling,
}

#[derive(Serialize, Deserialize)]
#[serde(
    remote = "SlideRule",
    tag = "rule",
    rename_all = "snake_case",
    deny_unknown_fields
)]
enum SlideForm {
    // With braces serde refuses fields that do not belong to the rule.
    Found {},
    Protocol {
        #[serde(default = "delay_s")]
        delay_s: f32,
        speed_mm_s: f32,
        #[serde(default = "length_mm")]
        length_mm: f32,
    },
}

/// A plan by its name, if it has one.
pub mod plan_form {
    use ridgetone_proto::plan::Plan;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Deserialize)]
    #[serde(
        untagged,
        expecting = "a plan: paper, hand, texture, vibration, single, or a table of inputs, data_rate, delay, chop, health"
    )]
    enum Form {
        Name(String),
        Fields(Plan),
    }

    pub fn serialize<S: Serializer>(plan: &Plan, to: S) -> Result<S::Ok, S::Error> {
        match plan.name() {
            Some(name) => name.serialize(to),
            None => plan.serialize(to),
        }
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Plan, D::Error> {
        match Form::deserialize(from)? {
            Form::Fields(plan) => Ok(plan),
            Form::Name(name) => Plan::named(&name).ok_or_else(|| {
                let names = Plan::NAMED.map(|(name, _)| name).join(", ");
                D::Error::custom(format!("no plan `{name}`: choose one of {names}"))
            }),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct Written(#[serde(with = "SettingsForm")] Settings);

/// The paper's protocol: a second of hold, then 55 of the 60 mm.
const fn delay_s() -> f32 {
    1.0
}

const fn length_mm() -> f32 {
    55.0
}

/// Settings as TOML, each with its meaning as a comment.
pub fn toml(settings: &Settings) -> Result<String> {
    let bare = toml::to_string(&Written(*settings))?;
    let line = |line: &str| match line.split_once(" = ").and_then(|(name, _)| meaning(name)) {
        Some(meaning) => format!("{line:<24} # {meaning}\n"),
        None => format!("{line}\n"),
    };
    Ok(bare.lines().map(line).collect())
}

/// Settings of a file, with defaults for those it leaves out.
pub fn load(path: &Path) -> Result<Settings> {
    let named = || path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(named)?;
    let given: Table = text.parse().with_context(named)?;
    over(&Settings::DEFAULT, given).with_context(named)
}

/// Settings with some of them changed: `name=value`, in a table `table.name=value`, as in TOML.
/// Fails with a [`UsageError`]: an unknown name, a value of the wrong type, or one out of its
/// bounds.
pub fn change(settings: &Settings, changes: &[String]) -> Result<Settings> {
    let mut settings = *settings;
    // A plan brings its window and hop, which others may replace.
    let is_plan = |change: &&String| change.trim_start().starts_with("plan");
    for change in changes
        .iter()
        .filter(is_plan)
        .chain(changes.iter().filter(|change| !is_plan(change)))
    {
        let refuse = |why: String| anyhow!(UsageError(format!("{change}: {why}")));
        let (name, value) = change
            .split_once('=')
            .ok_or_else(|| refuse("write NAME=VALUE".into()))?;
        // A word needs no quotes here, because the shell would remove them.
        let given = format!("{name}={value}").parse::<Table>();
        let given = given.or_else(|_| format!("{name}=\"{value}\"").parse::<Table>());
        let given = given.map_err(|error| refuse(error.message().to_owned()))?;
        settings = over(&settings, given).map_err(|error| refuse(format!("{error:#}")))?;
    }
    Ok(settings)
}

/// Settings as one JSON object, with the names of [`toml()`].
pub fn json(settings: &Settings) -> serde_json::Result<String> {
    serde_json::to_string(&Written(*settings))
}

/// Settings with those of a JSON object in place of theirs. Fails with a [`UsageError`]: an unknown
/// name, a value of the wrong type, or one out of its bounds.
pub fn with_json(settings: &Settings, given: &str) -> Result<Settings> {
    let refuse = |why: String| anyhow!(UsageError(why));
    let given: serde_json::Map<_, _> =
        serde_json::from_str(given).map_err(|error| refuse(error.to_string()))?;
    let given = given
        .into_iter()
        .filter_map(|(name, value)| Some((name, of_json(value)?)))
        .collect();
    over(settings, given).map_err(|error| refuse(format!("{error:#}")))
}

/// A JSON value in TOML. serde_json's numbers are no numbers to another format.
fn of_json(value: serde_json::Value) -> Option<Value> {
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

/// Settings with those of a table in place of theirs.
fn over(settings: &Settings, given: Table) -> Result<Settings> {
    let mut all = Table::try_from(Written(*settings))?;
    if let Some(plan) = given.get("plan") {
        let mut with_plan = Table::try_from(Written(*settings))?;
        if plan.is_table() {
            all.insert("plan".into(), Value::try_from(settings.plan)?);
            with_plan.insert("plan".into(), Value::try_from(settings.plan)?);
        }
        merge(
            &mut with_plan,
            [("plan".to_owned(), plan.clone())].into_iter().collect(),
        );
        let Written(with_plan) = with_plan
            .try_into()
            .map_err(|error: toml::de::Error| anyhow!(error.message().to_owned()))?;
        if with_plan.plan != settings.plan {
            let (window_s, hop_s) = with_plan.plan.default_window();
            all.insert("window_s".into(), Value::try_from(window_s)?);
            all.insert("hop_s".into(), Value::try_from(hop_s)?);
        }
    }
    // A new rule starts with its own defaults: the fields of the old one mean nothing to it.
    let rule = |table: &Table| {
        table
            .get("slide")
            .and_then(|slide| slide.get("rule"))
            .cloned()
    };
    if rule(&given).is_some_and(|new| Some(new) != rule(&all)) {
        all.remove("slide");
    }
    merge(&mut all, given);
    let Written(settings) = all
        .try_into()
        .map_err(|error: toml::de::Error| anyhow!(error.message().to_owned()))?;
    settings
        .validate()
        .map_err(|error| anyhow!(explained(&error)))?;
    Ok(settings)
}

fn merge(all: &mut Table, given: Table) {
    for (name, value) in given {
        match (all.get_mut(&name), value) {
            (Some(Value::Table(all)), Value::Table(given)) => merge(all, given),
            (_, value) => drop(all.insert(name, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(changes: &[&str]) -> Result<Settings> {
        change(
            &Settings::DEFAULT,
            &changes
                .iter()
                .map(|text| (*text).to_owned())
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn settings_written_and_read_are_the_same_to_the_last_bit() {
        let slide = SlideRule::Protocol {
            delay_s: 0.1,
            speed_mm_s: 30.3,
            length_mm: 55.5,
        };
        let array = Array {
            edge_phase_rad: 0.1 + f32::EPSILON,
            alike: [1, 2, 4, 8],
            ..Array::DEFAULT
        };
        for settings in [
            Settings::DEFAULT,
            Settings {
                window_s: 0.7,
                accuracy: 0.003,
                slide,
                array,
                ..Settings::DEFAULT
            },
        ] {
            let text = toml(&settings).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("settings.toml");
            std::fs::write(&path, &text).unwrap();
            assert_eq!(load(&path).unwrap(), settings, "{text}");
        }
        // As short as they were written, each with its meaning.
        let text = toml(&Settings {
            slide,
            ..Settings::DEFAULT
        })
        .unwrap();
        assert!(text.contains("vref_v = 4.096 "));
        assert!(
            text.lines()
                .filter(|line| line.contains(" = "))
                .all(|line| line.contains(" # ")),
            "{text}"
        );
    }

    #[test]
    fn a_change_leaves_the_other_settings() {
        let found = changed(&[
            "window_s=0.5",
            "array.period_most_mm=3",
            "interferer_hz = 50",
        ])
        .unwrap();
        let array = Array {
            period_most_mm: 3.0,
            ..Array::DEFAULT
        };
        assert_eq!(
            found,
            Settings {
                window_s: 0.5,
                interferer_hz: 50.0,
                array,
                ..Settings::DEFAULT
            }
        );
        let by_protocol = changed(&["slide={rule=\"protocol\", speed_mm_s=20}"]).unwrap();
        let protocol = |speed_mm_s| SlideRule::Protocol {
            delay_s: 1.0,
            speed_mm_s,
            length_mm: 55.0,
        };
        assert_eq!(by_protocol.slide, protocol(20.0));
        assert_eq!(
            change(&by_protocol, &["slide.speed_mm_s=25".into()])
                .unwrap()
                .slide,
            protocol(25.0)
        );
        assert_eq!(
            change(&by_protocol, &["slide.rule=found".into()]).unwrap(),
            Settings::DEFAULT
        );
    }

    #[test]
    fn a_plan_has_a_name_or_fields_and_brings_its_window() {
        for (name, plan) in Plan::NAMED {
            let found = changed(&[format!("plan={name}").as_str()]).unwrap();
            assert_eq!(found, Settings::DEFAULT.with_plan(plan), "{name}");
            assert!(
                toml(&found)
                    .unwrap()
                    .contains(&format!("plan = \"{name}\""))
            );
            assert_eq!(
                changed(&["hop_s=0.08", &format!("plan={name}")])
                    .unwrap()
                    .hop_s,
                0.08
            );
            assert_eq!(
                with_json(&Settings::DEFAULT, &json(&found).unwrap()).unwrap(),
                found
            );
        }
        let eight = changed(&["plan.inputs=0x00ff", "plan.data_rate=2"]).unwrap();
        assert_eq!(
            eight.plan,
            Plan {
                inputs: 0xff,
                data_rate: 2,
                ..Plan::PAPER
            }
        );
        let text = toml(&eight).unwrap();
        assert!(
            text.lines()
                .filter(|line| line.contains(" = "))
                .all(|line| line.contains(" # ")),
            "{text}"
        );
        assert_eq!(
            over(&Settings::DEFAULT, text.parse().unwrap()).unwrap(),
            eight
        );
        // Back by name, over fields.
        assert_eq!(
            change(&eight, &["plan=paper".into()]).unwrap(),
            Settings::DEFAULT
        );
        for (change, parts) in [
            ("plan=fast", &["no plan `fast`", "texture"][..]),
            ("plan.inputs=0", &["inputs = 0", "1 to 16"]),
            ("plan.chop=true", &["chop", "between_touches"]),
            ("plan.data_rate=0", &["frame_rate_hz = 80", "180"]),
            ("plan.rate=3", &["a plan: paper"]),
        ] {
            let text = changed(&[change]).unwrap_err().to_string();
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{change}: {text}"
            );
        }
    }

    #[test]
    fn a_refusal_names_the_bounds_and_their_reason() {
        for (change, parts) in [
            (
                "window_s=9",
                &[
                    "window_s=9: window_s = 9: choose a value from 0.1 to 3.9",
                    "memory",
                ][..],
            ),
            (
                "windw_s=1",
                &["unknown field `windw_s`", "`hop_s`", "`window_s`"],
            ),
            ("array.pitch=1", &["unknown field `pitch`", "`pitch_mm`"]),
            ("harmonics=2.5", &["floating point `2.5`, expected u8"]),
            ("harmonics=300", &["300"]),
            ("window_s", &["NAME=VALUE"]),
            ("slide.rule=neither", &["neither", "found", "protocol"]),
            ("slide.speed=3", &["unknown field `speed`"]),
            ("array=3", &["expected struct Array"]),
        ] {
            let error = changed(&[change]).unwrap_err();
            assert!(error.is::<UsageError>(), "{change}");
            let text = error.to_string();
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{change}: {text}"
            );
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wrong.toml");
        std::fs::write(&path, "window_s = 0.5\nhop_s = \n").unwrap();
        let text = format!("{:#}", load(&path).unwrap_err());
        assert!(
            text.contains("wrong.toml") && text.contains("line 2"),
            "{text}"
        );
    }
}
