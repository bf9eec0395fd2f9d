//! The output of `fit`: a table for people, one JSON object for programs.

use crate::digits::significant;
use crate::names::name;
use crate::remarks::remarks;
use crate::table_fit::{ChannelResult, FittedPart, TableFit};
use crate::tables::date;
use crate::tone::{Domain, WithSigma};
use ridgetone_proto::telemetry::Status;
use serde::Serialize;
use std::fmt::Write;

/// One fit, of a file or of an array.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Fit<'a> {
    /// Kind of the object.
    r#type: &'static str,
    /// Name of the file.
    file: &'a str,
    #[serde(flatten)]
    fit: &'a TableFit,
}

pub(crate) fn object<'a>(file: &'a str, fit: &'a TableFit) -> Fit<'a> {
    Fit {
        r#type: "fit",
        file,
        fit,
    }
}

/// Formats a fit as one JSON object on one line, without the line end.
pub fn json(file: &str, fit: &TableFit) -> serde_json::Result<String> {
    serde_json::to_string(&object(file, fit))
}

fn digits_of(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| significant(value, digits))
}

/// Returns the results with their names, without the channels.
pub fn lines(fit: &TableFit) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    let mut line = |name: &'static str, value: String| lines.push((name, value));
    let frequency = fit.tone.frequency();
    let period = frequency.map(WithSigma::inverse);
    let pairs: &[(&str, &str, Option<WithSigma>)] = match fit.domain {
        Domain::Time => &[("frequency_hz", "sigma_hz", frequency)],
        Domain::Position => &[
            ("frequency_per_mm", "sigma_per_mm", frequency),
            ("period_mm", "period_sigma_mm", period),
        ],
    };
    for (name, sigma_name, found) in pairs {
        line(name, digits_of(found.map(|found| found.value), 7));
        line(sigma_name, digits_of(found.map(|found| found.sigma), 2));
    }
    line("status", format!("{} ({})", name(fit.status), meaning(fit)));
    for (name, value) in remarks(fit.status, fit.domain, &fit.tone) {
        line(name, value);
    }
    if let Some(hz) = fit.tone.interferer_hz {
        line("interferer_hz", significant(hz.into(), 5));
    }
    line("harmonics", fit.harmonics.to_string());
    line("window_s", significant(fit.window_s, 6));
    let dates = (fit.is_dated)
        .then(|| date(fit.from_s).zip(date(fit.to_s)))
        .flatten();
    let times = match dates {
        Some((from, to)) => format!("{from} to {to}"),
        None => format!(
            "{} to {} s",
            significant(fit.from_s, 6),
            significant(fit.to_s, 6)
        ),
    };
    line(
        "part",
        match (part_name(fit.part), fit.part) {
            (part, FittedPart::Slide) => format!("{part}, {times}; --whole fits everything"),
            (part, _) => format!("{part}, {times}"),
        },
    );
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
    lines
}

pub fn text(fit: &TableFit) -> String {
    let mut out = String::new();
    let width = if fit.domain == Domain::Time { 13 } else { 16 };
    for (name, value) in lines(fit) {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{name:<width$} {value}");
    }
    let named = |channel: &ChannelResult| match &channel.unit {
        Some(unit) if !channel.name.contains(unit) => format!("{} ({unit})", channel.name),
        _ => channel.name.clone(),
    };
    let width = fit
        .channels
        .iter()
        .map(|channel| named(channel).chars().count())
        .max()
        .unwrap_or(0)
        .max(7);
    let _ = writeln!(
        out,
        "\n{:<width$} {:>12} {:>12} {:>10} {:>12}",
        "channel", "offset", "amplitude", "phase_rad", "residual"
    );
    for channel in &fit.channels {
        let ChannelResult {
            usable,
            clipped,
            offset,
            amplitude,
            phase_rad,
            residual,
            ..
        } = channel;
        let name = named(channel);
        let phase_rad = phase_rad.map_or("-".into(), |phase_rad| format!("{phase_rad:.4}"));
        let [offset, amplitude, residual] = [(offset, 6), (amplitude, 4), (residual, 3)]
            .map(|(value, digits)| digits_of(*value, digits));
        let _ = match usable {
            true => writeln!(
                out,
                "{name:<width$} {offset:>12} {amplitude:>12} {phase_rad:>10} {residual:>12}{}",
                if *clipped { "  clipped" } else { "" }
            ),
            false => writeln!(
                out,
                "{name:<width$} not usable: constant, a straight line, or mostly blank"
            ),
        };
    }
    out
}

/// Names the part that was fitted.
pub fn part_name(part: FittedPart) -> &'static str {
    match part {
        FittedPart::Slide => "the slide",
        FittedPart::Whole => "all",
        FittedPart::Given => "as given",
    }
}

/// Number of cycles below which an ambiguous fit needs a longer part.
const FEW_CYCLES: f64 = 8.0;

fn meaning(fit: &TableFit) -> &'static str {
    let cycles = fit.tone.frequency().map_or(0.0, |tone| match fit.domain {
        Domain::Time => tone.value * fit.window_s,
        // The length of the window in millimetres is not known here.
        Domain::Position => 0.0,
    });
    match fit.status {
        Status::Good => "a common tone",
        Status::NoTone => "the channels share no tone that stands out of their noise",
        Status::TooShort => "fewer than 24 rows, or more missing than there are: try a longer part",
        Status::Nothing => "no usable channel, or no row",
        Status::Doubtful => "a common tone, but with a fault during the window",
        Status::Ambiguous if cycles < FEW_CYCLES => {
            "another reading is about as likely: use a longer part"
        }
        Status::Ambiguous if fit.domain == Domain::Time => {
            "another reading is about as likely: --min-hz or --max-hz leaves one of them"
        }
        Status::Ambiguous => "another reading is about as likely",
        Status::Unsteady => {
            "no interval can be promised, for the tone moves, comes or goes within this part: use a shorter one (--from, --to), or give the speed or the position (--speed-column, --positions)"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::Tone;
    use ridgetone_proto::telemetry::Movement;

    #[test]
    fn an_unsteady_tone_is_shown_with_what_helps_and_a_steady_one_without() {
        let movement = Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            ..Movement::default()
        };
        let tone = |movement, interferer_hz| {
            let frequency = WithSigma {
                value: 8.0,
                sigma: 0.01,
            };
            Tone::new(Domain::Time, Some(frequency), movement, None, interferer_hz)
        };
        let mut fit = TableFit {
            rate_hz: 100.0,
            rate_sigma_hz: 0.0,
            stamped_hz: None,
            part: FittedPart::Whole,
            from_s: 0.0,
            to_s: 3.99,
            window_s: 4.0,
            rows: 400,
            rows_missing: 0,
            readings_missing: 0,
            status: Status::Unsteady,
            domain: Domain::Time,
            tone: tone(Some(movement), Some(50.25)),
            harmonics: 1,
            groups: 1,
            channels: Vec::new(),
            is_dated: false,
            is_at_own_times: false,
            guessed: None,
        };
        let shown = text(&fit);
        for part in [
            "unsteady (no interval can be promised",
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
        (fit.status, fit.tone) = (Status::Good, tone(None, None));
        assert!(!text(&fit).contains("wander"));
    }
}
