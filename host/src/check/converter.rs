//! The ADS1258 by its registers and by its own readings.

use super::observations::Observations;
use super::verdict::{Check, TROUBLESHOOTING, Verdict, WIRING, graded};
use ads1258::Register;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::SCAN;
use ridgetone_proto::telemetry::Health;
use serde_json::json;

/// ID4 in the register ID: 0 is the ADS1258, 1 the ADS1158 (SBAS297G, register map).
const ID4: u8 = 1 << 4;

/// Supply of the analog part, volts: 5 V +-5 % (SBAS297G, operating conditions).
const SUPPLY_V: (f32, f32) = (4.75, 5.25);

/// Share by which the reference may be off the setting: half of the firmware's limit for the fault
/// `reference`, and that.
const REFERENCE: (f32, f32) = (0.01, 0.02);

/// Temperatures at which nothing is suspicious, and those at which the chip works (SBAS297G, -40 to
/// 105), degrees Celsius.
const TEMPERATURE_C: [(f32, f32); 2] = [(5.0, 60.0), (-40.0, 105.0)];

/// Offset, volts: own limits, 55 and 220 times the noise of one reading. What is known of SBAS297G
/// has a typical drift, 0.02 uV per degree, and no limit.
const OFFSET_V: (f32, f32) = (250e-6, 1e-3);

/// Share by which the gain may be off 1: own limits, by which a voltage is off too. The reference's
/// own tolerance cancels.
const GAIN: (f32, f32) = (0.005, 0.02);

pub fn checks(seen: &Observations) -> Vec<Check> {
    let names = [
        "adc_id",
        "adc_registers",
        "adc_restarts",
        "supply",
        "reference",
        "temperature",
        "offset",
        "gain",
    ];
    let Some(health) = seen.latest() else {
        return names
            .map(|name| Check::skipped(name, WIRING, seen.why()))
            .into();
    };
    let mut checks = vec![id(health), registers(health), restarts(seen, health)];
    if health.frames == 0 {
        checks.extend(
            names[3..]
                .iter()
                .map(|name| Check::skipped(name, WIRING, "no scan was read")),
        );
        return checks;
    }
    let vref_v = seen
        .hello
        .as_ref()
        .map_or(health.reference_v, |hello| hello.settings.vref_v);
    checks.extend([
        supply(health),
        reference(health, vref_v),
        temperature(health),
        offset(health),
        gain(health),
    ]);
    checks
}

/// What registers that all hold the same say about the wires.
fn stuck(registers: &[u8; 10]) -> Option<&'static str> {
    match registers {
        all if all.iter().all(|byte| *byte == 0xff) => Some(
            "all registers read FF: DOUT is always high; look at DOUT, CS, PWDN and the chip's supply",
        ),
        all if all.iter().all(|byte| *byte == 0) => Some(
            "all registers read 00, or the chip was never set up: DOUT is always low; look at DOUT, SCLK, DIN and DVDD",
        ),
        _ => None,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect::<Vec<_>>()
        .join(" ")
}

fn id(health: &Health) -> Check {
    let id = health.adc_registers[Register::Id as usize];
    let (verdict, finding) = match stuck(&health.adc_registers) {
        Some(why) => (Verdict::Fail, why.to_owned()),
        None if id & ID4 != 0 => (
            Verdict::Fail,
            format!("{id:02X}: bit 4 is set, an ADS1158 of 16 bits, or a bad DOUT"),
        ),
        None => (
            Verdict::Pass,
            format!("{id:02X}, bit 4 is clear: an ADS1258"),
        ),
    };
    Check::new("adc_id", WIRING, verdict, finding, json!({ "id": id }))
}

fn registers(health: &Health) -> Check {
    let found = health.adc_registers;
    // The levels of GPIO pins that are inputs are not the firmware's.
    let written = SCAN.registers().unwrap_or_default();
    let written = &written[..Register::Gpiod as usize];
    let wrong = |register: &Register| {
        written
            .get(*register as usize)
            .is_some_and(|byte| found[*register as usize] != *byte)
    };
    let wrong: Vec<String> = Register::ALL
        .iter()
        .filter(|register| wrong(register))
        .map(|register| {
            let at = *register as usize;
            format!(
                "{register} {:02X} instead of {:02X}",
                found[at], written[at]
            )
        })
        .collect();
    let values = json!({ "found": hex(&found), "written": hex(written) });
    let (verdict, finding) = match (wrong.as_slice(), stuck(&found)) {
        ([], _) => (Verdict::Pass, format!("{} as written", hex(written))),
        (_, Some(why)) => (Verdict::Fail, why.to_owned()),
        (wrong, None) => (Verdict::Fail, wrong.join(", ")),
    };
    Check::new("adc_registers", WIRING, verdict, finding, values)
}

fn restarts(seen: &Observations, health: &Health) -> Check {
    let total = health.chip_restarts;
    let within = seen
        .watched
        .as_ref()
        .map(|watched| total.wrapping_sub(watched.before.chip_restarts));
    let no_answer = health.faults[FaultKind::NoAnswer as usize];
    let values = json!({ "since_start": total, "while_watched": within, "no_answer": no_answer });
    let finding = match (total, within) {
        (0, _) => "the chip was set up once".to_owned(),
        (_, Some(within)) => {
            format!(
                "set up again {total} times since the start, {within} of them while it was watched"
            )
        }
        (_, None) => format!("set up again {total} times since the start"),
    };
    let verdict = graded(total > 0, within.is_some_and(|within| within > 0));
    Check::new("adc_restarts", TROUBLESHOOTING, verdict, finding, values)
}

/// Whether a deviation is beyond its limit, or not a number.
fn is_off(deviation: f32, limit: f32) -> bool {
    !(-limit..=limit).contains(&deviation)
}

fn supply(health: &Health) -> Check {
    let volts = health.supply_v;
    let is_wrong = !(SUPPLY_V.0..=SUPPLY_V.1).contains(&volts);
    let finding = format!(
        "{volts:.3} V, {} to {} V are allowed",
        SUPPLY_V.0, SUPPLY_V.1
    );
    Check::new(
        "supply",
        WIRING,
        graded(is_wrong, is_wrong),
        finding,
        json!({ "supply_v": volts }),
    )
}

fn reference(health: &Health, vref_v: f32) -> Check {
    let volts = health.reference_v;
    let off = volts / vref_v - 1.0;
    let verdict = graded(is_off(off, REFERENCE.0), is_off(off, REFERENCE.1));
    let finding = format!(
        "{volts:.3} V, {:.2} % off vref_v = {vref_v} V",
        100.0 * off.abs()
    );
    Check::new(
        "reference",
        WIRING,
        verdict,
        finding,
        json!({ "reference_v": volts, "vref_v": vref_v }),
    )
}

fn temperature(health: &Health) -> Check {
    let celsius = health.temperature_c;
    let [warns, fails] = TEMPERATURE_C.map(|(least, most)| !(least..=most).contains(&celsius));
    let finding = format!("{celsius:.1} C at the ADC");
    Check::new(
        "temperature",
        WIRING,
        graded(warns, fails),
        finding,
        json!({ "temperature_c": celsius }),
    )
}

fn offset(health: &Health) -> Check {
    let volts = health.offset_v;
    let verdict = graded(is_off(volts, OFFSET_V.0), is_off(volts, OFFSET_V.1));
    let finding = format!(
        "{:+.1} uV, up to {:.0} uV pass",
        1e6 * volts,
        1e6 * OFFSET_V.0
    );
    Check::new(
        "offset",
        WIRING,
        verdict,
        finding,
        json!({ "offset_v": volts }),
    )
}

fn gain(health: &Health) -> Check {
    let off = health.gain - 1.0;
    let verdict = graded(is_off(off, GAIN.0), is_off(off, GAIN.1));
    let finding = format!("{:.6}, up to {} % off 1 pass", health.gain, 100.0 * GAIN.0);
    Check::new(
        "gain",
        WIRING,
        verdict,
        finding,
        json!({ "gain": health.gain }),
    )
}
