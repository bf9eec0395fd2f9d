//! The ADS1258 by its registers and by its own readings.

use super::observations::Observations;
use super::table::{Judged, Limits, Verdict, graded};
use crate::digits::hex;
use ads1258::Register;
use ridgetone_finger::converter::SCAN;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{ConverterState, Health};
use serde_json::json;

/// ID4 in the register ID: 0 is the ADS1258, 1 the ADS1158 (SBAS297G, register map).
const ID4: u8 = 1 << 4;

/// Supply of the analog part, volts: 5 V +-5 % (SBAS297G, operating conditions).
const SUPPLY_V: Limits = Limits {
    pass: [4.75, 5.25],
    fail: [4.75, 5.25],
};

/// Share by which the reference may be off the setting: half of the firmware's limit for the fault
/// `reference`, and that.
const REFERENCE: Limits = Limits::off(0.01, 0.02);

/// Temperatures at which nothing is suspicious, and those at which the chip works (SBAS297G, -40 to
/// 105), degrees Celsius.
const TEMPERATURE_C: Limits = Limits {
    pass: [5.0, 60.0],
    fail: [-40.0, 105.0],
};

/// Offset, volts: own limits, 55 and 220 times the noise of one reading. What is known of SBAS297G
/// has a typical drift, 0.02 uV per degree, and no limit.
const OFFSET_V: Limits = Limits::off(250e-6, 1e-3);

/// Share by which the gain may be off 1: own limits, by which a voltage is off too. The reference's
/// own tolerance cancels.
const GAIN: Limits = Limits::off(0.005, 0.02);

/// What registers that all hold the same say about the wires.
fn stuck(registers: &[u8; 10]) -> Option<&'static str> {
    match registers {
        [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff] => Some(
            "all registers read FF: DOUT is always high; look at DOUT, CS, PWDN and the chip's supply",
        ),
        [0, 0, 0, 0, 0, 0, 0, 0, 0, 0] => Some(
            "all registers read 00, or the chip was never set up: DOUT is always low; look at DOUT, SCLK, DIN and DVDD",
        ),
        _ => None,
    }
}

/// Why registers are not judged here.
fn is_other(converter: &ConverterState) -> Option<Judged> {
    let name = &converter.name;
    (name != "ADS1258").then(|| {
        if converter.answers {
            Judged::new(Verdict::Pass, format!("{name}, which answers"), json!({}))
        } else {
            Judged::new(
                Verdict::Fail,
                format!("{name}, which does not answer"),
                json!({}),
            )
        }
    })
}

pub fn id(converter: &ConverterState) -> Judged {
    if let Some(judged) = is_other(converter) {
        return judged;
    }
    let id = converter.registers[Register::Id as usize];
    let (verdict, finding) = if let Some(why) = stuck(&converter.registers) {
        (Verdict::Fail, why.to_owned())
    } else if id & ID4 != 0 {
        let finding = format!("{id:02X}: bit 4 is set, an ADS1158 of 16 bits, or a bad DOUT");
        (Verdict::Fail, finding)
    } else {
        (
            Verdict::Pass,
            format!("{id:02X}, bit 4 is clear: an ADS1258"),
        )
    };
    Judged::new(verdict, finding, json!({ "id": id }))
}

pub fn registers(converter: &ConverterState) -> Judged {
    if let Some(judged) = is_other(converter) {
        return judged;
    }
    let written = &SCAN.registers().unwrap_or_default()[..Register::WRITABLE];
    let wrong: Vec<String> = Register::ALL
        .iter()
        .zip(converter.registers.iter().zip(written))
        .filter(|(_, (found, written))| found != written)
        .map(|(register, (found, written))| {
            format!("{register} {found:02X} instead of {written:02X}")
        })
        .collect();
    let written = hex(written);
    let values = json!({ "found": hex(&converter.registers), "written": written });
    if wrong.is_empty() {
        Judged::new(Verdict::Pass, format!("{written} as written"), values)
    } else {
        let why = stuck(&converter.registers).map_or_else(|| wrong.join(", "), str::to_owned);
        Judged::new(Verdict::Fail, why, values)
    }
}

pub fn restarts(seen: &Observations) -> Judged {
    let Some(health) = seen.latest() else {
        return Judged::skipped(seen.why());
    };
    let total = health.chip_restarts;
    let before = seen
        .watched
        .as_ref()
        .map(|watched| watched.before.chip_restarts);
    let within = before.map(|before| total.wrapping_sub(before));
    let no_answer = health.faults[FaultKind::NoAnswer as usize];
    let values = json!({ "since_start": total, "while_watched": within, "no_answer": no_answer });
    let mut finding = match total {
        0 => "the chip was set up once".to_owned(),
        total => format!("set up again {total} times since the start"),
    };
    if let Some(within) = within.filter(|_| total > 0) {
        finding += &format!(", {within} of them while it was watched");
    }
    let verdict = graded(total > 0, within.is_some_and(|within| within > 0));
    Judged::new(verdict, finding, values)
}

pub fn supply(health: &Health, _: f32) -> Judged {
    let volts = health.supply_v;
    let [least, most] = SUPPLY_V.pass;
    let finding = format!("{volts:.3} V, {least} to {most} V are allowed");
    Judged::new(
        SUPPLY_V.verdict(volts.into()),
        finding,
        json!({ "supply_v": volts }),
    )
}

pub fn reference(health: &Health, vref_v: f32) -> Judged {
    let volts = health.reference_v;
    let off = volts / vref_v - 1.0;
    let finding = format!(
        "{volts:.3} V, {:.2} % off vref_v = {vref_v} V",
        100.0 * off.abs()
    );
    let values = json!({ "reference_v": volts, "vref_v": vref_v });
    Judged::new(REFERENCE.verdict(off.into()), finding, values)
}

pub fn temperature(health: &Health, _: f32) -> Judged {
    let celsius = health.temperature_c;
    let verdict = TEMPERATURE_C.verdict(celsius.into());
    let finding = format!("{celsius:.1} C at the ADC");
    Judged::new(verdict, finding, json!({ "temperature_c": celsius }))
}

pub fn offset(health: &Health, _: f32) -> Judged {
    let volts = health.offset_v;
    let finding = format!(
        "{:+.1} uV, up to {:.0} uV pass",
        1e6 * volts,
        1e6 * OFFSET_V.pass[1]
    );
    Judged::new(
        OFFSET_V.verdict(volts.into()),
        finding,
        json!({ "offset_v": volts }),
    )
}

pub fn gain(health: &Health, _: f32) -> Judged {
    let gain = health.gain;
    let finding = format!("{gain:.6}, up to {} % off 1 pass", 100.0 * GAIN.pass[1]);
    Judged::new(
        GAIN.verdict((gain - 1.0).into()),
        finding,
        json!({ "gain": gain }),
    )
}
