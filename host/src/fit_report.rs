//! What `fit` prints: a table for people, one JSON object for programs.

use crate::names::name;
use crate::table_fit::TableFit;
use crate::tone::{JsonTone, period};
use ridgetone_proto::telemetry::{Abscissa, Status};
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Json<'a> {
    r#type: &'static str,
    file: &'a str,
    rate_hz: f64,
    window_s: f64,
    rows: usize,
    rows_missing: usize,
    abscissa: Abscissa,
    #[serde(flatten)]
    tone: JsonTone<f64>,
    status: Status,
    harmonics: u8,
    channels: Vec<JsonChannel<'a>>,
}

#[derive(Serialize)]
struct JsonChannel<'a> {
    name: &'a str,
    usable: bool,
    offset: Option<f64>,
    amplitude: Option<f64>,
    phase_rad: Option<f32>,
    residual: Option<f64>,
}

/// One JSON object on one line, without the line's end.
///
/// # Errors
/// None that a number could cause; those of the serializer.
pub fn json(file: &str, fit: &TableFit) -> serde_json::Result<String> {
    let tone = fit.tone.is_some();
    let channels = fit.channels.iter().map(|channel| JsonChannel {
        name: &channel.name,
        usable: channel.values.is_some(),
        offset: channel.values.map(|v| v.offset),
        amplitude: channel.values.filter(|_| tone).map(|v| v.amplitude),
        phase_rad: channel.values.filter(|_| tone).map(|v| v.phase_rad),
        residual: channel.values.map(|v| v.residual),
    });
    serde_json::to_string(&Json {
        r#type: "fit",
        file,
        rate_hz: fit.rate_hz,
        window_s: fit.window_s,
        rows: fit.rows,
        rows_missing: fit.rows_missing,
        abscissa: fit.abscissa,
        tone: JsonTone::new(fit.abscissa, fit.tone, period),
        status: fit.status,
        harmonics: fit.harmonics,
        channels: channels.collect(),
    })
}

/// A table for people.
pub fn text(fit: &TableFit) -> String {
    let mut out = String::new();
    let width = if fit.abscissa == Abscissa::Time { 13 } else { 16 };
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{name:<width$} {value}");
    };
    let told = |value: Option<f64>, digits| value.map_or("-".into(), |value| significant(value, digits));
    let mut pair = |name: &str, sigma_name: &str, values: Option<(f64, f64)>| {
        line(name, told(values.map(|(value, _)| value), 7));
        line(sigma_name, told(values.map(|(_, sigma)| sigma), 2));
    };
    match fit.abscissa {
        Abscissa::Time => pair("frequency_hz", "sigma_hz", fit.tone),
        Abscissa::Place => {
            pair("frequency_per_mm", "sigma_per_mm", fit.tone);
            pair("period_mm", "period_sigma_mm", fit.tone.map(period));
        }
    }
    line("status", format!("{} ({})", name(fit.status), meaning(fit.status)));
    line("harmonics", fit.harmonics.to_string());
    line("window_s", significant(fit.window_s, 6));
    let missing = if fit.rows_missing > 0 { format!(", {} missing", fit.rows_missing) } else { String::new() };
    line("rows", format!("{} at {} Hz{missing}", fit.rows, significant(fit.rate_hz, 6)));

    let width = fit.channels.iter().map(|channel| channel.name.chars().count()).max().unwrap_or(0).max(7);
    let _ = writeln!(
        out,
        "\n{:<width$} {:>12} {:>12} {:>10} {:>12}",
        "channel", "offset", "amplitude", "phase_rad", "residual"
    );
    for channel in &fit.channels {
        let _ = match channel.values {
            Some(v) if fit.tone.is_some() => writeln!(
                out,
                "{:<width$} {:>12} {:>12} {:>10.4} {:>12}",
                channel.name,
                significant(v.offset, 6),
                significant(v.amplitude, 4),
                v.phase_rad,
                significant(v.residual, 3)
            ),
            Some(v) => writeln!(
                out,
                "{:<width$} {:>12} {:>12} {:>10} {:>12}",
                channel.name,
                significant(v.offset, 6),
                "-",
                "-",
                significant(v.residual, 3)
            ),
            None => writeln!(out, "{:<width$} not usable: constant or a straight line", channel.name),
        };
    }
    out
}

/// What a status means, in a few words.
pub fn meaning(status: Status) -> &'static str {
    match status {
        Status::Good => "a common tone",
        Status::NoTone => "the channels share no tone that stands out of their noise",
        Status::TooShort => "too little of a cycle in this part, or steps and drifts outweigh it; try --from and --to",
        Status::Nothing => "no usable channel, or fewer than 16 rows",
        Status::Ambiguous => "a reading a harmonic step away explains the window about equally well",
        Status::Doubtful => "a common tone, but something was wrong while the window came",
    }
}

/// A number with so many significant digits, plain between 1e-4 and 1e7.
pub fn significant(value: f64, digits: usize) -> String {
    let power = value.abs().log10().floor();
    if value == 0.0 || !value.is_finite() {
        value.to_string()
    } else if (-4.0..7.0).contains(&power) {
        let decimals = (digits as f64 - 1.0 - power).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.decimals$e}", decimals = digits.saturating_sub(1))
    }
}

/// So many decimals that an uncertainty has a digit other than 0, as many as `least` at least.
pub fn decimals(sigma: f64, least: usize) -> usize {
    // From half a unit of the last one on it is rounded up; single precision has no more than nine to show.
    if sigma > 0.0 { (-(2.0 * sigma).log10()).ceil().clamp(least as f64, 9.0) as usize } else { least }
}

/// A value and its uncertainty of the same [`decimals`], four of them or more.
pub fn with_sigma(value: f64, sigma: f64) -> (String, String) {
    let decimals = decimals(sigma, 4);
    (format!("{value:.decimals$}"), format!("{sigma:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uncertainty_is_never_told_as_0() {
        let told = |value, sigma| with_sigma(value, sigma);
        assert_eq!(told(8.33342, 0.00023), ("8.3334".into(), "0.0002".into()));
        assert_eq!(told(3.60002, 6e-5), ("3.6000".into(), "0.0001".into()));
        assert_eq!(told(4.1666667, 2.6e-6), ("4.166667".into(), "0.000003".into()));
        assert_eq!(told(4.1666667, 1e-6), ("4.166667".into(), "0.000001".into()));
        assert_eq!(told(31.25, 12.0), ("31.2500".into(), "12.0000".into()));
        assert_eq!((told(1.0, 0.0).1, told(1.0, f64::NAN).1), ("0.0000".into(), "NaN".into()));
    }

    #[test]
    fn significant_digits() {
        assert_eq!(significant(0.250_123_44, 4), "0.2501");
        assert_eq!(significant(-12_345.678, 3), "-12346");
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(0.0, 3), "0");
    }
}
