//! `docs/reproduction.md`: the text of a template around the figures of a run.

use super::Reproduction;
use super::findings;
use super::paper::{LENGTH_MM, REPEATABILITY, TABLE_3};
use super::protocol::{JITTER_S, Line, NOISE_UV, RIPPLE_PERCENT};
use super::tables;
use crate::markdown::filled;
use anyhow::{Result, bail};
use hal_mock::{Sliding, TABLE_2};

/// Where the document's pictures are, from its own folder.
pub const FOLDER: &str = "reproduction/";

const TEMPLATE: &str = include_str!("template.md");

/// The converter's own noise at the scan's rate, uV RMS (SBAS297G, noise performance; as simulated).
const CONVERTER_UV: f64 = 4.5;

/// C3 and C4, whose Fourier errors tell the speed error's sign.
const C3: usize = 2;
const C4: usize = 3;

/// The document. What a run of some combinations only has no figure for is a dash, and pictures of others are left out.
///
/// # Errors
/// The template asks for what there is not.
pub fn document(reproduction: &Reproduction) -> Result<String> {
    let combinations = &reproduction.combinations;
    let there: Vec<String> = reproduction.svgs("").iter().map(|(name, _)| format!("]({FOLDER}{name})")).collect();
    let is_there = |line: &&str| !line.starts_with("![") || there.iter().any(|end| line.ends_with(end));
    let template: String = TEMPLATE.split_inclusive('\n').filter(|line| is_there(&line.trim_end())).collect();
    filled(&template, |name| {
        Ok(match name {
            "all_runs" => combinations.iter().map(|combination| combination.runs.len()).sum::<usize>().to_string(),
            "runs" => combinations.first().map_or(0, |combination| combination.runs.len()).to_string(),
            "place" if reproduction.emulated => "through the firmware image on the emulated STM32F405".into(),
            "place" => "through the firmware's code, which a PC runs to the last bit as the chip does".into(),
            "protocol" => protocol(),
            "table_2" => tables::table_2(reproduction),
            "table_3_1" => tables::table_3(combinations, 0, &TABLE_3[0]),
            "table_3_2" => tables::table_3(combinations, 1, &TABLE_3[1]),
            "table_3_all" => tables::table_3_all(combinations),
            "pair_1" => capital(TABLE_3[0].name),
            "pair_2" => capital(TABLE_3[1].name),
            "causes" => tables::causes(reproduction),
            "windows" => tables::windows(combinations),
            "repeatability" => tables::repeatability(combinations),
            "speed_error" => {
                let line = Line::of_table_3();
                let each = [15.0, 30.0, 48.0].map(|v| format!("{:.2} % at {v} mm/s", line.at(v)));
                each.join(", ")
            }
            "scatter" => format!("{:.2}", Line::of_table_3().scatter_percent),
            "ripple" => RIPPLE_PERCENT.to_string(),
            "jitter" => (1e3 * JITTER_S).round().to_string(),
            "noise" => (1e-3 * NOISE_UV).to_string(),
            other if other.starts_with("c3_") || other.starts_with("c4_") => line_pair(other)?,
            "noise_times" => format!("{:.0}", NOISE_UV / CONVERTER_UV),
            "paper_r1" => between(REPEATABILITY[0]),
            "paper_r2" => between(REPEATABILITY[1]),
            other => findings::finding(reproduction, other)?,
        })
    })
}

fn between((least, most): (f64, f64)) -> String {
    format!("{least:.2} to {most:.2}")
}

fn capital(name: &str) -> String {
    let (first, rest) = name.split_at(1);
    format!("{}{rest}", first.to_uppercase())
}

fn protocol() -> String {
    let Sliding { idle_s, hold_before_s, slide_mm, hold_after_s, release_idle_s, .. } = Sliding::physical();
    format!(
        "{idle_s} s in the air, contact at 1 N, {hold_before_s} s of hold, {slide_mm} mm of slide, {hold_after_s} s of hold, \
         release, {release_idle_s} s"
    )
}

/// The lines around the nominal frequencies of C3 and C4 in the paper's 55 mm (equation 6), and its errors there.
fn line_pair(name: &str) -> Result<String> {
    let c = if name.starts_with("c3") { C3 } else { C4 };
    let (speed_mm_s, period_mm) = TABLE_2[c];
    let (nominal_hz, line_hz) = (speed_mm_s / period_mm, speed_mm_s / LENGTH_MM);
    let low_hz = (nominal_hz / line_hz).floor() * line_hz;
    let (high_hz, middle_hz) = (low_hz + line_hz, low_hz + 0.5 * line_hz);
    Ok(match &name[3..] {
        "nominal" => format!("{nominal_hz:.3}"),
        "low" => format!("{low_hz:.3}"),
        "high" => format!("{high_hz:.3}"),
        "low_off" => format!("{:.3}", nominal_hz - low_hz),
        "high_off" => format!("{:.3}", high_hz - nominal_hz),
        "middle" => format!("{middle_hz:.3}"),
        "middle_percent" => format!("{:.2}", 100.0 * (middle_hz / nominal_hz - 1.0)),
        "paper_1" => format!("{:.3}", TABLE_3[0].fft.hz[c]),
        "paper_2" => format!("{:.3}", TABLE_3[1].fft.hz[c]),
        "paper_percent" => TABLE_3[0].least_squares.percent[c].to_string(),
        _ => bail!("the template asks for {name}"),
    })
}
