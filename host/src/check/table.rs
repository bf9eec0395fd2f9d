//! The table of checks.

use super::converter::{gain, id, offset, reference, registers, restarts, supply, temperature};
use super::frames;
use super::frames::{FrameStatistics, drdy_jitter, frame_rate, mains, noise};
use super::line::{commands, faults, losses, plan, settings};
use super::observations::{Lent, Observations, Watched};
use super::processor::{brown_out, firmware, load, oscillator, reset, stack};
use ridgetone_proto::plan::HealthReadings;
use ridgetone_proto::telemetry::{ConverterState, Health, Hello};
use serde::Serialize;
use serde_json::{Value, json};

use Sees::{Converter, Frames, Listening, OtherPlan, Readings, Report, Run, Start};

/// Sections of the guide.
const WIRING: &str = "docs/guide/2-build.md#wiring";
const FLASHING: &str = "docs/guide/2-build.md#flash-and-check";
const PLANS: &str = "docs/guide/3-speed-or-accuracy.md#scan-plans";
pub const TROUBLESHOOTING: &str = "docs/guide/2-build.md#what-ridgetone-check-finds";

/// Every check: its name, what it looks at and its verdict on that, and the page that helps.
pub const TABLE: [Row; 24] = [
    row("firmware", Run(firmware), FLASHING),
    row("reset", Start(reset), TROUBLESHOOTING),
    row("brown_out", Start(brown_out), WIRING),
    row("oscillator", Start(oscillator), TROUBLESHOOTING),
    row("load", Report(load), TROUBLESHOOTING),
    row("stack", Report(stack), TROUBLESHOOTING),
    row("adc_id", Converter(id), WIRING),
    row("adc_registers", Converter(registers), WIRING),
    row("adc_restarts", Run(restarts), TROUBLESHOOTING),
    row("supply", Readings(supply), WIRING),
    row("reference", Readings(reference), WIRING),
    row("temperature", Readings(temperature), WIRING),
    row("offset", Readings(offset), WIRING),
    row("gain", Readings(gain), WIRING),
    row("frame_rate", Frames(frame_rate), TROUBLESHOOTING),
    row("drdy_jitter", Frames(drdy_jitter), TROUBLESHOOTING),
    row("inputs", Frames(frames::inputs), WIRING),
    row("noise", Frames(noise), WIRING),
    row("mains", Frames(mains), TROUBLESHOOTING),
    row("commands", Run(commands), TROUBLESHOOTING),
    row("settings", Run(settings), TROUBLESHOOTING),
    row("losses", Listening(losses), TROUBLESHOOTING),
    row("faults", Listening(faults), TROUBLESHOOTING),
    row("plan", OtherPlan(plan), PLANS),
];

/// One check of the table.
pub struct Row {
    pub name: &'static str,
    pub sees: Sees,
    pub page: &'static str,
}

const fn row(name: &'static str, sees: Sees, page: &'static str) -> Row {
    Row { name, sees, page }
}

/// What a check looks at, and its verdict on that. Without it the check is skipped.
pub enum Sees {
    /// The first greeting.
    Start(fn(&Hello) -> Judged),
    /// The latest report of the board's health.
    Report(fn(&Health) -> Judged),
    /// The latest report of the converter.
    Converter(fn(&ConverterState) -> Judged),
    /// The converter's readings of itself, and the setting `vref_v`.
    Readings(fn(&Health, f32) -> Judged),
    /// Raw frames and statistics of them.
    Frames(fn(&FrameStatistics) -> Judged),
    /// The time in which the board was only listened to.
    Listening(fn(&Watched) -> Judged),
    /// The board's own scan plan, if it is not the default one. Not reported otherwise.
    OtherPlan(fn(&Lent) -> Judged),
    /// The whole run.
    Run(fn(&Observations) -> Judged),
}

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It cannot be judged here; the finding says why.
    Skipped,
    Pass,
    /// It works, but something should be looked at.
    Warn,
    Fail,
}

/// A verdict with the finding in one line.
pub struct Judged {
    pub verdict: Verdict,
    pub finding: String,
    /// The figures of the finding, with units in their names.
    pub values: Value,
}

impl Judged {
    pub fn new(verdict: Verdict, finding: impl Into<String>, values: Value) -> Self {
        Self {
            verdict,
            finding: finding.into(),
            values,
        }
    }

    pub fn skipped(why: impl Into<String>) -> Self {
        Self::new(Verdict::Skipped, why, json!({}))
    }
}

/// The least and the greatest value that pass, and those beyond which a check fails.
#[derive(Clone, Copy)]
pub struct Limits {
    pub pass: [f64; 2],
    pub fail: [f64; 2],
}

impl Limits {
    /// Limits of a deviation to either side.
    pub const fn off(pass: f64, fail: f64) -> Self {
        Self {
            pass: [-pass, pass],
            fail: [-fail, fail],
        }
    }

    /// The verdict on a value. One that is not a number fails.
    pub fn verdict(&self, value: f64) -> Verdict {
        let is_within = |[least, most]: [f64; 2]| (least..=most).contains(&value);
        if is_within(self.pass) {
            Verdict::Pass
        } else if is_within(self.fail) {
            Verdict::Warn
        } else {
            Verdict::Fail
        }
    }
}

/// The verdict on what fails if one thing is so, and warns if another is.
pub fn graded(warns: bool, fails: bool) -> Verdict {
    if fails {
        Verdict::Fail
    } else if warns {
        Verdict::Warn
    } else {
        Verdict::Pass
    }
}

/// A line of the report.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "check")]
pub struct Check {
    pub name: &'static str,
    pub verdict: Verdict,
    pub finding: String,
    pub values: Value,
    /// The section of the guide that helps.
    pub page: &'static str,
}

/// Judges what was seen, row by row.
pub fn judge(seen: &Observations) -> Vec<Check> {
    let statistics = seen
        .watched
        .as_ref()
        .map(|watched| FrameStatistics::new(watched, seen));
    let not_seen = || Judged::skipped(seen.why());
    let judged = |row: &Row| {
        let health = seen.latest();
        Some(match row.sees {
            Start(judge) => seen.hello.as_ref().map_or_else(not_seen, judge),
            Report(judge) => health.map_or_else(not_seen, judge),
            Converter(judge) => seen.converter.as_ref().map_or_else(not_seen, judge),
            Readings(_) if seen.judged().health == HealthReadings::Never => {
                Judged::skipped("this converter has no readings of its own")
            }
            Readings(judge) => match health {
                Some(health) if health.frames > 0 => judge(health, seen.vref_v()),
                Some(_) => Judged::skipped("no scan was read"),
                None => not_seen(),
            },
            Frames(judge) => match &statistics {
                Some(statistics) if statistics.watched.frames.is_empty() => {
                    Judged::new(Verdict::Fail, "no frame was read", json!({}))
                }
                Some(statistics) => judge(statistics),
                None => not_seen(),
            },
            Listening(judge) => seen.watched.as_ref().map_or_else(not_seen, judge),
            OtherPlan(judge) => judge(seen.lent.as_ref()?),
            Run(judge) => judge(seen),
        })
    };
    let check = |row: &Row| {
        let Judged {
            verdict,
            finding,
            values,
        } = judged(row)?;
        Some(Check {
            name: row.name,
            verdict,
            finding,
            values,
            page: row.page,
        })
    };
    TABLE.iter().filter_map(check).collect()
}
