//! Settings as text: TOML in files, the same names in JSON, and `name=value` on the command line.
//! All forms are derived from [`TABLE`].
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
//! period_max_mm = 3.5
//! ```
//!
//! Settings that are omitted have the default value ([`Settings::DEFAULT`]) in a file, and keep the
//! board's value on the command line.

#[cfg(test)]
mod generated;
mod page;
pub mod plan;
mod read;
mod words;

use crate::usage::UsageError;
use anyhow::{Context, Result, anyhow};
use hal_mock::short_text;
use ridgetone_proto::settings::{Setting, Settings, TABLE, Value};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt::Write;
use std::path::Path;
use toml::Table;

pub use page::{Entry, entries};
pub use read::from_text;
pub use words::{explain, explained, range, shown};

/// Splits a setting's name into its table, such as `array`, and its name in that table.
pub fn split(name: &str) -> (Option<&str>, &str) {
    match name.split_once('.') {
        Some((table, name)) => (Some(table), name),
        None => (None, name),
    }
}

/// Returns the settings of a table, or those outside all tables.
fn rows(table: Option<&str>) -> impl Iterator<Item = &'static Setting> {
    TABLE
        .iter()
        .filter(move |setting| split(setting.name).0 == table)
}

fn tables() -> Vec<&'static str> {
    let mut tables: Vec<_> = TABLE.iter().filter_map(|row| split(row.name).0).collect();
    tables.dedup();
    tables
}

/// Serializes settings by their names.
pub fn serialize<S: Serializer>(settings: &Settings, to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(None)?;
    for setting in rows(None) {
        map.serialize_entry(setting.name, &Shown((setting.get)(settings)))?;
    }
    for table in tables() {
        map.serialize_entry(table, &ShownTable { table, settings })?;
    }
    map.end()
}

struct ShownTable<'a> {
    table: &'static str,
    settings: &'a Settings,
}

impl Serialize for ShownTable<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(
            rows(Some(self.table))
                .map(|setting| (split(setting.name).1, Shown((setting.get)(self.settings)))),
        )
    }
}

struct Shown(Value);

impl Serialize for Shown {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Number(value) => value.serialize(to),
            Value::Whole(value) => value.serialize(to),
            Value::Switch(value) => value.serialize(to),
            Value::Mask(value) => value.serialize(to),
            Value::Masks(value) => value.serialize(to),
            Value::Word(value) => value.serialize(to),
            Value::Plan(value) => plan::serialize(&value, to),
        }
    }
}

struct All<'a>(&'a Settings);

impl Serialize for All<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        serialize(self.0, to)
    }
}

/// Returns settings as TOML, each with its meaning as a comment.
pub fn toml(settings: &Settings) -> Result<String> {
    let mut text = String::new();
    for table in std::iter::once(None).chain(tables().into_iter().map(Some)) {
        if let Some(table) = table {
            writeln!(text, "\n[{table}]")?;
        }
        for setting in rows(table) {
            let name = split(setting.name).1;
            let line = match (setting.get)(settings) {
                // A plan without a name is written as a table at the end.
                Value::Plan(plan) if plan.name().is_none() => continue,
                value => format!("{name} = {}", shown(&value)),
            };
            writeln!(text, "{line:<28} # {}", words::comment(setting))?;
        }
    }
    if settings.plan.name().is_none() {
        writeln!(text, "\n[plan]")?;
        let fields = toml::to_string(&plan::Fields::of(&settings.plan))?;
        for line in fields.lines() {
            let name = line.split(" = ").next().unwrap_or_default();
            writeln!(text, "{line:<28} # {}", plan::meaning(name))?;
        }
    }
    Ok(text)
}

/// Loads settings from a file, with defaults for those that it omits.
pub fn load(path: &Path) -> Result<Settings> {
    let named = || path.display().to_string();
    let text = short_text(path)?;
    let given: Table = text.parse().with_context(named)?;
    over(&Settings::DEFAULT, given).with_context(named)
}

/// Applies changes to settings: `name=value`, or `table.name=value` in a table, as in TOML. Fails
/// with a [`UsageError`] for an unknown name, a value of the wrong type or a value out of bounds.
pub fn change(settings: &Settings, changes: &[String]) -> Result<Settings> {
    let mut all = Table::new();
    for change in changes {
        let refuse = |why: &str| anyhow!(UsageError(format!("{change}: {why}")));
        let (name, value) = change
            .split_once('=')
            .ok_or_else(|| refuse("write NAME=VALUE"))?;
        // A word needs no quotes here, because the shell would remove them.
        let given = format!("{name}={value}").parse::<Table>();
        let given = given.or_else(|_| format!("{name}=\"{value}\"").parse::<Table>());
        read::merge(&mut all, given.map_err(|error| refuse(error.message()))?);
    }
    over(settings, all).map_err(|error| anyhow!(UsageError(format!("{error:#}"))))
}

/// Returns settings as one JSON object, with the names of [`toml()`].
pub fn json(settings: &Settings) -> serde_json::Result<String> {
    serde_json::to_string(&All(settings))
}

/// Replaces settings by those of a JSON object. Fails with a [`UsageError`] for an unknown name, a
/// value of the wrong type or a value out of bounds.
pub fn with_json(settings: &Settings, given: &str) -> Result<Settings> {
    let refuse = |why: String| anyhow!(UsageError(why));
    let given: serde_json::Map<_, _> =
        serde_json::from_str(given).map_err(|error| refuse(error.to_string()))?;
    let given = given
        .into_iter()
        .filter_map(|(name, value)| Some((name, read::of_json(value)?)))
        .collect();
    over(settings, given).map_err(|error| refuse(format!("{error:#}")))
}

fn over(settings: &Settings, given: Table) -> Result<Settings> {
    let mut settings = *settings;
    let mut given = read::leaves(given).map_err(|why| anyhow!(why))?;
    // The plan comes first in the table: it sets window and stride, which later settings may
    // replace.
    for setting in TABLE {
        let Some(value) = given.remove(setting.name) else {
            continue;
        };
        let value = read::value(setting, &value, &settings).map_err(|why| anyhow!(why))?;
        set(&mut settings, setting, value);
    }
    settings
        .validate()
        .map_err(|error| anyhow!(explained(&error)))?;
    Ok(settings)
}

/// Sets a value. A new plan also sets its window and stride.
pub fn set(settings: &mut Settings, setting: &Setting, value: Value) {
    match value {
        Value::Plan(plan) if plan == settings.plan => {}
        Value::Plan(plan) => *settings = settings.with_plan(plan),
        value => {
            let is_set = (setting.set)(settings, value);
            debug_assert!(is_set, "{} = {value:?}", setting.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_finger::converter::{Ads1258Plan, OnboardPlan};
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::settings::{Array, Slide, SlideRule};

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
        let slide = Slide {
            rule: SlideRule::Protocol,
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
        // Values are as short as possible, each with its meaning.
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
            "array.period_max_mm=3",
            "interferer_hz = 50",
        ])
        .unwrap();
        let array = Array {
            period_max_mm: 3.0,
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
        let protocol = |speed_mm_s| Slide {
            rule: SlideRule::Protocol,
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
        // The speed is kept for the next use of the protocol.
        let found = change(&by_protocol, &["slide.rule=found".into()]).unwrap();
        let slide = Slide {
            speed_mm_s: 20.0,
            ..Slide::DEFAULT
        };
        assert_eq!(found.slide, slide);
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
                changed(&["stride_s=0.08", &format!("plan={name}")])
                    .unwrap()
                    .stride_s,
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
            Ads1258Plan {
                inputs: 0xff,
                data_rate: 2,
                ..Ads1258Plan::PAPER
            }
            .plan()
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
        // A plan's name replaces a plan given by fields.
        assert_eq!(
            change(&eight, &["plan=paper".into()]).unwrap(),
            Settings::DEFAULT
        );
        for (change, parts) in [
            ("plan=fast", &["no plan `fast`", "texture"][..]),
            ("plan.inputs=0", &["plan.inputs = 0", "1 to 16"]),
            ("plan.chop=true", &["chop", "between_touches"]),
            ("plan.data_rate=0", &["frame_rate_hz = 80", "180"]),
            ("plan.rate=3", &["unknown field `rate`", "data_rate"]),
            ("plan=3", &["plan = 3", "a name"]),
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
                &["window_s = 9: choose a value from 0.1 to 3.9", "memory"][..],
            ),
            (
                "windw_s=1",
                &[
                    "no setting `windw_s`",
                    "stride_s, ",
                    "window_s, ",
                    "array.*",
                ],
            ),
            (
                "array.pitch=1",
                &["no setting `array.pitch`", "array.pitch_mm"],
            ),
            (
                "harmonics=2.5",
                &["harmonics = 2.5: choose a whole number, 1 to 5"],
            ),
            ("slide.rule=protocol", &["slide.speed_mm_s = 0", "0.1 to"]),
            (
                "vref_v=high",
                &["vref_v = \"high\": choose a number, 0.5 to 5.5"],
            ),
            ("array.front=-1", &["array.front = -1", "16 bits"]),
            (
                "array.alike=[1, 2]",
                &["array.alike = [1, 2]", "four masks"],
            ),
            ("array.may_go_forward=1", &["= 1: choose true or false"]),
            ("harmonics=300", &["300"]),
            ("window_s", &["NAME=VALUE"]),
            ("slide.rule=neither", &["neither", "found", "protocol"]),
            (
                "slide.speed=3",
                &["no setting `slide.speed`", "slide.speed_mm_s"],
            ),
            ("array=3", &["array = 3", "array.pitch_mm"]),
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
        std::fs::write(&path, "window_s = 0.5\nstride_s = \n").unwrap();
        let text = format!("{:#}", load(&path).unwrap_err());
        assert!(
            text.contains("wrong.toml") && text.contains("line 2"),
            "{text}"
        );
    }

    /// Reads a file from a board with a different converter, and a plan of an unknown converter.
    #[test]
    fn a_plan_of_any_converter_is_read_as_it_was_written() {
        let onboard = OnboardPlan {
            inputs: 0x00ff,
            scans: 190,
            clock_mhz: 25,
        };
        let mut other = Plan::of_frames(1000.0, 3).unwrap();
        other.own.converter = 77;
        for plan in [onboard.plan(), Plan::of_frames(240.0, 16).unwrap(), other] {
            let settings = Settings::DEFAULT.with_plan(plan);
            let given = toml(&settings).unwrap().parse().unwrap();
            assert_eq!(over(&Settings::DEFAULT, given).unwrap(), settings);
            let given = toml(&Settings::DEFAULT.with_plan(Plan::HAND)).unwrap();
            assert_eq!(
                over(&settings, given.parse().unwrap()).unwrap().plan,
                Plan::HAND
            );
        }
    }
}
