//! Writes the report as text, as JSON lines, or as one JSON object.

use super::observations::{Inputs, Observations};
use super::table::{Check, judge};
use super::verdict::Verdict;
use crate::names::name;
use crate::output;
use anyhow::Result;
use ridgetone_proto::telemetry::PROTOCOL;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

/// All checks, with their summary.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub summary: Summary,
    pub checks: Vec<Check>,
}

/// Number of checks by verdict, and the versions of board and command.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "summary")]
pub struct Summary {
    pub verdict: Verdict,
    pub passed: usize,
    pub warned: usize,
    pub failed: usize,
    pub skipped: usize,
    /// Why the run ended early.
    pub ended: Option<String>,
    /// The port with its USB name.
    pub board: String,
    pub inputs: Inputs,
    pub firmware: Option<String>,
    pub protocol: u8,
    pub version: &'static str,
    pub system: String,
}

impl Report {
    /// Judges the observations; `board` is the name of the board's port.
    pub fn new(board: String, seen: &Observations) -> Self {
        let checks = judge(seen);
        let is = |verdict| move |check: &&Check| check.verdict == verdict;
        let count = |verdict| checks.iter().filter(is(verdict)).count();
        let (warned, failed) = (count(Verdict::Warn), count(Verdict::Fail));
        let summary = Summary {
            verdict: Verdict::graded(warned > 0, failed > 0),
            passed: count(Verdict::Pass),
            warned,
            failed,
            skipped: count(Verdict::Skipped),
            ended: seen.ended.clone(),
            board,
            inputs: seen.inputs,
            firmware: seen.version(),
            protocol: PROTOCOL,
            version: env!("CARGO_PKG_VERSION"),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        };
        Self { summary, checks }
    }

    /// Prints the checks on standard output, as text or as one JSON object per line.
    pub fn print(&self, json: bool) -> Result<()> {
        if !json {
            return output::line(self.to_string().trim_end());
        }
        for check in &self.checks {
            output::line(&serde_json::to_string(check)?)?;
        }
        output::line(&serde_json::to_string(&self.summary)?)
    }

    /// Writes a new file: JSON if its name ends in `.json`, else text.
    pub fn write(&self, path: &Path) -> Result<()> {
        let is_json = path
            .extension()
            .is_some_and(|extension| extension == "json");
        let text = match is_json {
            true => serde_json::to_string_pretty(self)? + "\n",
            false => self.to_string(),
        };
        output::new_text(path, &text)
    }

    pub fn failed(&self) -> Vec<&'static str> {
        let failed = self
            .checks
            .iter()
            .filter(|check| check.verdict == Verdict::Fail);
        failed.map(|check| check.name).collect()
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let all = &self.summary;
        let (board, version, protocol) = (&all.board, all.version, all.protocol);
        let firmware = all.firmware.as_deref().unwrap_or("unknown");
        writeln!(
            f,
            "{board}: firmware {firmware}; ridgetone {version}, protocol {protocol}, {}",
            all.system
        )?;
        for check in &self.checks {
            let (verdict, what) = (name(check.verdict), check.name);
            write!(f, "{verdict:<8}{what:<15}{}", check.finding)?;
            if check.verdict >= Verdict::Warn {
                write!(f, " -> {}", check.page)?;
            }
            writeln!(f)?;
        }
        if let Some(why) = &all.ended {
            writeln!(f, "It ended early: {why}")?;
        }
        writeln!(
            f,
            "{} passed, {} warned, {} failed, {} skipped",
            all.passed, all.warned, all.failed, all.skipped
        )
    }
}
