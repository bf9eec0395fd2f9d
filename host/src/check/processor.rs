//! The processor and its firmware: version, start, clock, load, stack.

use super::observations::Observations;
use super::table::{Judged, Limits, Verdict};
use crate::names::name;
use ridgetone_proto::boot::{BrownOut, Oscillator, ResetCause};
use ridgetone_proto::telemetry::{Health, Hello, PROTOCOL};
use serde_json::json;

use Verdict::{Fail, Pass, Warn};

/// The version of this command.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Share of time that the processor is busy. A fit takes what the rest of the work leaves.
const LOAD: Limits = Limits {
    pass: [0.0, 0.5],
    fail: [0.0, 0.85],
};

/// Share of the stack in use. A fit with raw frames on the line takes 69 % (register model).
const STACK: Limits = Limits {
    pass: [0.0, 0.85],
    fail: [0.0, 0.95],
};

pub fn firmware(seen: &Observations) -> Judged {
    let Some(hello) = &seen.hello else {
        let finding = format!("no greeting: {}", seen.why());
        return Judged::new(Fail, finding, json!({ "protocol_here": PROTOCOL }));
    };
    let (version, protocol) = (
        hello.version.map(|part| part.to_string()).join("."),
        hello.protocol,
    );
    let values = json!({ "version": version, "protocol": protocol, "command_version": VERSION });
    if version == VERSION {
        Judged::new(Pass, format!("{version}, protocol {protocol}"), values)
    } else {
        let advice = "build both from one version";
        Judged::new(
            Warn,
            format!("{version}, and this command is {VERSION}: {advice}"),
            values,
        )
    }
}

pub fn reset(hello: &Hello) -> Judged {
    let cause = name(hello.boot.cause);
    if let Some(record) = &hello.boot.record {
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
        return Judged::new(Warn, finding, values);
    }
    let (verdict, finding) = match hello.boot.cause {
        ResetCause::Unknown => {
            return Judged::skipped("the board does not know the cause: an emulated one");
        }
        ResetCause::Watchdog => (
            Warn,
            "the watchdog has reset the board: the run before hung".into(),
        ),
        ResetCause::Power | ResetCause::Pin | ResetCause::Software => {
            (Pass, format!("{cause}, no crash record"))
        }
    };
    Judged::new(verdict, finding, json!({ "cause": cause }))
}

pub fn brown_out(hello: &Hello) -> Judged {
    let level = hello.boot.brown_out;
    let below = match level {
        BrownOut::Unknown => {
            return Judged::skipped("the board does not know the level: an emulated one");
        }
        BrownOut::Level3 => "level 3, reset below 2.7 V",
        BrownOut::Level2 => "level 2, reset below 2.4 V",
        BrownOut::Level1 => "level 1, reset below 2.1 V",
        BrownOut::Off => "off, the processor runs down to 1.8 V",
    };
    let values = json!({ "level": name(level) });
    if level == BrownOut::Level3 {
        return Judged::new(Pass, below, values);
    }
    let why =
        "flash is written in words of 32 bits, which needs 2.7 V: set level 3 in the option bytes";
    Judged::new(Warn, format!("{below}; {why}"), values)
}

pub fn oscillator(hello: &Hello) -> Judged {
    let (verdict, finding) = match hello.boot.oscillator {
        Oscillator::External => (Pass, "external"),
        Oscillator::Internal => (
            Fail,
            "internal: the external one did not start; times are off by up to 1 %, 8 % over temperature",
        ),
        Oscillator::Unknown => {
            return Judged::skipped("the board does not know it: an emulated one");
        }
    };
    Judged::new(
        verdict,
        finding,
        json!({ "oscillator": name(hello.boot.oscillator) }),
    )
}

pub fn load(health: &Health) -> Judged {
    let load = health.load;
    if load == 0.0 {
        return Judged::skipped("the board does not measure it");
    }
    let finding = format!("{:.1} % of the time busy", 100.0 * load);
    Judged::new(LOAD.verdict(load.into()), finding, json!({ "load": load }))
}

pub fn stack(health: &Health) -> Judged {
    let (used, size) = (health.stack_used_bytes, health.stack_bytes);
    if size == 0 {
        return Judged::skipped("the board does not measure it");
    }
    let share = f64::from(used) / f64::from(size);
    let finding = format!(
        "{used} of {size} bytes used at most, {:.0} %",
        100.0 * share
    );
    let values = json!({ "used_bytes": used, "size_bytes": size });
    Judged::new(STACK.verdict(share), finding, values)
}
