//! Checks the processor and its firmware: version, start, clock, load, stack.

use super::observations::Observations;
use super::verdict::{Limits, Outcome, Verdict, judged, skipped};
use crate::names::name;
use ridgetone_proto::boot::{BrownOut, Death, Oscillator, ResetCause};
use ridgetone_proto::telemetry::PROTOCOL;
use serde_json::json;

use Verdict::{Fail, Pass, Warn};

const VERSION: &str = env!("CARGO_PKG_VERSION");

pub fn firmware(seen: &Observations) -> Outcome {
    let (Some(version), Some(hello)) = (seen.version(), &seen.hello) else {
        let finding = format!("no greeting: {}", seen.why());
        return Ok(judged(Fail, finding, json!({ "protocol_here": PROTOCOL })));
    };
    let protocol = hello.protocol;
    let values = json!({ "version": version, "protocol": protocol, "command_version": VERSION });
    Ok(if version == VERSION {
        judged(Pass, format!("{version}, protocol {protocol}"), values)
    } else {
        let what = format!("{version}, and this command is {VERSION}: build both from one version");
        judged(Warn, what, values)
    })
}

pub fn reset(seen: &Observations) -> Outcome {
    let boot = &seen.need(&seen.hello)?.boot;
    let cause = name(boot.cause);
    let values = json!({ "cause": cause });
    if let Some(record) = &boot.record {
        let at = match record.file.is_empty() {
            true => format!("at {:#010x}", record.pc),
            false => format!("in {}:{}", record.file, record.line),
        };
        let death = name(record.death);
        let values = json!({
            "cause": cause, "death": death, "file": record.file.as_str(), "line": record.line,
            "pc": format!("{:#010x}", record.pc), "lr": format!("{:#010x}", record.lr),
            "board_time_s": f64::from(record.t_us) * 1e-6,
        });
        let finding = match record.death {
            Death::Panic | Death::HardFault => {
                format!("the run before ended with a {death} {at}; reset cause {cause}")
            }
            Death::Oscillator => format!(
                "the external oscillator stopped in the run before, {:.1} s after its start",
                f64::from(record.t_us) * 1e-6
            ),
        };
        return Ok(judged(Warn, finding, values));
    }
    Ok(match boot.cause {
        ResetCause::Unknown => skipped("the board does not report the cause"),
        ResetCause::Watchdog => judged(
            Warn,
            "the watchdog has reset the board: the run before hung",
            values,
        ),
        _ => judged(Pass, format!("{cause}, no crash record"), values),
    })
}

pub fn brown_out(seen: &Observations) -> Outcome {
    const WHY: &str =
        "flash is written in words of 32 bits, which needs 2.7 V: set level 3 in the option bytes";
    let level = seen.need(&seen.hello)?.boot.brown_out;
    let (verdict, finding) = match level {
        BrownOut::Unknown => {
            return Err(skipped("the board does not report the level"));
        }
        BrownOut::Level3 => (Pass, "level 3, reset below 2.7 V".to_owned()),
        BrownOut::Level2 => (Warn, format!("level 2, reset below 2.4 V; {WHY}")),
        BrownOut::Level1 => (Warn, format!("level 1, reset below 2.1 V; {WHY}")),
        BrownOut::Off => (
            Warn,
            format!("off, the processor runs down to 1.8 V; {WHY}"),
        ),
    };
    Ok(judged(verdict, finding, json!({ "level": name(level) })))
}

pub fn oscillator(seen: &Observations) -> Outcome {
    const INTERNAL: &str = "internal: the external one did not start; times are off by up to 1 %, 8 % over temperature, and every estimate is doubtful";
    let oscillator = seen.need(&seen.hello)?.boot.oscillator;
    let values = json!({ "oscillator": name(oscillator) });
    Ok(match oscillator {
        Oscillator::External => judged(Pass, "external", values),
        Oscillator::Internal => judged(Fail, INTERNAL, values),
        Oscillator::Unknown => skipped("the board does not report it"),
    })
}

/// Reason for skipping a figure that a board may leave at zero.
const NOT_MEASURED: &str = "the board does not measure it";

pub fn load(seen: &Observations, limits: Limits) -> Outcome {
    let load = seen.health()?.load;
    if load == 0.0 {
        return Err(skipped(NOT_MEASURED));
    }
    let finding = format!("{:.1} % of the time busy", 100.0 * load);
    limits.judge(load, finding, json!({ "load": load }))
}

pub fn stack(seen: &Observations, limits: Limits) -> Outcome {
    let health = seen.health()?;
    let (used, size) = (health.stack_used_bytes, health.stack_bytes);
    if size == 0 {
        return Err(skipped(NOT_MEASURED));
    }
    let value = f64::from(used) / f64::from(size);
    let finding = format!(
        "{used} of {size} bytes used at most, {:.0} %",
        100.0 * value
    );
    limits.judge(
        value,
        finding,
        json!({ "used_bytes": used, "size_bytes": size }),
    )
}
