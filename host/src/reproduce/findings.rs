//! The figures in the text of `docs/reproduction.md`.

use super::Reproduction;
use super::charts::number;
use super::paper::{GRATINGS_MM, LENGTH_MM, REPEATABILITY, TABLE_3};
use super::protocol::Line;
use super::results::{Combination, Run, rms};
use super::tables::{all_fit, at, percent};
use crate::fit_report::significant;
use anyhow::{Context, Result};

/// Least and greatest.
fn ends(values: &[f64]) -> Result<(f64, f64)> {
    let fold = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (v.min(l), v.max(m)));
    Some(fold).filter(|(least, most)| least <= most).context("the run lacks what the text is about")
}

/// The greatest of some figures and what it is of.
fn greatest<T: Copy>(values: impl Iterator<Item = (T, f64)>) -> Result<(T, f64)> {
    values.max_by(|a, b| a.1.total_cmp(&b.1)).context("the run lacks what the text is about")
}

fn name(combination: &Combination) -> String {
    number(combination).map_or_else(String::new, |c| format!("C{}", c + 1))
}

/// A figure of the text by its name; none if there is no such name.
///
/// # Errors
/// The run lacks what it is made of.
pub fn finding(all: &Reproduction, wanted: &str) -> Result<Option<String>> {
    let combinations = &all.combinations;
    let paper = TABLE_3[0].least_squares.percent;
    let two = |run: &Run| run.pairs[0].least_squares_hz;
    let of_two = |c: &Combination| percent(c.rms_hz(two), c);
    let here: Vec<f64> = combinations.iter().filter_map(of_two).collect();
    let apart = || combinations.iter().filter_map(|c| Some((c, of_two(c)? - paper[number(c)?])));
    let two_digits = |value: f64| significant(value, 2);
    Ok(Some(match wanted {
        "ls_least" => format!("{:.2}", ends(&here)?.0),
        "ls_most" => format!("{:.2}", ends(&here)?.1),
        "paper_ls_least" => format!("{:.2}", ends(&paper)?.0),
        "paper_ls_most" => format!("{:.2}", ends(&paper)?.1),
        "ls_apart_rms" => format!("{:.2}", rms(apart().map(|(_, off)| Some(off))).context("no runs")?),
        "ls_apart_most" => format!("{:.2}", greatest(apart().map(|(c, off)| (c, off.abs())))?.1),
        "ls_apart_where" => name(greatest(apart().map(|(c, off)| (c, off.abs())))?.0),
        "ideal_two" => two_digits(all.causes.first().context("no causes")?.least_squares_percent),
        "ideal_all" => two_digits(all.causes.first().context("no causes")?.all_percent),
        "own_two" => own(combinations, two)?,
        "own_all" => own(combinations, all_fit)?,
        "fft_close" => fourier(combinations).filter(|(_, off, line_hz)| off.abs() < 0.2 * line_hz).count().to_string(),
        "fft_worst" | "fft_worst_here" | "fft_worst_paper" => {
            let (c, _) = greatest(fourier(combinations).map(|(c, off, line_hz)| (c, off.abs() / line_hz)))?;
            match wanted {
                "fft_worst" => name(c),
                "fft_worst_here" => format!("{:.3}", c.rms_hz(|run| run.pairs[0].fft_hz).context("no estimate")?),
                _ => format!("{:.3}", TABLE_3[0].fft.hz[number(c).context("not the paper's")?]),
            }
        }
        "ls_at_04" => format!("{:.1}", ends(&at(combinations, 0.4, &|window| Some(window.least_squares_hz)))?.1),
        "fft_at_04" => format!("{:.0}", ends(&at(combinations, 0.4, &|window| Some(window.fft_hz)))?.1),
        "r1_least" => format!("{:.2}", repeatability(combinations, 0)?.0),
        "r1_most" => format!("{:.2}", repeatability(combinations, 0)?.1),
        "r2_least" => format!("{:.2}", repeatability(combinations, 1)?.0),
        "r2_most" => format!("{:.2}", repeatability(combinations, 1)?.1),
        "r2_needed" => format!("{:.0}", needed_percent()),
        "edge_percent" => format!("{:.0}", edge_percent(combinations)?),
        "opposite" => format!("{:.2}", all.pictures.opposite.as_ref().context("no Figure 10")?.correlation),
        "same_grating" => format!("{:.2}", images(combinations, true)?.1),
        "other_grating" => format!("{:.2}", images(combinations, false)?.0),
        "gratings_apart" => gratings_apart(),
        "period_um" => format!("{:.0}", 1e3 * 4.1 * 0.01 * off_line_percent(4.1).abs()),
        "firmware_ideal" => format!("{:.2}", perfect(all)?.1),
        "firmware_ideal_where" => perfect(all)?.0,
        "firmware_own" => format!("{:.3}", firmware_percent(combinations)?),
        "start_error" => format!("{:.0}", slide_error_ms(combinations)?.0),
        "end_error" => format!("{:.0}", slide_error_ms(combinations)?.1),
        "told" => told(combinations),
        _ => return Ok(None),
    }))
}

/// RMS over all runs of a method's error against the true frequency, percent.
fn own(combinations: &[Combination], of: impl Fn(&Run) -> Option<f64>) -> Result<String> {
    let each = combinations.iter().flat_map(|c| &c.runs).map(|run| Some(100.0 * (of(run)? / run.true_hz - 1.0)));
    Ok(significant(rms(each).context("no estimate")?, 2))
}

/// By how much naive Fourier analysis errs more than the paper's, and how far lines are apart; hertz.
fn fourier(combinations: &[Combination]) -> impl Iterator<Item = (&Combination, f64, f64)> {
    combinations.iter().filter_map(|c| {
        let off = c.rms_hz(|run| run.pairs[0].fft_hz)? - TABLE_3[0].fft.hz[number(c)?];
        Some((c, off, c.speed_mm_s / LENGTH_MM))
    })
}

fn repeatability(combinations: &[Combination], channel: usize) -> Result<(f64, f64)> {
    let all: Vec<f64> = combinations.iter().filter_map(|c| c.repeatability).map(|both| both[channel]).collect();
    ends(&all)
}

/// By how much more amplitude unit 1 would have than unit 2 if the same noise on both made the paper's correlations:
/// a correlation of r is a noise of (1 - r) / r of the signal's power.
fn needed_percent() -> f64 {
    let [one, two] = REPEATABILITY.map(|(least, most)| 0.5 * (least + most));
    let noise = |r: f64| (1.0 - r) / r;
    100.0 * ((noise(two) / noise(one)).sqrt() - 1.0)
}

/// The same as simulated: by the correlations, which are all that is kept of the amplitudes.
fn edge_percent(combinations: &[Combination]) -> Result<f64> {
    let ratios = combinations.iter().filter_map(|c| c.repeatability).map(|[one, two]| {
        let noise = |r: f64| (1.0 - r) / r;
        (noise(two) / noise(one)).sqrt()
    });
    let ratios: Vec<f64> = ratios.collect();
    ends(&ratios)?;
    Ok(100.0 * (ratios.iter().sum::<f64>() / ratios.len() as f64 - 1.0))
}

/// Mean over a grating's combinations of what the paper's errors are off the line, percent.
fn off_line_percent(period_mm: f64) -> f64 {
    let line = Line::of_table_3();
    let errors = hal_mock::TABLE_2.into_iter().zip(TABLE_3[0].least_squares.percent);
    let own = errors.filter(|((_, own_mm), _)| *own_mm == period_mm).map(|((v, _), percent)| percent - line.at(v));
    let own: Vec<f64> = own.collect();
    own.iter().sum::<f64>() / own.len() as f64
}

fn gratings_apart() -> String {
    let each = GRATINGS_MM.map(|period_mm| format!("by {:+.2} % at {period_mm} mm", off_line_percent(period_mm)));
    each.join(", ")
}

/// RMS differences over the taxels of the images before the slide, mV, least and greatest over pairs of combinations of
/// the same grating or of different ones.
fn images(combinations: &[Combination], same: bool) -> Result<(f64, f64)> {
    let first = |c: &Combination| c.runs.first().map(|run| run.images_v[0].clone()).filter(|image| !image.is_empty());
    let mut all = Vec::new();
    for (n, a) in combinations.iter().enumerate() {
        for b in &combinations[..n] {
            if (a.period_mm == b.period_mm) == same
                && let Some((a, b)) = first(a).zip(first(b))
            {
                all.extend(rms(a.iter().zip(&b).map(|(a, b)| Some(1e3 * (a - b)))));
            }
        }
    }
    ends(&all)
}

/// The firmware's greatest error with a perfect stimulator, percent, and where.
fn perfect(all: &Reproduction) -> Result<(String, f64)> {
    let each = all.expected.iter().filter_map(|cell| {
        let nominal_hz = cell.speed_mm_s / cell.period_mm;
        Some((cell, 100.0 * (cell.firmware_hz? / nominal_hz - 1.0).abs()))
    });
    let (cell, percent) = greatest(each)?;
    Ok((format!("{} mm/s, {} mm", cell.speed_mm_s, cell.period_mm), percent))
}

/// The firmware's greatest error against the true frequency in all runs, percent.
fn firmware_percent(combinations: &[Combination]) -> Result<f64> {
    let each = combinations.iter().flat_map(|c| &c.runs).filter_map(|run| {
        let (hz, _) = run.firmware?.tone_hz?;
        Some(((), 100.0 * (hz / run.true_hz - 1.0).abs()))
    });
    Ok(greatest(each)?.1)
}

/// The firmware's greatest errors of the slide's beginning and end, milliseconds.
fn slide_error_ms(combinations: &[Combination]) -> Result<(f64, f64)> {
    let runs: Vec<(f64, f64)> = combinations
        .iter()
        .flat_map(|c| &c.runs)
        .filter_map(|run| {
            let (start_s, end_s) = run.firmware?.slide_s;
            Some((1e3 * (start_s - run.true_slide_s.0).abs(), 1e3 * (end_s - run.true_slide_s.1).abs()))
        })
        .collect();
    let start = greatest(runs.iter().map(|run| ((), run.0)))?.1;
    Ok((start, greatest(runs.iter().map(|run| ((), run.1)))?.1))
}

/// Where not every window had an answer, and how many did.
fn told(combinations: &[Combination]) -> String {
    let missing = combinations.iter().flat_map(|c| {
        let some = c.windows.iter().filter(|window| window.all_told < window.windows);
        some.map(|w| format!("{} of {} windows of {} s of {}", w.all_told, w.windows, w.window_s, name(c)))
    });
    let missing: Vec<String> = missing.collect();
    if missing.is_empty() { "here in all of them".into() } else { missing.join(", ") }
}
