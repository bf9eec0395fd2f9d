//! The figures in the text of `docs/reproduction.md`.

use super::Reproduction;
use super::charts::number;
use super::fourier;
use super::paper::{GRATINGS_MM, REPEATABILITY, TABLE_3};
use super::protocol::Line;
use super::results::{Combination, Expected, Run, rms};
use super::tables::{all_fit, at, percent};
use anyhow::{Result, bail};
use ridgetone_host::fit_report::significant;

/// A slide's end this late, seconds, is worth a word.
const LATE_S: f64 = 0.05;

/// Least and greatest.
fn ends(values: &[f64]) -> Option<(f64, f64)> {
    let fold = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (v.min(l), v.max(m)));
    Some(fold).filter(|(least, most)| least <= most)
}

/// The greatest of some figures and what it is of.
fn greatest<T: Copy>(values: impl Iterator<Item = (T, f64)>) -> Option<(T, f64)> {
    values.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn name(combination: &Combination) -> String {
    number(combination).map_or_else(String::new, |c| format!("C{}", c + 1))
}

/// A figure of the text by its name; a dash where the run lacks what it is made of.
///
/// # Errors
/// There is no such name.
pub fn finding(all: &Reproduction, wanted: &str) -> Result<String> {
    Ok(found(all, wanted)?.unwrap_or_else(|| "-".into()))
}

fn found(all: &Reproduction, wanted: &str) -> Result<Option<String>> {
    let combinations = &all.combinations;
    let paper = TABLE_3[0].least_squares.percent;
    let two = |run: &Run| run.pairs[0].least_squares_hz;
    let here: Vec<f64> = combinations.iter().filter_map(|c| percent(c.rms_hz(two), c)).collect();
    let apart = |pair| least_squares_apart(combinations, pair);
    let two_digits = |value: f64| significant(value, 2);
    let decimals = |value: Option<f64>, count: usize| value.map(|value| format!("{value:.count$}"));
    let ideal = all.causes.first();
    Ok(match wanted {
        "ls_least" => decimals(ends(&here).map(|e| e.0), 2),
        "ls_most" => decimals(ends(&here).map(|e| e.1), 2),
        "paper_ls_least" => decimals(ends(&paper).map(|e| e.0), 2),
        "paper_ls_most" => decimals(ends(&paper).map(|e| e.1), 2),
        "ls_apart_rms_1" => decimals(rms(apart(0).map(|(_, off)| Some(off))), 2),
        "ls_apart_rms_2" => decimals(rms(apart(1).map(|(_, off)| Some(off))), 2),
        "ls_apart_most_1" => greatest(apart(0)).map(|(c, off)| format!("{off:.2} % ({})", name(c))),
        "ls_apart_most_2" => greatest(apart(1)).map(|(c, off)| format!("{off:.2} % ({})", name(c))),
        "ideal_two" => ideal.map(|cause| two_digits(cause.least_squares_percent)),
        "ideal_all" => ideal.map(|cause| two_digits(cause.all_percent)),
        "own_two" => own(combinations, two).map(two_digits),
        "own_all" => own(combinations, all_fit).map(two_digits),
        "fft_close_1" => Some(fourier_close(combinations, 0)),
        "fft_close_2" => Some(fourier_close(combinations, 1)),
        "fft_worst_1" => fourier_worst(combinations, 0),
        "fft_worst_2" => fourier_worst(combinations, 1),
        "fft_off_lines" => decimals(fourier::off_lines_hz(0.0), 3),
        "fft_off_lines_less" => decimals(fourier::off_lines_hz(1.0), 3),
        "ls_at_04" => decimals(ends(&at(combinations, 0.4, &|w| Some(w.least_squares_hz))).map(|e| e.1), 1),
        "fft_at_04" => decimals(ends(&at(combinations, 0.4, &|w| Some(w.fft_hz))).map(|e| e.1), 0),
        "r1_least" => decimals(repeatability(combinations, 0).map(|e| e.0), 2),
        "r1_most" => decimals(repeatability(combinations, 0).map(|e| e.1), 2),
        "r2_least" => decimals(repeatability(combinations, 1).map(|e| e.0), 2),
        "r2_most" => decimals(repeatability(combinations, 1).map(|e| e.1), 2),
        "r2_needed" => decimals(Some(needed_percent()), 0),
        "edge_percent" => decimals(edge_percent(combinations), 0),
        "opposite" => decimals(all.pictures.opposite.as_ref().map(|opposite| opposite.correlation), 2),
        "same_grating" => decimals(images(combinations, true).map(|e| e.1), 2),
        "other_grating" => decimals(images(combinations, false).map(|e| e.0), 2),
        "gratings_apart" => Some(gratings_apart()),
        "period_um" => decimals(Some(1e3 * 4.1 * 0.01 * off_line_percent(4.1).abs()), 0),
        "firmware_ideal" => perfect(all).map(|worst| two_digits(worst.1)),
        "firmware_ideal_where" => perfect(all).map(|worst| worst.0),
        "firmware_own" => decimals(firmware_percent(combinations), 3),
        "start_error" => decimals(slide_error_ms(combinations).map(|e| e.0), 0),
        "end_error" => decimals(slide_error_ms(combinations).map(|e| e.1), 0),
        "late" => Some(late(all)),
        "told" => Some(told(combinations)),
        other => bail!("the template asks for {other}"),
    })
}

/// By how much least squares on a pair of channels differ from the paper's errors, percent of the nominal frequency.
fn least_squares_apart(combinations: &[Combination], pair: usize) -> impl Iterator<Item = (&Combination, f64)> {
    combinations.iter().filter_map(move |c| {
        let here = percent(c.rms_hz(|run| run.pairs[pair].least_squares_hz), c)?;
        Some((c, (here - TABLE_3[pair].least_squares.percent[number(c)?]).abs()))
    })
}

/// RMS over all runs of a method's error against the true frequency, percent.
fn own(combinations: &[Combination], of: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
    rms(combinations.iter().flat_map(|c| &c.runs).map(|run| Some(100.0 * (of(run)? / run.true_hz - 1.0))))
}

/// In how many combinations naive Fourier analysis is within a fifth of a line's distance of the paper's error.
fn fourier_close(combinations: &[Combination], pair: usize) -> String {
    fourier::errors(combinations, pair).filter(|errors| errors.apart_lines() < 0.2).count().to_string()
}

/// The combination in which naive Fourier analysis differs most from the paper's, by lines, and both errors.
fn fourier_worst(combinations: &[Combination], pair: usize) -> Option<String> {
    let most = greatest(fourier::errors(combinations, pair).map(|errors| (errors, errors.apart_lines())));
    most.map(|(errors, _)| {
        let fourier::Errors { combination, here_hz, paper_hz } = errors;
        format!("{} by {here_hz:.3} Hz here and by {paper_hz:.3} Hz in the paper", name(combination))
    })
}

fn repeatability(combinations: &[Combination], channel: usize) -> Option<(f64, f64)> {
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
fn edge_percent(combinations: &[Combination]) -> Option<f64> {
    let ratios = combinations.iter().filter_map(|c| c.repeatability).map(|[one, two]| {
        let noise = |r: f64| (1.0 - r) / r;
        (noise(two) / noise(one)).sqrt()
    });
    let ratios: Vec<f64> = ratios.collect();
    (!ratios.is_empty()).then(|| 100.0 * (ratios.iter().sum::<f64>() / ratios.len() as f64 - 1.0))
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
fn images(combinations: &[Combination], same: bool) -> Option<(f64, f64)> {
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
fn perfect(all: &Reproduction) -> Option<(String, f64)> {
    let each = all.expected.iter().filter_map(|cell| {
        let nominal_hz = cell.speed_mm_s / cell.period_mm;
        Some((cell, 100.0 * (cell.firmware_hz? / nominal_hz - 1.0).abs()))
    });
    let (cell, percent) = greatest(each)?;
    Some((format!("{} mm/s, {} mm", cell.speed_mm_s, cell.period_mm), percent))
}

/// Where the slide's end is told late without noise, a sentence about it.
fn late(all: &Reproduction) -> String {
    let most = greatest(all.expected.iter().filter_map(|cell| Some((cell, cell.end_late_s?))));
    let late = most.filter(|(_, late_s)| *late_s > LATE_S);
    late.map_or_else(String::new, |(cell, late_s)| {
        let Expected { speed_mm_s, period_mm, .. } = cell;
        format!(
            " Without noise the skin's creep after the slide looks like a part of it: its end is found up to {late_s:.2} s late \
             ({speed_mm_s} mm/s, {period_mm} mm)."
        )
    })
}

/// The firmware's greatest error against the true frequency in all runs, percent.
fn firmware_percent(combinations: &[Combination]) -> Option<f64> {
    let each = combinations.iter().flat_map(|c| &c.runs).filter_map(|run| {
        let (hz, _) = run.firmware?.tone_hz?;
        Some(((), 100.0 * (hz / run.true_hz - 1.0).abs()))
    });
    greatest(each).map(|most| most.1)
}

/// The firmware's greatest errors of the slide's beginning and end, milliseconds.
fn slide_error_ms(combinations: &[Combination]) -> Option<(f64, f64)> {
    let runs: Vec<(f64, f64)> = combinations
        .iter()
        .flat_map(|c| &c.runs)
        .filter_map(|run| {
            let (start_s, end_s) = run.firmware?.slide_s;
            Some((1e3 * (start_s - run.true_slide_s.0).abs(), 1e3 * (end_s - run.true_slide_s.1).abs()))
        })
        .collect();
    let most = |of: fn(&(f64, f64)) -> f64| greatest(runs.iter().map(|run| ((), of(run)))).map(|most| most.1);
    Some((most(|run| run.0)?, most(|run| run.1)?))
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
