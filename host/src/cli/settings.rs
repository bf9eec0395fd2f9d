//! Settings of the library, from a file and from options that override it. Common settings have
//! options, made from the table of settings; `--set` can change any setting.

use crate::settings_form::{self, from_text, range, shown};
use crate::usage::UsageError;
use anyhow::Result;
use clap::error::Error;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Kind, Setting, Settings, SlideRule, TABLE, Value};
use std::path::PathBuf;

/// Settings of the library.
#[derive(Args, Clone, Debug)]
pub struct SettingsOptions {
    /// Settings to start from, as `settings get` prints them; the options below replace single ones
    /// [default: the library's].
    #[arg(long = "settings", value_name = "FILE.toml")]
    settings_file: Option<PathBuf>,
    /// Any setting by its name in that file, such as array.period_max_mm=3.5. Repeat it for each.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    given: GivenSettings,
}

/// Settings whose options were supplied.
#[derive(Clone, Debug, Default)]
pub struct GivenSettings(Vec<(&'static Setting, Value)>);

/// Setting of a protocol's speed: if it is supplied, slides follow the protocol.
const SPEED: &str = "slide.speed_mm_s";

/// Finds a plan by its name.
pub fn plan(name: &str) -> Result<Plan, String> {
    let names = || Plan::NAMED.map(|(name, _)| name).join(", ");
    Plan::named(name).ok_or_else(|| format!("choose one of {}", names()))
}

/// Returns the settings that have an option.
fn with_option() -> impl Iterator<Item = &'static Setting> {
    TABLE.iter().filter(|setting| !setting.option.is_empty())
}

/// True if the option takes percent.
fn is_fraction(setting: &Setting) -> bool {
    setting.unit == "fraction"
}

fn option(setting: &'static Setting) -> Arg {
    Arg::new(setting.name)
        .long(setting.option)
        .value_name(value_name(setting))
        .help(help(setting))
        .allow_negative_numbers(true)
        .value_parser(move |text: &str| value(setting, text))
}

fn value_name(setting: &Setting) -> &'static str {
    match (setting.kind, setting.unit) {
        (Kind::Plan | Kind::Word(_), _) => "NAME",
        (Kind::Switch, _) => "true|false",
        (_, "fraction") => "PERCENT",
        (_, "") => "N",
        (_, unit) => unit,
    }
}

/// Formats the setting's sentence, the accepted values, and the default.
fn help(setting: &Setting) -> String {
    let sentence = setting.sentence().trim_end_matches('.');
    let unit = match setting.unit {
        "" => String::new(),
        "fraction" => "percent; as a setting a fraction: ".into(),
        unit => format!("{unit}, "),
    };
    let default = shown(&setting.default());
    format!("{sentence} ({unit}{}) [default: {default}]", range(setting))
}

fn value(setting: &Setting, text: &str) -> Result<Value, String> {
    match from_text(setting, text)? {
        Value::Number(percent) if is_fraction(setting) => Ok(Value::Number(percent / 100.0)),
        value => Ok(value),
    }
}

impl FromArgMatches for GivenSettings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let given = |setting: &'static Setting| {
            let value = matches.get_one::<Value>(setting.name)?;
            Some((setting, *value))
        };
        Ok(Self(with_option().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for GivenSettings {
    fn augment_args(command: Command) -> Command {
        command.args(with_option().map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl SettingsOptions {
    /// True if any option was supplied.
    pub fn is_given(&self) -> bool {
        self.settings_file.is_some() || !self.changes.is_empty() || !self.given.0.is_empty()
    }

    /// Returns the library's settings, overridden by these options.
    pub fn settings(&self) -> Result<Settings> {
        let base = match &self.settings_file {
            Some(path) => settings_form::load(path)?,
            None => Settings::DEFAULT,
        };
        self.change(base)
    }

    /// Returns a recording's settings, overridden by these options except for its plan. `name` is
    /// that of the file.
    pub fn over(&self, base: &Settings, name: &str) -> Result<Settings> {
        let file = match &self.settings_file {
            Some(path) => Settings {
                plan: base.plan,
                ..settings_form::load(path)?
            },
            None => *base,
        };
        let settings = self.change(file)?;
        if settings.plan != base.plan {
            let why = format!(
                "{name}: a recording has its own plan, {:.2} frames a second: leave --plan out",
                base.plan.frame_rate_hz()
            );
            return Err(UsageError(why).into());
        }
        Ok(settings)
    }

    fn change(&self, mut settings: Settings) -> Result<Settings> {
        for (setting, value) in &self.given.0 {
            settings_form::set(&mut settings, setting, *value);
            if setting.name == SPEED {
                settings.slide.rule = SlideRule::Protocol;
            }
        }
        settings_form::change(&settings, &self.changes)
    }
}
