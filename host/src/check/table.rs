//! The table of checks.

use super::converter::{gain, id, offset, reference, registers, restarts, supply, temperature};
use super::frames::{drdy_jitter, frame_rate, inputs, mains, noise};
use super::line::{commands, faults, losses, plan, settings};
use super::observations::Observations;
use super::processor::{brown_out, firmware, load, oscillator, reset, stack};
use super::verdict::{Judged, Limits, Outcome, Verdict};
use serde::Serialize;
use serde_json::Value;

use Judge::{State, Within};

/// Sections of the guide, as links from the checks.
const WIRING: &str = "docs/guide/2-build.md#wiring";
const FLASHING: &str = "docs/guide/2-build.md#flash-and-check";
const PLANS: &str = "docs/guide/3-speed-or-accuracy.md#scan-plans";
pub const TROUBLESHOOTING: &str = "docs/guide/2-build.md#what-ridgetone-check-finds";

/// Fraction of time that the processor is busy. A fit gets the time that other work leaves.
const LOAD: Limits = Limits::up_to(0.5, 0.85);
/// Fraction of the stack in use. A fit with raw frames on the line takes 69 % (register model).
const STACK: Limits = Limits::up_to(0.85, 0.95);
/// Supply of the analog part in volts: 5 V +-5 % (SBAS297G, operating conditions).
const SUPPLY_V: Limits = Limits::between([4.75, 5.25], [4.75, 5.25]);
/// Maximum deviation of the reference from the setting, as a fraction: half of the firmware's limit
/// for the fault `reference`, and that limit.
const REFERENCE: Limits = Limits::off(0.01, 0.02);
/// Temperatures that pass without a warning, and the operating range of the chip (SBAS297G, -40 to
/// 105), degrees Celsius.
const TEMPERATURE_C: Limits = Limits::between([5.0, 60.0], [-40.0, 105.0]);
/// Offset in volts. The limits are ours: 55 and 220 times the noise of one reading. SBAS297G states
/// a typical drift, 0.02 uV per degree, but no limit.
const OFFSET_V: Limits = Limits::off(250e-6, 1e-3);
/// Maximum deviation of the gain from 1. The limits are ours: voltages have the same relative
/// error. The reference's own tolerance cancels.
const GAIN: Limits = Limits::off(0.005, 0.02);
/// Deviation of the rate from nominal, ppm: the largest expected of two crystals with their
/// capacitors, and the firmware's limit for the fault `clock`.
const RATE_PPM: Limits = Limits::off(200.0, 5000.0);
/// Noise relative to the datasheet, whose figures are typical.
const NOISE: Limits = Limits::up_to(1.5, 3.0);
/// Pick-up in microvolts rms: twice the converter's noise, and a sizeable fraction of a touch,
/// which makes millivolts.
const PICK_UP_UV: Limits = Limits::up_to(10.0, 1000.0);

/// Every check: its name, how it is judged, and the page that helps.
pub const TABLE: [Row; 24] = [
    row("firmware", State(firmware), FLASHING),
    row("reset", State(reset), TROUBLESHOOTING),
    row("brown_out", State(brown_out), WIRING),
    row("oscillator", State(oscillator), TROUBLESHOOTING),
    row("load", Within(LOAD, load), TROUBLESHOOTING),
    row("stack", Within(STACK, stack), TROUBLESHOOTING),
    row("adc_id", State(id), WIRING),
    row("adc_registers", State(registers), WIRING),
    row("adc_restarts", State(restarts), TROUBLESHOOTING),
    row("supply", Within(SUPPLY_V, supply), WIRING),
    row("reference", Within(REFERENCE, reference), WIRING),
    row("temperature", Within(TEMPERATURE_C, temperature), WIRING),
    row("offset", Within(OFFSET_V, offset), WIRING),
    row("gain", Within(GAIN, gain), WIRING),
    row("frame_rate", Within(RATE_PPM, frame_rate), TROUBLESHOOTING),
    row("drdy_jitter", State(drdy_jitter), TROUBLESHOOTING),
    row("inputs", State(inputs), WIRING),
    row("noise", Within(NOISE, noise), WIRING),
    row("mains", Within(PICK_UP_UV, mains), TROUBLESHOOTING),
    row("commands", State(commands), TROUBLESHOOTING),
    row("settings", State(settings), TROUBLESHOOTING),
    row("losses", State(losses), TROUBLESHOOTING),
    row("faults", State(faults), TROUBLESHOOTING),
    row(PLAN, State(plan), PLANS),
];

/// Name of the check of a board's own scan plan, reported only if it is not the default plan.
const PLAN: &str = "plan";

pub struct Row {
    pub name: &'static str,
    pub page: &'static str,
    judge: Judge,
}

enum Judge {
    Within(Limits, fn(&Observations, Limits) -> Outcome),
    State(fn(&Observations) -> Outcome),
}

const fn row(name: &'static str, judge: Judge, page: &'static str) -> Row {
    Row { name, page, judge }
}

/// A line of the report.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "check")]
pub struct Check {
    pub name: &'static str,
    pub verdict: Verdict,
    pub finding: String,
    pub values: Value,
    /// Section of the guide that explains what to do.
    pub page: &'static str,
}

/// Judges the observations, row by row.
pub fn judge(seen: &Observations) -> Vec<Check> {
    let rows = TABLE
        .iter()
        .filter(|row| row.name != PLAN || seen.lent.is_some());
    let check = |row: &Row| {
        let outcome = match row.judge {
            State(judge) => judge(seen),
            Within(limits, judge) => judge(seen, limits),
        };
        let Judged {
            verdict,
            finding,
            values,
        } = outcome.unwrap_or_else(|early| early);
        Check {
            name: row.name,
            verdict,
            finding,
            values,
            page: row.page,
        }
    };
    rows.map(check).collect()
}
