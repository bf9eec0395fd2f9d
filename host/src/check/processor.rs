//! The processor and its firmware: version, start, clock, load, stack.

use super::observations::Observations;
use super::verdict::{Check, FIRST_RUN, TROUBLESHOOTING, Verdict, WIRING, graded};
use crate::names::name;
use ridgetone_proto::boot::{BrownOut, Oscillator, ResetCause};
use ridgetone_proto::telemetry::{Hello, PROTOCOL};
use serde_json::json;

/// The version of this command.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Share of time that the processor is busy. A fit takes what the rest of the work leaves.
const LOAD: (f32, f32) = (0.5, 0.85);

/// Share of the stack in use. A fit with raw frames on the line takes 69 % (register model).
const STACK: (f32, f32) = (0.85, 0.95);

pub fn checks(seen: &Observations) -> Vec<Check> {
    let firmware = firmware(seen);
    let Some(hello) = &seen.hello else {
        let skipped = [
            ("reset", TROUBLESHOOTING),
            ("brown_out", WIRING),
            ("oscillator", TROUBLESHOOTING),
        ];
        let skipped = skipped.map(|(name, page)| Check::skipped(name, page, seen.why()));
        return std::iter::once(firmware)
            .chain(skipped)
            .chain([load(seen), stack(seen)])
            .collect();
    };
    vec![
        firmware,
        reset(hello),
        brown_out(hello),
        oscillator(hello),
        load(seen),
        stack(seen),
    ]
}

fn firmware(seen: &Observations) -> Check {
    let check =
        |verdict, finding, values| Check::new("firmware", FIRST_RUN, verdict, finding, values);
    let Some(hello) = &seen.hello else {
        return check(
            Verdict::Fail,
            format!("no greeting: {}", seen.why()),
            json!({ "protocol_here": PROTOCOL }),
        );
    };
    let version = hello.version.map(|part| part.to_string()).join(".");
    let values =
        json!({ "version": version, "protocol": hello.protocol, "command_version": VERSION });
    match version == VERSION {
        true => check(
            Verdict::Pass,
            format!("{version}, protocol {}", hello.protocol),
            values,
        ),
        false => check(
            Verdict::Warn,
            format!("{version}, and this command is {VERSION}: build both from one version"),
            values,
        ),
    }
}

fn reset(hello: &Hello) -> Check {
    let boot = &hello.boot;
    let cause = name(boot.cause);
    let check =
        |verdict, finding, values| Check::new("reset", TROUBLESHOOTING, verdict, finding, values);
    if let Some(record) = &boot.record {
        let place = match record.file.is_empty() {
            true => format!("at {:#010x}", record.pc),
            false => format!("in {}:{}", record.file, record.line),
        };
        let death = name(record.death);
        let finding = format!("the run before ended with a {death} {place}; reset cause {cause}");
        let values = json!({
            "cause": cause, "death": death, "file": record.file.as_str(), "line": record.line,
            "pc": format!("{:#010x}", record.pc), "lr": format!("{:#010x}", record.lr),
            "board_time_s": f64::from(record.t_us) * 1e-6,
        });
        return check(Verdict::Warn, finding, values);
    }
    let values = json!({ "cause": cause });
    match boot.cause {
        ResetCause::Unknown => Check::skipped(
            "reset",
            TROUBLESHOOTING,
            "the board does not know the cause: an emulated one",
        ),
        ResetCause::Watchdog => check(
            Verdict::Warn,
            "the watchdog has reset the board: the run before hung".into(),
            values,
        ),
        ResetCause::Power | ResetCause::Pin | ResetCause::Software => {
            check(Verdict::Pass, format!("{cause}, no crash record"), values)
        }
    }
}

fn brown_out(hello: &Hello) -> Check {
    let level = hello.boot.brown_out;
    let values = json!({ "level": name(level) });
    let why =
        "flash is written in words of 32 bits, which needs 2.7 V: set level 3 in the option bytes";
    match level {
        BrownOut::Unknown => Check::skipped(
            "brown_out",
            WIRING,
            "the board does not know the level: an emulated one",
        ),
        BrownOut::Level3 => Check::new(
            "brown_out",
            WIRING,
            Verdict::Pass,
            "level 3, reset below 2.7 V".into(),
            values,
        ),
        BrownOut::Off | BrownOut::Level1 | BrownOut::Level2 => {
            let below = match level {
                BrownOut::Level2 => "level 2, reset below 2.4 V",
                BrownOut::Level1 => "level 1, reset below 2.1 V",
                _ => "off, the processor runs down to 1.8 V",
            };
            Check::new(
                "brown_out",
                WIRING,
                Verdict::Warn,
                format!("{below}; {why}"),
                values,
            )
        }
    }
}

fn oscillator(hello: &Hello) -> Check {
    let values = json!({ "oscillator": name(hello.boot.oscillator) });
    let check = |verdict, finding: &str, values| {
        Check::new(
            "oscillator",
            TROUBLESHOOTING,
            verdict,
            finding.into(),
            values,
        )
    };
    match hello.boot.oscillator {
        Oscillator::External => check(Verdict::Pass, "external", values),
        Oscillator::Internal => check(
            Verdict::Fail,
            "internal: the external one did not start; times are off by up to 1 %, 8 % over temperature",
            values,
        ),
        Oscillator::Unknown => Check::skipped(
            "oscillator",
            TROUBLESHOOTING,
            "the board does not know it: an emulated one",
        ),
    }
}

fn load(seen: &Observations) -> Check {
    let page = TROUBLESHOOTING;
    match seen.latest().map(|health| health.load) {
        None => Check::skipped("load", page, seen.why()),
        Some(0.0) => Check::skipped("load", page, "the board does not measure it"),
        Some(load) => {
            let verdict = graded(load > LOAD.0, load > LOAD.1);
            Check::new(
                "load",
                page,
                verdict,
                format!("{:.1} % of the time busy", 100.0 * load),
                json!({ "load": load }),
            )
        }
    }
}

fn stack(seen: &Observations) -> Check {
    let Some(health) = seen.latest() else {
        return Check::skipped("stack", TROUBLESHOOTING, seen.why());
    };
    let (used, size) = (health.stack_used_bytes, health.stack_bytes);
    if size == 0 {
        return Check::skipped("stack", TROUBLESHOOTING, "the board does not measure it");
    }
    let share = used as f32 / size as f32;
    let values = json!({ "used_bytes": used, "size_bytes": size });
    let finding = format!(
        "{used} of {size} bytes used at most, {:.0} %",
        100.0 * share
    );
    Check::new(
        "stack",
        TROUBLESHOOTING,
        graded(share > STACK.0, share > STACK.1),
        finding,
        values,
    )
}
