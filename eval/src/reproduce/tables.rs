//! The tables of `docs/reproduction.md`.

use super::Reproduction;
use super::charts::number;
use super::paper::{FREQUENCY_HZ, GRATINGS_MM, NOT_TESTED, PairErrors, REPEATABILITY, TABLE_3};
use super::results::{Combination, Run, Windows};
use crate::markdown::Table;
use ridgetone_host::fit_report::significant;

/// A figure of so many decimals, or a dash where there is none.
fn figure(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.decimals$}"))
}

/// The first columns: name, spatial period, speed.
fn line(combination: &Combination) -> Vec<String> {
    let name = number(combination).map_or_else(String::new, |c| format!("C{}", c + 1));
    vec![name, combination.period_mm.to_string(), combination.speed_mm_s.to_string()]
}

/// Speeds of Table 2, mm/s.
const SPEEDS_MM_S: [f64; 3] = [15.0, 30.0, 48.0];

/// Table 2: the paper's and ours in pairs of columns, by speed and by grating.
pub fn table_2(reproduction: &Reproduction) -> String {
    let mut headings = vec!["v, mm/s".to_owned()];
    let coarse_first = || GRATINGS_MM.into_iter().rev();
    headings.extend(coarse_first().flat_map(|mm| [format!("{mm} mm: paper"), "here".into()]));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    let mut table = Table::new(0, &headings);
    for speed_mm_s in SPEEDS_MM_S {
        let mut row = vec![speed_mm_s.to_string()];
        for period_mm in coarse_first() {
            let tested = hal_mock::TABLE_2.into_iter().position(|line| line == (speed_mm_s, period_mm));
            let paper = tested.map(|c| FREQUENCY_HZ[c]).or_else(|| {
                NOT_TESTED.into_iter().find(|cell| (cell.0, cell.1) == (speed_mm_s, period_mm)).map(|cell| cell.2)
            });
            let star = if tested.is_none() { " (not tested)" } else { "" };
            row.push(format!("{}{star}", figure(paper, 2)));
            let same = |cell: &&super::Expected| (cell.speed_mm_s, cell.period_mm) == (speed_mm_s, period_mm);
            row.push(figure(reproduction.expected.iter().find(same).and_then(|cell| cell.hz), 4));
        }
        table.row(&row);
    }
    table.end()
}

/// Table 3 for one of the paper's pairs.
pub fn table_3(combinations: &[Combination], pair: usize, paper: &PairErrors) -> String {
    let headings = [
        "C",
        "period, mm",
        "v, mm/s",
        "nominal, Hz",
        "FFT, Hz: here",
        "paper",
        "FFT, %: here",
        "paper",
        "LSq, Hz: here",
        "paper",
        "LSq, %: here",
        "paper",
    ];
    let mut table = Table::new(1, &headings);
    for combination in combinations {
        let Some(c) = number(combination) else { continue };
        let mut row = line(combination);
        row.push(figure(Some(FREQUENCY_HZ[c]), 2));
        let fft = combination.rms_hz(|run| run.pairs[pair].fft_hz);
        let least_squares = combination.rms_hz(|run| run.pairs[pair].least_squares_hz);
        for (hz, paper) in [(fft, paper.fft), (least_squares, paper.least_squares)] {
            row.extend([figure(hz, 3), figure(Some(paper.hz[c]), 3)]);
            row.extend([figure(percent(hz, combination), 2), figure(Some(paper.percent[c]), 2)]);
        }
        table.row(&row);
    }
    table.end()
}

/// Hertz in percent of the nominal frequency.
pub fn percent(hz: Option<f64>, combination: &Combination) -> Option<f64> {
    hz.map(|hz| 100.0 * hz / combination.nominal_hz())
}

/// The paper's row of the first pair beside all sixteen channels, and the methods' own errors.
pub fn table_3_all(combinations: &[Combination]) -> String {
    let headings = [
        "C",
        "period, mm",
        "v, mm/s",
        "paper, LSq, %",
        "16: FFT, Hz",
        "16: FFT, %",
        "16: fit, Hz",
        "16: fit, %",
        "own: LSq, 2, %",
        "own: fit, 16, %",
        "own: firmware, %",
    ];
    let mut table = Table::new(1, &headings);
    for combination in combinations {
        let Some(c) = number(combination) else { continue };
        let mut row = line(combination);
        row.push(figure(Some(TABLE_3[0].least_squares.percent[c]), 2));
        for hz in [combination.rms_hz(|run| run.all_fft_hz), combination.rms_hz(all_fit)] {
            row.extend([figure(hz, 3), figure(percent(hz, combination), 2)]);
        }
        let own = [
            combination.own_rms_hz(|run| run.pairs[0].least_squares_hz),
            combination.own_rms_hz(all_fit),
            combination.own_rms_hz(|run| run.firmware?.tone_hz.map(|tone| tone.0)),
        ];
        row.extend(own.map(|hz| figure(percent(hz, combination), 3)));
        table.row(&row);
    }
    table.end()
}

/// The frequency of our fit of all channels.
pub fn all_fit(run: &Run) -> Option<f64> {
    run.all_fit_hz.map(|fit| fit.0)
}

/// What each imperfection makes alone.
pub fn causes(reproduction: &Reproduction) -> String {
    let mut table = Table::new(1, &["imperfect", "least squares, 2 channels, %", "fit, 16 channels, %"]);
    for cause in &reproduction.causes {
        let [two, all] = [cause.least_squares_percent, cause.all_percent].map(|percent| significant(percent, 2));
        table.row(&[cause.name.clone(), two, all]);
    }
    table.end()
}

/// Lengths of windows in the table under Figure 7, seconds.
const LENGTHS_S: [f64; 6] = [0.2, 0.35, 0.4, 0.6, 0.8, 1.0];

/// Figure 7 in short: least, median and greatest of the combinations.
pub fn windows(combinations: &[Combination]) -> String {
    let headings =
        ["window, s", "FFT, 2 channels", "least squares, 2 channels", "fit, 16 channels", "fit, 16 channels, own"];
    let mut table = Table::new(0, &headings);
    for window_s in LENGTHS_S {
        let of = |hz: &dyn Fn(&Windows) -> Option<f64>| {
            let mut all = at(combinations, window_s, hz);
            all.sort_by(f64::total_cmp);
            let [Some(least), Some(most)] = [all.first(), all.last()] else { return "-".into() };
            let middle = 0.5 * (all[(all.len() - 1) / 2] + all[all.len() / 2]);
            [*least, middle, *most].map(|percent| significant(percent, 2)).join(", ")
        };
        table.row(&[
            window_s.to_string(),
            of(&|window| Some(window.fft_hz)),
            of(&|window| Some(window.least_squares_hz)),
            of(&|window| window.all_hz),
            of(&|window| window.own_all_hz),
        ]);
    }
    table.end()
}

/// A figure of the windows of a length in all combinations that have it, percent of the nominal frequency.
pub fn at(combinations: &[Combination], window_s: f64, hz: &dyn Fn(&Windows) -> Option<f64>) -> Vec<f64> {
    let each = combinations.iter().filter_map(|combination| {
        let window = combination.windows.iter().find(|window| window.window_s == window_s)?;
        percent(hz(window), combination)
    });
    each.collect()
}

/// Repeatability by combination, and the paper's ranges.
pub fn repeatability(combinations: &[Combination]) -> String {
    let names: Vec<String> = combinations.iter().map(|combination| line(combination)[0].clone()).collect();
    let mut headings = vec!["piezoresistor 1 of"];
    headings.extend(names.iter().map(String::as_str));
    headings.push("paper");
    let mut table = Table::new(1, &headings);
    for (n, (least, most)) in REPEATABILITY.into_iter().enumerate() {
        let mut row = vec![format!("MEMS {}", n + 1)];
        row.extend(combinations.iter().map(|combination| figure(combination.repeatability.map(|both| both[n]), 2)));
        row.push(format!("{least:.2} to {most:.2}"));
        table.row(&row);
    }
    table.end()
}
