//! The output of `feel`: a table for people, one JSON object for programs.

use super::coefficients::{Coefficients, NAMES};
use super::measure::{Channel, Felt};
use super::words::{OUTSIDE_SCALE, absent, is_outside_scale, needs};
use crate::digits::{plus_minus, significant};
use crate::events::view::{Receptor as ReceptorView, Score as ScoreView};
use ridgetone_feel::{Indices, MeanFiring, Receptor, Score};
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Json<'a> {
    r#type: &'static str,
    file: &'a str,
    rate_hz: f64,
    window_s: f64,
    as_window_s: f64,
    windows: u32,
    rows: usize,
    rows_missing: usize,
    readings_missing: usize,
    reference_hz: f32,
    m: Option<f32>,
    m_sigma: Option<f32>,
    receptors: Vec<ReceptorView>,
    scores: Vec<ScoreView>,
    channels: Vec<JsonChannel<'a>>,
}

#[derive(Serialize)]
struct JsonChannel<'a> {
    name: &'a str,
    /// False where the reference has no amplitude.
    usable: bool,
    per_um: Option<f32>,
    per_um_sigma: Option<f32>,
    receptors: Option<Vec<ReceptorView>>,
}

/// One JSON object on one line, without the line's end.
pub fn json(
    felt: &Felt,
    coefficients: &Coefficients,
    m: Option<(f32, f32)>,
) -> serde_json::Result<String> {
    serde_json::to_string(&Json {
        r#type: "feel",
        file: &felt.file,
        rate_hz: felt.rate_hz,
        window_s: felt.window_s,
        as_window_s: felt.as_window_s,
        windows: felt.firing.windows(),
        rows: felt.rows,
        rows_missing: felt.rows_missing,
        readings_missing: felt.readings_missing,
        reference_hz: felt.reference.frequency_hz(),
        m: m.map(|(value, _)| value),
        m_sigma: m.map(|(_, sigma)| sigma),
        receptors: receptors(felt, &felt.firing, felt.log_sigma),
        scores: scores(felt, coefficients, m),
        channels: felt
            .channels
            .iter()
            .map(|channel| json_channel(felt, channel))
            .collect(),
    })
}

fn json_channel<'a>(
    felt: &Felt,
    Channel {
        name,
        conversion,
        firing,
    }: &'a Channel,
) -> JsonChannel<'a> {
    JsonChannel {
        name,
        usable: conversion.is_some(),
        per_um: conversion.map(|conversion| conversion.per_um()),
        per_um_sigma: conversion.map(|conversion| conversion.per_um_sigma()),
        receptors: conversion.map(|conversion| receptors(felt, firing, conversion.log_sigma)),
    }
}

fn receptors(felt: &Felt, firing: &MeanFiring, log_sigma: f32) -> Vec<ReceptorView> {
    let indices = Indices::new(firing, log_sigma, None);
    let receptor = |receptor: Receptor| {
        let found = indices.get(receptor as usize);
        let per_hz = |value: f32| value / felt.as_window_s as f32;
        ReceptorView {
            receptor: NAMES[receptor as usize],
            intensity: found.map(|(value, _)| value),
            intensity_sigma: found.map(|(_, sigma)| sigma),
            intensity_per_hz: found.map(|(value, _)| per_hz(value)),
            intensity_per_hz_sigma: found.map(|(_, sigma)| per_hz(sigma)),
            absent: absent(receptor, felt.rate_hz, felt.window_s, felt.bins()),
        }
    };
    Receptor::ALL.map(receptor).into()
}

fn scores(felt: &Felt, coefficients: &Coefficients, m: Option<(f32, f32)>) -> Vec<ScoreView> {
    let indices = felt.indices(m);
    let score = |(name, score): (&str, Score)| {
        let found = score.of(&indices);
        let (value, sigma) = (found.map(|(value, _)| value), found.map(|(_, sigma)| sigma));
        let absent = needs(&score, &indices)
            .map(|why| why.replace("needs M", "needs M: give --m or --image"));
        let outside_scale = coefficients.are_the_papers() && is_outside_scale(value);
        ScoreView {
            name: name.to_owned(),
            score: value,
            score_sigma: sigma,
            outside_scale,
            absent,
        }
    };
    coefficients.scores().map(score).collect()
}

pub fn text(felt: &Felt, coefficients: &Coefficients, m: Option<(f32, f32)>) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(
        out,
        "{:<10}{:>22}{:>22}",
        "receptor", "intensity", "per hertz"
    );
    for (found, receptor) in receptors(felt, &felt.firing, felt.log_sigma)
        .into_iter()
        .zip(Receptor::ALL)
    {
        let ReceptorView {
            intensity,
            intensity_sigma,
            intensity_per_hz,
            intensity_per_hz_sigma,
            absent,
            ..
        } = found;
        let _ = match absent {
            Some(why) => writeln!(out, "{:<10}{:>22}  {why}", receptor.name(), "-"),
            None => writeln!(
                out,
                "{:<10}{:>22}{:>22}",
                receptor.name(),
                with_sigma(intensity, intensity_sigma),
                with_sigma(intensity_per_hz, intensity_per_hz_sigma)
            ),
        };
    }
    for ScoreView {
        name,
        score,
        score_sigma,
        outside_scale,
        absent,
    } in scores(felt, coefficients, m)
    {
        let value = if absent.is_some() {
            "-".to_owned()
        } else {
            with_sigma(score, score_sigma)
        };
        let remark =
            absent.unwrap_or_else(|| if outside_scale { OUTSIDE_SCALE } else { "" }.to_owned());
        let _ = writeln!(out, "{name:<10}{value:>22}  {remark}");
    }
    let m = with_sigma(m.map(|(value, _)| value), m.map(|(_, sigma)| sigma));
    let _ = writeln!(out, "{:<10}{m:>22}", "M = F/N");
    let _ = writeln!(
        out,
        "reference at {} Hz; {} windows of {} s, as of {} s; {} rows at {} Hz, {} rows and {} readings missing",
        significant(felt.reference.frequency_hz().into(), 4),
        felt.firing.windows(),
        significant(felt.window_s, 4),
        significant(felt.as_window_s, 4),
        felt.rows,
        significant(felt.rate_hz, 6),
        felt.rows_missing,
        felt.readings_missing
    );
    for Channel {
        name, conversion, ..
    } in &felt.channels
    {
        let _ = match conversion {
            Some(conversion) => {
                let (value, sigma) = (conversion.per_um().into(), conversion.per_um_sigma().into());
                writeln!(out, "{name}: {} a micrometre", plus_minus(value, sigma))
            }
            None => writeln!(
                out,
                "{name}: not used: the reference has no amplitude in it"
            ),
        };
    }
    out.lines()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect()
}

fn with_sigma(value: Option<f32>, sigma: Option<f32>) -> String {
    let (Some(value), Some(sigma)) = (value, sigma) else {
        return "-".to_owned();
    };
    if sigma == 0.0 {
        return significant(value.into(), 4);
    }
    plus_minus(value.into(), sigma.into())
}
