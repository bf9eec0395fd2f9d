//! The ADS1258 by its registers and by its own readings.

use super::run::Run;
use super::verdict::{Judged, Limits, Measured, Verdict};
use crate::digits::hex;
use ads1258::Register;
use ridgetone_finger::converter::SCAN;
use ridgetone_proto::fault::FaultKind;
use serde_json::json;

/// ID4 in the register ID: 0 is the ADS1258, 1 the ADS1158 (SBAS297G, register map).
const ID4: u8 = 1 << 4;

/// The wire to look at if all registers read the same.
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

/// The registers of an ADS1258. Another converter is judged by whether it answers.
fn ads1258<'a>(run: &Run<'a>) -> Result<&'a [u8; 10], Judged> {
    let converter = run.converter()?;
    let name = &converter.name;
    if name == "ADS1258" {
        return Ok(&converter.registers);
    }
    let (verdict, answers) = match converter.answers {
        true => (Verdict::Pass, "answers"),
        false => (Verdict::Fail, "does not answer"),
    };
    Err(Judged::new(
        verdict,
        format!("{name}, which {answers}"),
        json!({}),
    ))
}

pub fn id(run: &Run<'_>) -> Result<Judged, Judged> {
    let registers = ads1258(run)?;
    let id = registers[Register::Id as usize];
    let (verdict, finding) = if let Some(why) = stuck(registers) {
        (Verdict::Fail, why.to_owned())
    } else if id & ID4 != 0 {
        let finding = format!("{id:02X}: bit 4 is set, an ADS1158 of 16 bits, or a bad DOUT");
        (Verdict::Fail, finding)
    } else {
        let finding = format!("{id:02X}, bit 4 is clear: an ADS1258");
        (Verdict::Pass, finding)
    };
    Ok(Judged::new(verdict, finding, json!({ "id": id })))
}

pub fn registers(run: &Run<'_>) -> Result<Judged, Judged> {
    let registers = ads1258(run)?;
    let written = &SCAN.registers().unwrap_or_default()[..Register::WRITABLE];
    let wrong: Vec<String> = Register::ALL
        .iter()
        .zip(registers.iter().zip(written))
        .filter(|(_, (found, written))| found != written)
        .map(|(register, (found, written))| {
            format!("{register} {found:02X} instead of {written:02X}")
        })
        .collect();
    let written = hex(written);
    let values = json!({ "found": hex(registers), "written": written });
    Ok(if wrong.is_empty() {
        Judged::new(Verdict::Pass, format!("{written} as written"), values)
    } else {
        let why = stuck(registers).map_or_else(|| wrong.join(", "), str::to_owned);
        Judged::new(Verdict::Fail, why, values)
    })
}

pub fn restarts(run: &Run<'_>) -> Result<Judged, Judged> {
    let health = run.health()?;
    let total = health.chip_restarts;
    let watched = run.seen.watched.as_ref();
    let within = watched.map(|watched| total.wrapping_sub(watched.before.chip_restarts));
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
    Ok(Judged::new(verdict, finding, values))
}

pub fn supply(run: &Run<'_>, limits: &Limits) -> Result<Measured, Judged> {
    let volts = run.readings()?.supply_v;
    let [min, max] = limits.pass;
    Ok(Measured {
        value: volts.into(),
        finding: format!("{volts:.3} V, {min} to {max} V are allowed"),
        values: json!({ "supply_v": volts }),
    })
}

pub fn reference(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    let (volts, vref_v) = (run.readings()?.reference_v, run.seen.vref_v());
    let off = volts / vref_v - 1.0;
    let percent = 100.0 * off.abs();
    Ok(Measured {
        value: off.into(),
        finding: format!("{volts:.3} V, {percent:.2} % off vref_v = {vref_v} V"),
        values: json!({ "reference_v": volts, "vref_v": vref_v }),
    })
}

pub fn temperature(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    let celsius = run.readings()?.temperature_c;
    Ok(Measured {
        value: celsius.into(),
        finding: format!("{celsius:.1} C at the ADC"),
        values: json!({ "temperature_c": celsius }),
    })
}

pub fn offset(run: &Run<'_>, limits: &Limits) -> Result<Measured, Judged> {
    let volts = run.readings()?.offset_v;
    let (uv, max_uv) = (1e6 * volts, 1e6 * limits.pass[1]);
    Ok(Measured {
        value: volts.into(),
        finding: format!("{uv:+.1} uV, up to {max_uv:.0} uV pass"),
        values: json!({ "offset_v": volts }),
    })
}

pub fn gain(run: &Run<'_>, limits: &Limits) -> Result<Measured, Judged> {
    let gain = run.readings()?.gain;
    let max_percent = 100.0 * limits.pass[1];
    Ok(Measured {
        value: f64::from(gain - 1.0),
        finding: format!("{gain:.6}, up to {max_percent} % off 1 pass"),
        values: json!({ "gain": gain }),
    })
}
