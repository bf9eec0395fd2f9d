//! `docs/trade.md`: the text of a template around the tables of a run.
//!
//! In the template `{{name}}` stands for what the run gives. Behind the line `{{reasons}}` come hand-written reasons why
//! a bar is not met, each under a heading `### ` with the bar's name; those of bars that are met stay out.

use super::grid::Row;
use super::{BarResult, Trade, tables};
use crate::bench::{HARMONICS, grouped};
use crate::markdown::filled;
use anyhow::{Context, Result, bail};
use ridgetone_proto::settings::TAXELS;

const TEMPLATE: &str = include_str!("template.md");
const REASONS: &str = "{{reasons}}\n";

/// The document.
///
/// # Errors
/// The template asks for what there is not; the run lacks a row that the advice is about.
pub fn document(trade: &Trade) -> Result<String> {
    let (text, reasons) = TEMPLATE.split_once(REASONS).context("the template has no place for reasons")?;
    let verdicts = trade.verdicts();
    let windows = trade.bars.windows;
    filled(text, |name| {
        Ok(match name {
            "advice" => advice(trade)?,
            "ridgetone" => tables::ridgetone(trade),
            "harmonics" => tables::harmonics(trade),
            "baselines" => tables::baselines(trade),
            "bars" => tables::bars(&verdicts),
            "unmet" => unmet(&verdicts, reasons),
            "cells" => tables::cells(&trade.bars),
            "row_windows" => grouped(trade.windows.into()),
            "bar_windows" => grouped(windows.accuracy.into()),
            "noise_windows" => grouped(windows.noise.into()),
            other => bail!("the template asks for {other}"),
        })
    })
}

/// What to choose: the sentences that the README has too.
///
/// # Errors
/// The run lacks a row.
pub fn advice(trade: &Trade) -> Result<String> {
    let [one, .., four] = HARMONICS;
    let all = TAXELS as u8;
    let row = |window_s: f64, harmonics: u8, channels: u8| {
        let row = trade.ridgetone(window_s, four, harmonics, channels);
        row.with_context(|| format!("no row of {window_s} s, {harmonics} harmonics, {channels} channels"))
    };
    let error = |row: &Row| format!("{} %", tables::percent(row));
    let cost = |row: &Row| -> Result<String> {
        let milliseconds = 1e3 * (row.latency_s().context("instructions were not counted")? - row.window_s);
        Ok(format!("{} instructions ({milliseconds:.1} ms)", row.instructions.map_or_else(String::new, about)))
    };
    let (shortest, short, usual, long) =
        (row(0.2, four, all)?, row(0.4, four, all)?, row(1.0, four, all)?, row(3.9, four, all)?);
    Ok(format!(
        "Keep all sixteen channels and four harmonics, and choose the window by the error you can live with: of a grating \
         with noise 20 dB below its tone, 0.2 s know the frequency to {} RMS, 0.4 s to {}, 1 s to {} and 3.9 s to {}; \
         the fit adds at most {} to a window of 0.2 s and {} to one of 1 s. Four channels instead of sixteen make it {} \
         in 1 s for {}. A single harmonic costs {}, but errs by {} in 0.2 s and {} in 1 s where there are overtones: set \
         it only for a pure tone.",
        error(shortest),
        error(short),
        error(usual),
        error(long),
        cost(shortest)?,
        cost(usual)?,
        error(row(1.0, four, 4)?),
        cost(row(1.0, four, 4)?)?,
        cost(row(1.0, one, all)?)?,
        error(row(0.2, one, all)?),
        error(row(1.0, one, all)?),
    ))
}

/// Lines around the advice in the README.
const MARKS: [&str; 2] = ["<!-- from docs/trade.json -->\n", "<!-- end -->\n"];
/// Width of its lines, characters.
const WIDTH: usize = 104;

/// The README with the advice between its marks; none if it has no marks.
pub fn with_advice(readme: &str, advice: &str) -> Option<String> {
    let (before, rest) = readme.split_once(MARKS[0])?;
    let (_, after) = rest.split_once(MARKS[1])?;
    let (mut text, mut line) = (String::new(), String::new());
    for word in advice.split_whitespace() {
        if !line.is_empty() && line.len() + 1 + word.len() > WIDTH {
            text += &format!("{}\n", std::mem::take(&mut line));
        }
        line += if line.is_empty() { "" } else { " " };
        line += word;
    }
    Some(format!("{before}{}{text}{line}\n{}{after}", MARKS[0], MARKS[1]))
}

/// A number of instructions in words: millions, or whole thousands.
fn about(number: u32) -> String {
    match number {
        0..1000 => number.to_string(),
        1000..1_000_000 => grouped(u64::from(number).div_ceil(1000) * 1000),
        _ => format!("{:.1} million", f64::from(number) / 1e6),
    }
}

/// Bars that are not met, each with its figure and the reason, if one is written.
fn unmet(verdicts: &[BarResult], reasons: &str) -> String {
    let sections = verdicts.iter().filter(|verdict| !verdict.met).map(|BarResult { bar, limit, measured, .. }| {
        let mut section = format!("### {bar}\n\nAllowed: {limit}. Measured: {measured}.");
        if let Some(reason) = reason(bar, reasons) {
            section += &format!("\n\n{reason}");
        }
        section
    });
    let sections: Vec<String> = sections.collect();
    if sections.is_empty() { "All bars are met.".into() } else { sections.join("\n\n") }
}

/// The reason that is written for a bar.
fn reason<'a>(bar: &str, reasons: &'a str) -> Option<&'a str> {
    let mut sections = reasons.split("### ");
    sections.find_map(|section| section.strip_prefix(bar)?.strip_prefix('\n')).map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_is_put_between_its_marks_in_lines() {
        let [from, to] = MARKS;
        let advice = "word ".repeat(30);
        let readme = with_advice(&format!("a\n{from}old\n{to}b\n"), &advice).expect("marks");
        assert_eq!(readme, format!("a\n{from}{}\n{}\n{to}b\n", ["word"; 21].join(" "), ["word"; 9].join(" ")));
        assert_eq!(with_advice(&readme, &advice), Some(readme.clone()));
        assert_eq!(with_advice("no marks", &advice), None);
    }

    #[test]
    fn only_what_is_not_met_has_a_section_with_its_reason() {
        let verdict = |bar: &str, met| BarResult { bar: bar.into(), limit: "1".into(), measured: "2".into(), met };
        let reasons = "### long\nNot this.\n### long bar\n\nThe reason.\n\n### short\nAnother.\n";
        let text = unmet(&[verdict("long bar", false), verdict("short", true), verdict("third", false)], reasons);
        assert_eq!(
            text,
            "### long bar\n\nAllowed: 1. Measured: 2.\n\nThe reason.\n\n### third\n\nAllowed: 1. Measured: 2."
        );
        assert_eq!(unmet(&[verdict("short", true)], reasons), "All bars are met.");
    }
}
