//! The output of `fit`: a table for people, one JSON object for programs.

use crate::digits::significant;
use crate::names::name;
use crate::remarks::remarks;
use crate::table_fit::{ChannelResult, TableFit};
use crate::tone::{JsonBeside, JsonTone, period};
use ridgetone_proto::telemetry::{Abscissa, Status};
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Json<'a> {
    r#type: &'static str,
    file: &'a str,
    rate_hz: f64,
    rate_sigma_hz: f64,
    window_s: f64,
    rows: usize,
    rows_missing: usize,
    readings_missing: usize,
    abscissa: Abscissa,
    #[serde(flatten)]
    tone: JsonTone<f64>,
    #[serde(flatten)]
    beside: JsonBeside,
    status: Status,
    harmonics: u8,
    channels: &'a [ChannelResult],
}

/// One JSON object on one line, without the line's end.
pub fn json(file: &str, fit: &TableFit) -> serde_json::Result<String> {
    serde_json::to_string(&Json {
        r#type: "fit",
        file,
        rate_hz: fit.rate_hz,
        rate_sigma_hz: fit.rate_sigma_hz,
        window_s: fit.window_s,
        rows: fit.rows,
        rows_missing: fit.rows_missing,
        readings_missing: fit.readings_missing,
        abscissa: fit.abscissa,
        tone: JsonTone::new(fit.abscissa, fit.tone, period),
        beside: JsonBeside::new(fit.abscissa, &fit.beside),
        status: fit.status,
        harmonics: fit.harmonics,
        channels: &fit.channels,
    })
}

pub fn text(fit: &TableFit) -> String {
    let mut out = String::new();
    let width = if fit.abscissa == Abscissa::Time {
        13
    } else {
        16
    };
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{name:<width$} {value}");
    };
    let digits_of = |value: Option<f64>, digits: usize| {
        value.map_or("-".to_owned(), |value| significant(value, digits))
    };
    let mut pair = |name: &str, sigma_name: &str, values: Option<(f64, f64)>| {
        line(name, digits_of(values.map(|(value, _)| value), 7));
        line(sigma_name, digits_of(values.map(|(_, sigma)| sigma), 2));
    };
    match fit.abscissa {
        Abscissa::Time => pair("frequency_hz", "sigma_hz", fit.tone),
        Abscissa::Place => {
            pair("frequency_per_mm", "sigma_per_mm", fit.tone);
            pair("period_mm", "period_sigma_mm", fit.tone.map(period));
        }
    }
    line(
        "status",
        format!("{} ({})", name(fit.status), meaning(fit.status)),
    );
    for (name, value) in remarks(fit.status, fit.abscissa, &fit.beside) {
        line(name, value);
    }
    if let Some(hz) = fit.beside.interferer_hz {
        line("interferer_hz", significant(hz.into(), 5));
    }
    line("harmonics", fit.harmonics.to_string());
    line("window_s", significant(fit.window_s, 6));
    let missing = if fit.rows_missing > 0 {
        format!(", {} missing", fit.rows_missing)
    } else {
        String::new()
    };
    let blank = match fit.readings_missing {
        0 => String::new(),
        blank => format!(", {blank} single readings missing"),
    };
    line(
        "rows",
        format!(
            "{} at {} Hz{missing}{blank}",
            fit.rows,
            significant(fit.rate_hz, 6)
        ),
    );

    let width = fit
        .channels
        .iter()
        .map(|channel| channel.name.chars().count())
        .max()
        .unwrap_or(0)
        .max(7);
    let _ = writeln!(
        out,
        "\n{:<width$} {:>12} {:>12} {:>10} {:>12}",
        "channel", "offset", "amplitude", "phase_rad", "residual"
    );
    for ChannelResult {
        name,
        usable,
        offset,
        amplitude,
        phase_rad,
        residual,
    } in &fit.channels
    {
        let phase_rad = phase_rad.map_or("-".into(), |phase_rad| format!("{phase_rad:.4}"));
        let [offset, amplitude, residual] = [(offset, 6), (amplitude, 4), (residual, 3)]
            .map(|(value, digits)| digits_of(*value, digits));
        let _ = match usable {
            true => writeln!(
                out,
                "{name:<width$} {offset:>12} {amplitude:>12} {phase_rad:>10} {residual:>12}"
            ),
            false => writeln!(
                out,
                "{name:<width$} not usable: constant, a straight line, or mostly blank"
            ),
        };
    }
    out
}

fn meaning(status: Status) -> &'static str {
    match status {
        Status::Good => "a common tone",
        Status::NoTone => "the channels share no tone that stands out of their noise",
        Status::TooShort => {
            "too little of a cycle in this part, or steps and drifts outweigh it; try --from and --to"
        }
        Status::Nothing => "no usable channel, or fewer than 16 rows",
        Status::Doubtful => "a common tone, but with a fault during the window",
        Status::Ambiguous => "another reading is about as likely: use a longer part",
        Status::Unsteady => {
            "the tone moves within this part: use a shorter one (--from, --to), or give the speed (--speed-column), or allow one harmonic more"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::Beside;
    use ridgetone_proto::telemetry::Movement;

    #[test]
    fn an_unsteady_tone_is_shown_with_what_helps_and_a_steady_one_without() {
        let movement = Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            ..Movement::default()
        };
        let mut fit = TableFit {
            rate_hz: 100.0,
            rate_sigma_hz: 0.0,
            stamped_hz: None,
            window_s: 4.0,
            rows: 400,
            rows_missing: 0,
            readings_missing: 0,
            status: Status::Unsteady,
            abscissa: Abscissa::Time,
            tone: Some((8.0, 0.01)),
            beside: Beside {
                movement: Some(movement),
                interferer_hz: Some(50.25),
                ..Beside::default()
            },
            harmonics: 1,
            channels: Vec::new(),
            guessed: None,
        };
        let shown = text(&fit);
        for part in [
            "unsteady (the tone moves",
            "wander        2.0 %\n",
            "interferer_hz 50.250\n",
        ] {
            assert!(shown.contains(part), "{part}: {shown}");
        }
        let json = json("a file", &fit).unwrap();
        assert!(
            json.contains(r#""wander_percent":2.0,"wander_sigma_percent":0.1,"#),
            "{json}"
        );
        (fit.status, fit.beside) = (Status::Good, Beside::default());
        assert!(!text(&fit).contains("wander"));
    }
}
