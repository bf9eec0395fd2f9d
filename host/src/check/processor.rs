//! The processor and its firmware: version, start, clock, load, stack.

use super::run::Run;
use super::verdict::{Judged, Limits, Measured, Verdict};
use crate::names::name;
use ridgetone_proto::boot::{BrownOut, Oscillator, ResetCause};
use ridgetone_proto::telemetry::PROTOCOL;
use serde_json::json;

use Verdict::{Fail, Pass, Warn};

/// The version of this command.
const VERSION: &str = env!("CARGO_PKG_VERSION");

pub fn firmware(run: &Run<'_>) -> Result<Judged, Judged> {
    let hello = run.hello().map_err(|Judged { finding, .. }| {
        let finding = format!("no greeting: {finding}");
        Judged::new(Fail, finding, json!({ "protocol_here": PROTOCOL }))
    })?;
    let (version, protocol) = (
        hello.version.map(|part| part.to_string()).join("."),
        hello.protocol,
    );
    let values = json!({ "version": version, "protocol": protocol, "command_version": VERSION });
    let (verdict, finding) = match version == VERSION {
        true => (Pass, format!("{version}, protocol {protocol}")),
        false => (
            Warn,
            format!("{version}, and this command is {VERSION}: build both from one version"),
        ),
    };
    Ok(Judged::new(verdict, finding, values))
}

pub fn reset(run: &Run<'_>) -> Result<Judged, Judged> {
    let boot = &run.hello()?.boot;
    let cause = name(boot.cause);
    if let Some(record) = &boot.record {
        let place = if record.file.is_empty() {
            format!("at {:#010x}", record.pc)
        } else {
            format!("in {}:{}", record.file, record.line)
        };
        let death = name(record.death);
        let values = json!({
            "cause": cause, "death": death, "file": record.file.as_str(), "line": record.line,
            "pc": format!("{:#010x}", record.pc), "lr": format!("{:#010x}", record.lr),
            "board_time_s": f64::from(record.t_us) * 1e-6,
        });
        let finding = format!("the run before ended with a {death} {place}; reset cause {cause}");
        return Ok(Judged::new(Warn, finding, values));
    }
    let (verdict, finding) = match boot.cause {
        ResetCause::Unknown => {
            return Err(Judged::skipped(
                "the board does not know the cause: an emulated one",
            ));
        }
        ResetCause::Watchdog => (
            Warn,
            "the watchdog has reset the board: the run before hung".into(),
        ),
        ResetCause::Power | ResetCause::Pin | ResetCause::Software => {
            (Pass, format!("{cause}, no crash record"))
        }
    };
    Ok(Judged::new(verdict, finding, json!({ "cause": cause })))
}

pub fn brown_out(run: &Run<'_>) -> Result<Judged, Judged> {
    let boot = &run.hello()?.boot;
    let level = boot.brown_out;
    let below = match level {
        BrownOut::Unknown => {
            return Err(Judged::skipped(
                "the board does not know the level: an emulated one",
            ));
        }
        BrownOut::Level3 => "level 3, reset below 2.7 V",
        BrownOut::Level2 => "level 2, reset below 2.4 V",
        BrownOut::Level1 => "level 1, reset below 2.1 V",
        BrownOut::Off => "off, the processor runs down to 1.8 V",
    };
    let values = json!({ "level": name(level) });
    if level == BrownOut::Level3 {
        return Ok(Judged::new(Pass, below, values));
    }
    let why =
        "flash is written in words of 32 bits, which needs 2.7 V: set level 3 in the option bytes";
    Ok(Judged::new(Warn, format!("{below}; {why}"), values))
}

pub fn oscillator(run: &Run<'_>) -> Result<Judged, Judged> {
    let boot = &run.hello()?.boot;
    let (verdict, finding) = match boot.oscillator {
        Oscillator::External => (Pass, "external"),
        Oscillator::Internal => (
            Fail,
            "internal: the external one did not start; times are off by up to 1 %, 8 % over temperature",
        ),
        Oscillator::Unknown => {
            return Err(Judged::skipped(
                "the board does not know it: an emulated one",
            ));
        }
    };
    let values = json!({ "oscillator": name(boot.oscillator) });
    Ok(Judged::new(verdict, finding, values))
}

/// A figure that no emulated board has.
const NOT_MEASURED: &str = "the board does not measure it";

pub fn load(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    let load = run.health()?.load;
    if load == 0.0 {
        return Err(Judged::skipped(NOT_MEASURED));
    }
    Ok(Measured {
        value: load.into(),
        finding: format!("{:.1} % of the time busy", 100.0 * load),
        values: json!({ "load": load }),
    })
}

pub fn stack(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    let health = run.health()?;
    let (used, size) = (health.stack_used_bytes, health.stack_bytes);
    if size == 0 {
        return Err(Judged::skipped(NOT_MEASURED));
    }
    let value = f64::from(used) / f64::from(size);
    let percent = 100.0 * value;
    Ok(Measured {
        value,
        finding: format!("{used} of {size} bytes used at most, {percent:.0} %"),
        values: json!({ "used_bytes": used, "size_bytes": size }),
    })
}
