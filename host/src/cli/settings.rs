//! Settings of the library, from a file and from options over it.

use super::array::ArrayOptions;
use crate::settings_form;
use crate::usage::UsageError;
use anyhow::Result;
use clap::Args;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, SlideRule};
use std::path::PathBuf;

/// Settings of the library.
#[derive(Args, Clone, Debug)]
pub struct SettingsOptions {
    /// Settings to start from, as `settings get` prints them; the options below replace single ones
    /// [default: the library's].
    #[arg(long = "settings", value_name = "FILE.toml")]
    pub settings_file: Option<PathBuf>,
    /// Scan plan: paper (16 inputs at 241 Hz), hand (16 at 1.46 kHz), texture (4 at 5.8 kHz),
    /// vibration (2 at 11.7 kHz) or single (1 at 23.3 kHz), with its default window and hop
    /// [default: paper].
    #[arg(long, value_name = "NAME", value_parser = plan)]
    pub plan: Option<Plan>,
    /// Length of a window, seconds, with plan paper 0.1 to 3.9 [default: 1, or the plan's longest].
    #[arg(long, value_name = "S")]
    pub window: Option<f32>,
    /// From the start of one window to that of the next, seconds [default: 0.25, or a quarter of
    /// the window, at least 0.05].
    #[arg(long, value_name = "S")]
    pub hop: Option<f32>,
    /// Most harmonics to fit, 1 to 5 [default: 4].
    #[arg(long, value_name = "N")]
    pub harmonics: Option<u8>,
    /// Required accuracy, percent of the frequency (one standard deviation): a window grows by
    /// --hop until its estimate meets it, or up to --window [default: windows of fixed length].
    #[arg(long, value_name = "PERCENT")]
    pub accuracy: Option<f32>,
    /// Known interferer in all channels, hertz, such as mains of 50 or 60 [default: none].
    #[arg(long, value_name = "HZ")]
    pub mains: Option<f32>,
    /// Speed of the stimulus, mm/s: the slide follows the protocol [default: it is found in the
    /// signal].
    #[arg(long, value_name = "MM_S")]
    pub speed: Option<f32>,
    /// By the protocol: from contact to slide, seconds.
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "speed")]
    pub delay: f32,
    /// By the protocol: length of the slide to use, mm.
    #[arg(long, value_name = "MM", default_value_t = 55.0, requires = "speed")]
    pub length: f32,
    #[command(flatten)]
    pub array: ArrayOptions,
}

/// A plan by its name.
pub fn plan(name: &str) -> Result<Plan, String> {
    let names = || Plan::NAMED.map(|(name, _)| name).join(", ");
    Plan::named(name).ok_or_else(|| format!("choose one of {}", names()))
}

impl SettingsOptions {
    pub fn settings(&self) -> Result<Settings> {
        let base = self
            .settings_file
            .as_deref()
            .map_or(Ok(Settings::DEFAULT), settings_form::load)?;
        let base = self.plan.map_or(base, |plan| base.with_plan(plan));
        // A zero would switch the setting off; as an option it is out of bounds.
        let not_zero = |value: f32| if value == 0.0 { f32::NAN } else { value };
        let settings = Settings {
            window_s: self.window.unwrap_or(base.window_s),
            hop_s: self.hop.unwrap_or(base.hop_s),
            harmonics: self.harmonics.unwrap_or(base.harmonics),
            accuracy: self
                .accuracy
                .map_or(base.accuracy, |percent| not_zero(percent) / 100.0),
            interferer_hz: self.mains.map_or(base.interferer_hz, not_zero),
            slide: self
                .speed
                .map_or(base.slide, |speed_mm_s| SlideRule::Protocol {
                    delay_s: self.delay,
                    speed_mm_s,
                    length_mm: self.length,
                }),
            array: self.array.array(base.array),
            ..base
        };
        settings
            .validate()
            .map_err(|error| UsageError(settings_form::explained(&error)))?;
        Ok(settings)
    }
}
