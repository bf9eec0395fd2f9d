//! Verdicts, and the limits that give them.

use serde::Serialize;
use serde_json::{Value, json};

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

impl Verdict {
    /// Fails if one thing is so, and warns if another is.
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

/// A value that has limits, with its finding.
pub struct Measured {
    pub value: f64,
    pub finding: String,
    pub values: Value,
}

/// The range of values that pass, and the one beyond which a check fails.
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

    /// Limits of a value that is zero at best.
    pub const fn up_to(pass: f64, fail: f64) -> Self {
        Self {
            pass: [0.0, pass],
            fail: [0.0, fail],
        }
    }

    /// The verdict on a value. One that is not a number fails.
    pub fn verdict(&self, value: f64) -> Verdict {
        let is_within = |[min, max]: [f64; 2]| (min..=max).contains(&value);
        Verdict::graded(!is_within(self.pass), !is_within(self.fail))
    }
}
