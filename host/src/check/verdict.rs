//! The result of one check.

use serde::Serialize;
use serde_json::Value;

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    Pass,
    /// It works, but something should be looked at.
    Warn,
    Fail,
    /// It cannot be judged here; the finding says why.
    Skipped,
}

/// What is connected to the analog inputs.
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

/// One check with its finding in one line.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "check")]
pub struct Check {
    pub name: &'static str,
    pub verdict: Verdict,
    pub finding: String,
    /// The figures of the finding, with units in their names.
    pub values: Value,
    /// The page of the book that helps.
    pub page: &'static str,
}

pub const WIRING: &str = "docs/guide/1-wiring.md";
pub const FIRST_RUN: &str = "docs/guide/2-first-run.md";
pub const PLANS: &str = "docs/guide/3-speed-or-accuracy.md";
pub const TELEMETRY: &str = "docs/guide/4-telemetry.md";
pub const TROUBLESHOOTING: &str = "docs/guide/6-troubleshooting.md";

impl Check {
    pub fn new(
        name: &'static str,
        page: &'static str,
        verdict: Verdict,
        finding: String,
        values: Value,
    ) -> Self {
        Self {
            name,
            verdict,
            finding,
            values,
            page,
        }
    }

    pub fn skipped(name: &'static str, page: &'static str, why: impl Into<String>) -> Self {
        Self::new(
            name,
            page,
            Verdict::Skipped,
            why.into(),
            Value::Object(Default::default()),
        )
    }
}

/// The verdict on a value that fails beyond one limit and warns beyond another.
pub fn graded(warns: bool, fails: bool) -> Verdict {
    match (fails, warns) {
        (true, _) => Verdict::Fail,
        (false, true) => Verdict::Warn,
        (false, false) => Verdict::Pass,
    }
}
