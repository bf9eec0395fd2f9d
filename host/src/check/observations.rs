//! Observations that `check` makes of a board; tests construct their own.

use super::signals::Clock;
use super::verdict::{Judged, Verdict, judged, skipped};
use crate::live::Counts;
use ridgetone_proto::plan::{Converters, HealthReadings, Plan};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{ConverterState, Health, Hello, Raw};
use serde::Serialize;
use serde_json::json;

/// Connection of the analog inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Inputs {
    /// Nothing: pick-up and noise are measured, but not judged.
    Open,
    /// Each input is connected to AINCOM: noise is compared with the datasheet.
    Shorted,
    /// The sensors, which nothing touches.
    #[default]
    InUse,
}

/// Everything that the checks judge; `None` where the run did not get that far.
#[derive(Clone, Debug, Default)]
pub struct Observations {
    pub inputs: Inputs,
    /// The first greeting.
    pub hello: Option<Hello>,
    /// The first `health`.
    pub health: Option<Health>,
    /// The converter as the board reported it.
    pub converter: Option<ConverterState>,
    pub exchanged: Option<Exchanged>,
    pub watched: Option<Watched>,
    /// Result of the storage test; `None` if settings were not to be stored.
    pub kept: Option<Kept>,
    /// Result of replacing the board's plan; `None` if the board already uses the default plan.
    pub lent: Option<Lent>,
    /// Why the run ended early.
    pub ended: Option<String>,
}

/// Results of sending commands of every length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exchanged {
    /// Number of different commands.
    pub commands: u32,
    /// Number of commands that were answered correctly.
    pub answered: u32,
    /// Number of commands sent, including repetitions.
    pub sends: u32,
    pub shortest_bytes: usize,
    pub longest_bytes: usize,
}

/// A period in which only the board's telemetry was on the line.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    pub before: Health,
    pub after: Health,
    /// Packet counts at this end of the line, before and after the period.
    pub counts_before: Counts,
    pub counts_after: Counts,
    pub frames: Vec<Raw>,
    /// Device times of contacts and of the releases that follow, microseconds.
    pub touches_us: Vec<(u64, Option<u64>)>,
    /// True if the board has restarted by itself.
    pub has_restarted: bool,
}

/// Result of replacing the board's own plan by the default one.
#[derive(Clone, Debug)]
pub struct Lent {
    /// The board's own plan.
    pub plan: Plan,
    /// Why the board's own plan could not be put in force again.
    pub failed: Option<String>,
}

/// Result of storing settings, restarting the board, and restoring the earlier settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    pub sent: Option<Settings>,
    /// Settings in force after the restart, if they came from the flash.
    pub found: Option<Settings>,
    /// True if the flash may hold different settings than before.
    pub may_have_changed: bool,
    /// True if the flash was erased during the test.
    pub has_erased: bool,
    /// Why settings were not stored, or not found after the restart.
    pub failed: Option<String>,
    /// Why the earlier settings could not be restored.
    pub not_restored: Option<String>,
}

/// Time in microseconds before a contact and after a release that also counts as touched: a contact
/// is not noticed at once, and the skin settles after a release.
const MARGIN_US: u64 = 300_000;

impl Watched {
    /// Returns the length of the period by the board's clock, seconds.
    pub fn length_s(&self) -> f64 {
        self.after.t_us.saturating_sub(self.before.t_us) as f64 * 1e-6
    }

    /// True if nothing touched the finger at the device time `t_us` (microseconds).
    pub fn is_untouched(&self, t_us: u64) -> bool {
        !self.touches_us.iter().any(|(contact_us, release_us)| {
            t_us + MARGIN_US >= *contact_us
                && release_us.is_none_or(|release_us| t_us <= release_us + MARGIN_US)
        })
    }

    /// Returns runs of consecutive frames without a touch.
    pub fn untouched(&self) -> Vec<&[Raw]> {
        let is_untouched = |frame: &Raw| self.is_untouched(frame.t_us);
        let runs = self.frames.chunk_by(|a, b| {
            a.number.checked_add(1) == Some(b.number) && is_untouched(a) && is_untouched(b)
        });
        runs.filter(|run| run.first().is_some_and(is_untouched))
            .collect()
    }
}

impl Observations {
    /// Returns a part, or skips the check with the reason why the part is missing.
    pub fn need<'a, T>(&'a self, part: &'a Option<T>) -> Result<&'a T, Judged> {
        part.as_ref().ok_or_else(|| skipped(self.why()))
    }

    /// Returns the latest `health` before the board was restarted.
    pub fn health(&self) -> Result<&Health, Judged> {
        let latest = self.watched.as_ref().map(|watched| &watched.after);
        latest.map_or_else(|| self.need(&self.health), Ok)
    }

    /// Returns the health report with the converter's readings of itself.
    pub fn readings(&self) -> Result<&Health, Judged> {
        if self.judged().health == HealthReadings::Never {
            return Err(skipped("this converter has no readings of its own"));
        }
        match self.health()? {
            health if health.frames == 0 => Err(skipped("no scan was read")),
            health => Ok(health),
        }
    }

    /// Returns the raw frames received while the board was only watched.
    pub fn frames(&self) -> Result<&[Raw], Judged> {
        match &self.need(&self.watched)?.frames[..] {
            [] => Err(judged(Verdict::Fail, "no frame was read", json!({}))),
            frames => Ok(frames),
        }
    }

    /// Returns the clock from at least a second of one scan, because a restarted scan has a
    /// different phase.
    pub fn clock(&self) -> Result<Clock, Judged> {
        let (frames, watched) = (self.frames()?, self.need(&self.watched)?);
        let is_one_scan = watched.before.chip_restarts == watched.after.chip_restarts;
        let clock = is_one_scan.then(|| Clock::of(frames)).flatten();
        clock.ok_or_else(|| skipped("no second of frames without a restart of the scan"))
    }

    /// Returns the reference voltage from the board's settings; the measured one if no `hello` has
    /// been received.
    pub fn vref_v(&self) -> f32 {
        let measured = || self.health().map_or(0.0, |health| health.reference_v);
        let set = self.hello.as_ref().map(|hello| hello.settings.vref_v);
        set.unwrap_or_else(measured)
    }

    /// Returns the microvolts per code: 1 LSB is VREF / 780000h (SBAS297G, data format).
    pub fn uv_per_code(&self) -> f64 {
        1e6 * f64::from(self.vref_v()) / 7_864_320.0
    }

    /// Returns the plan by which frames are judged.
    pub fn judged(&self) -> Plan {
        let own = self.hello.as_ref().map(|hello| hello.settings.plan);
        own.map_or(Plan::PAPER, |plan| judged_plan(&plan))
    }

    pub fn version(&self) -> Option<String> {
        let hello = self.hello.as_ref()?;
        Some(hello.version.map(|part| part.to_string()).join("."))
    }

    /// Returns the reason why something was not observed.
    pub fn why(&self) -> &str {
        self.ended.as_deref().unwrap_or("the board has not sent it")
    }
}

/// Returns the plan by which a board's frames are judged: for an ADS1258 the default plan at the
/// board's clock, for a different converter the board's own.
pub const fn judged_plan(own: &Plan) -> Plan {
    match own.own.converter == Converters::ADS1258 {
        true => Plan::PAPER.with_clock(own.adc_clock_hz),
        false => *own,
    }
}

/// Formats a mask of inputs as names: "AIN3, AIN7".
pub fn input_names(mask: u16) -> String {
    let present = (0..TAXELS).filter(|input| mask >> input & 1 != 0);
    present
        .map(|input| format!("AIN{input}"))
        .collect::<Vec<_>>()
        .join(", ")
}
