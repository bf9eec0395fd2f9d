//! Verdicts, and the limits that decide them.

use serde::Serialize;
use serde_json::{Value, json};

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Cannot be judged here; the finding says why.
    Skipped,
    Pass,
    /// Works, but deserves a look.
    Warn,
    Fail,
}

impl Verdict {
    /// Returns `Fail` if `fails`, otherwise `Warn` if `warns`, otherwise `Pass`.
    pub fn graded(warns: bool, fails: bool) -> Self {
        match (warns, fails) {
            (_, true) => Self::Fail,
            (true, false) => Self::Warn,
            (false, false) => Self::Pass,
        }
    }
}

/// A verdict with its finding in one line.
pub struct Judged {
    pub verdict: Verdict,
    pub finding: String,
    /// The figures of the finding, with units in their names.
    pub values: Value,
}

/// Result of a check. An error ends it early, usually because something was not observed.
pub type Outcome = Result<Judged, Judged>;

pub fn judged(verdict: Verdict, finding: impl Into<String>, values: Value) -> Judged {
    let finding = finding.into();
    Judged {
        verdict,
        finding,
        values,
    }
}

pub fn skipped(why: impl Into<String>) -> Judged {
    judged(Verdict::Skipped, why, json!({}))
}

/// Range of values that pass, and range outside which a check fails.
#[derive(Clone, Copy)]
pub struct Limits {
    pub pass: [f64; 2],
    pub fail: [f64; 2],
}

impl Limits {
    /// Limits of a deviation in either direction.
    pub const fn off(pass: f64, fail: f64) -> Self {
        Self::between([-pass, pass], [-fail, fail])
    }

    /// Limits of a value that is never negative and ideally zero.
    pub const fn up_to(pass: f64, fail: f64) -> Self {
        Self::between([0.0, pass], [0.0, fail])
    }

    pub const fn between(pass: [f64; 2], fail: [f64; 2]) -> Self {
        Self { pass, fail }
    }

    /// Returns the verdict on a value. NaN fails.
    pub fn verdict(&self, value: f64) -> Verdict {
        let is_within = |[min, max]: [f64; 2]| (min..=max).contains(&value);
        Verdict::graded(!is_within(self.pass), !is_within(self.fail))
    }

    pub fn judge(&self, value: impl Into<f64>, finding: String, values: Value) -> Outcome {
        Ok(judged(self.verdict(value.into()), finding, values))
    }
}
