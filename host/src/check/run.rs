//! What checks look at, in a run that may have ended before it was there.

use super::observations::{Lent, Observations, Watched};
use super::signals::Clock;
use super::verdict::{Judged, Verdict};
use ridgetone_proto::plan::HealthReadings;
use ridgetone_proto::telemetry::{ConverterState, Health, Hello, Raw};
use serde_json::json;

/// Codes of the reference: 1 LSB is VREF / 780000h (SBAS297G, data format).
const VREF_CODES: f64 = 7_864_320.0;

/// A run, with what several checks need of its frames. Parts that were not seen are a verdict:
/// skipped, with the reason.
pub struct Run<'a> {
    pub seen: &'a Observations,
    clock: Option<Clock>,
    /// Runs of frames without a touch.
    pub untouched: Vec<&'a [Raw]>,
    pub uv_per_code: f64,
}

impl<'a> Run<'a> {
    pub fn new(seen: &'a Observations) -> Self {
        let watched = seen.watched.as_ref();
        // A scan that is restarted has another phase.
        let is_one_scan =
            |watched: &&Watched| watched.before.chip_restarts == watched.after.chip_restarts;
        Self {
            seen,
            clock: watched
                .filter(is_one_scan)
                .and_then(|watched| Clock::of(&watched.frames)),
            untouched: watched.map_or_else(Vec::new, Watched::untouched),
            uv_per_code: 1e6 * f64::from(seen.vref_v()) / VREF_CODES,
        }
    }

    fn there<T>(&self, part: Option<T>) -> Result<T, Judged> {
        part.ok_or_else(|| Judged::skipped(self.seen.why()))
    }

    /// The first greeting.
    pub fn hello(&self) -> Result<&'a Hello, Judged> {
        self.there(self.seen.hello.as_ref())
    }

    /// The latest report of the board's health.
    pub fn health(&self) -> Result<&'a Health, Judged> {
        self.there(self.seen.latest())
    }

    /// The latest report of the converter.
    pub fn converter(&self) -> Result<&'a ConverterState, Judged> {
        self.there(self.seen.converter.as_ref())
    }

    /// The report with the converter's readings of itself.
    pub fn readings(&self) -> Result<&'a Health, Judged> {
        if self.seen.judged().health == HealthReadings::Never {
            return Err(Judged::skipped("this converter has no readings of its own"));
        }
        let health = self.health()?;
        match health.frames {
            0 => Err(Judged::skipped("no scan was read")),
            _ => Ok(health),
        }
    }

    /// The time in which the board was only listened to.
    pub fn watched(&self) -> Result<&'a Watched, Judged> {
        self.there(self.seen.watched.as_ref())
    }

    /// The raw frames of that time.
    pub fn frames(&self) -> Result<&'a [Raw], Judged> {
        match &self.watched()?.frames[..] {
            [] => Err(Judged::new(Verdict::Fail, "no frame was read", json!({}))),
            frames => Ok(frames),
        }
    }

    /// The times of a second of frames of one scan.
    pub fn clock(&self) -> Result<Clock, Judged> {
        self.frames()?;
        let why = "no second of frames without a restart of the scan";
        self.clock.ok_or_else(|| Judged::skipped(why))
    }

    /// The board's own plan, for which the default one was in force.
    pub fn lent(&self) -> Result<&'a Lent, Judged> {
        self.there(self.seen.lent.as_ref())
    }
}
