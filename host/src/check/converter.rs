//! Checks the ADS1258 by its registers and by its own readings.

use super::observations::Observations;
use super::verdict::{Judged, Limits, Outcome, Verdict, judged};
use crate::digits::hex;
use ads1258::Register;
use ridgetone_finger::converter::SCAN;
use ridgetone_proto::fault::FaultKind;
use serde_json::json;

use Verdict::{Fail, Pass};

/// ID4 in the register ID: 0 is the ADS1258, 1 the ADS1158 (SBAS297G, register map).
const ID4: u8 = 1 << 4;

/// Returns which wires to check if all registers read 00 or all read FF.
fn stuck(registers: &[u8; 10]) -> Option<&'static str> {
    match registers {
        [0xff, ..] if *registers == [0xff; 10] => Some(
            "all registers read FF: DOUT is always high; look at DOUT, CS, PWDN and the chip's supply",
        ),
        [0, ..] if *registers == [0; 10] => Some(
            "all registers read 00, or the chip was never set up: DOUT is always low; look at DOUT, SCLK, DIN and DVDD",
        ),
        _ => None,
    }
}

/// Returns the registers of an ADS1258. Any other converter is judged only by whether it answers.
fn ads1258(seen: &Observations) -> Result<&[u8; 10], Judged> {
    let converter = seen.need(&seen.converter)?;
    let name = &converter.name;
    match converter.answers {
        _ if name == "ADS1258" => Ok(&converter.registers),
        true => Err(judged(Pass, format!("{name}, which answers"), json!({}))),
        false => Err(judged(
            Fail,
            format!("{name}, which does not answer"),
            json!({}),
        )),
    }
}

pub fn id(seen: &Observations) -> Outcome {
    let registers = ads1258(seen)?;
    let id = registers[Register::Id as usize];
    let (verdict, finding) = match stuck(registers) {
        Some(why) => (Fail, why.to_owned()),
        None if id & ID4 == 0 => (Pass, format!("{id:02X}, bit 4 is clear: an ADS1258")),
        None => (
            Fail,
            format!("{id:02X}: bit 4 is set, an ADS1158 of 16 bits, or a bad DOUT"),
        ),
    };
    Ok(judged(verdict, finding, json!({ "id": id })))
}

pub fn registers(seen: &Observations) -> Outcome {
    let registers = ads1258(seen)?;
    let written = &SCAN.registers().unwrap_or_default()[..Register::WRITABLE];
    let pairs = Register::ALL.iter().zip(registers.iter().zip(written));
    let wrong = pairs.filter(|(_, (found, written))| found != written);
    let wrong: Vec<String> = wrong
        .map(|(name, (found, written))| format!("{name} {found:02X} instead of {written:02X}"))
        .collect();
    let written = hex(written);
    let values = json!({ "found": hex(registers), "written": written });
    Ok(match &wrong[..] {
        [] => judged(Pass, format!("{written} as written"), values),
        wrong => {
            let why = stuck(registers).map_or_else(|| wrong.join(", "), str::to_owned);
            judged(Fail, why, values)
        }
    })
}

pub fn restarts(seen: &Observations) -> Outcome {
    let health = seen.health()?;
    let total = health.chip_restarts;
    let before = seen
        .watched
        .as_ref()
        .map(|watched| watched.before.chip_restarts);
    let within = before.map(|before| total.wrapping_sub(before));
    let no_answer = health.faults[FaultKind::NoAnswer as usize];
    let values = json!({ "since_start": total, "while_watched": within, "no_answer": no_answer });
    let finding = match (total, within) {
        (0, _) => "the chip was set up once".to_owned(),
        (_, None) => format!("set up again {total} times since the start"),
        (_, Some(within)) => format!(
            "set up again {total} times since the start, {within} of them while it was watched"
        ),
    };
    let verdict = Verdict::graded(total > 0, within.is_some_and(|within| within > 0));
    Ok(judged(verdict, finding, values))
}

pub fn supply(seen: &Observations, limits: Limits) -> Outcome {
    let (volts, [min, max]) = (seen.readings()?.supply_v, limits.pass);
    let finding = format!("{volts:.3} V, {min} to {max} V are allowed");
    limits.judge(volts, finding, json!({ "supply_v": volts }))
}

pub fn reference(seen: &Observations, limits: Limits) -> Outcome {
    let (volts, vref_v) = (seen.readings()?.reference_v, seen.vref_v());
    let off = volts / vref_v - 1.0;
    let percent = 100.0 * off.abs();
    let finding = format!("{volts:.3} V, {percent:.2} % off vref_v = {vref_v} V");
    limits.judge(
        off,
        finding,
        json!({ "reference_v": volts, "vref_v": vref_v }),
    )
}

pub fn temperature(seen: &Observations, limits: Limits) -> Outcome {
    let celsius = seen.readings()?.temperature_c;
    let finding = format!("{celsius:.1} C at the ADC");
    limits.judge(celsius, finding, json!({ "temperature_c": celsius }))
}

pub fn offset(seen: &Observations, limits: Limits) -> Outcome {
    let volts = seen.readings()?.offset_v;
    let (uv, max_uv) = (1e6 * volts, 1e6 * limits.pass[1]);
    let finding = format!("{uv:+.1} uV, up to {max_uv:.0} uV pass");
    limits.judge(volts, finding, json!({ "offset_v": volts }))
}

pub fn gain(seen: &Observations, limits: Limits) -> Outcome {
    let gain = seen.readings()?.gain;
    let finding = format!("{gain:.6}, up to {} % off 1 pass", 100.0 * limits.pass[1]);
    limits.judge(gain - 1.0, finding, json!({ "gain": gain }))
}
