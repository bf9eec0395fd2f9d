//! The tables of `docs/results/reproduction.md`.

use super::paper::{FREQUENCY_HZ, GRATINGS_MM, NOT_TESTED, PairErrors, REPEATABILITY, TABLE_3};
use super::results::{Combination, Reproduction, Run, Windows};
use crate::page::{Table, figure};
use ridgetone_host::digits::significant;

pub fn table(reproduction: &Reproduction, name: &str) -> Option<String> {
    let combinations = &reproduction.combinations;
    Some(match name {
        "table_2" => table_2(reproduction),
        "table_3_1" => table_3(combinations, 0, &TABLE_3[0]),
        "table_3_2" => table_3(combinations, 1, &TABLE_3[1]),
        "table_3_all" => table_3_all(combinations),
        "causes" => causes(reproduction),
        "windows" => windows(combinations),
        "repeatability" => repeatability(combinations),
        _ => return None,
    })
}

/// The first columns: name, spatial period, speed.
fn first_cells(combination: &Combination) -> Vec<String> {
    vec![
        combination.name(),
        combination.period_mm.to_string(),
        combination.speed_mm_s.to_string(),
    ]
}

/// Speeds of Table 2, mm/s.
const SPEEDS_MM_S: [f64; 3] = [15.0, 30.0, 48.0];

/// Table 2: the paper's and ours in pairs of columns, by speed and by grating.
fn table_2(reproduction: &Reproduction) -> String {
    let coarse_first = || GRATINGS_MM.into_iter().rev();
    let pairs = coarse_first().map(|mm| format!("|{mm} mm: paper|here"));
    let mut table = Table::new(0, &format!("v, mm/s{}", pairs.collect::<String>()));
    for speed_mm_s in SPEEDS_MM_S {
        let mut row = vec![speed_mm_s.to_string()];
        for period_mm in coarse_first() {
            let tested = hal_mock::TABLE_2
                .into_iter()
                .position(|line| line == (speed_mm_s, period_mm));
            let paper = tested.map(|c| FREQUENCY_HZ[c]).or_else(|| {
                NOT_TESTED
                    .into_iter()
                    .find(|cell| (cell.0, cell.1) == (speed_mm_s, period_mm))
                    .map(|cell| cell.2)
            });
            let note = if tested.is_none() {
                " (not tested)"
            } else {
                ""
            };
            let mut cells = reproduction.expected.iter();
            let cell =
                cells.find(|cell| (cell.speed_mm_s, cell.period_mm) == (speed_mm_s, period_mm));
            row.extend([
                format!("{}{note}", figure(paper, 2)),
                figure(cell.and_then(|cell| cell.hz), 4),
            ]);
        }
        table.row(&row);
    }
    table.end()
}

/// Table 3 for one of the paper's pairs.
fn table_3(combinations: &[Combination], pair: usize, paper: &PairErrors) -> String {
    let headings = "C|period, mm|v, mm/s|nominal, Hz|FFT, Hz: here|paper|FFT, %: here|paper|LSq, Hz: here|paper|\
                    LSq, %: here|paper";
    let mut table = Table::new(1, headings);
    for combination in combinations {
        let Some(c) = combination.number() else {
            continue;
        };
        let mut row = first_cells(combination);
        row.push(figure(Some(FREQUENCY_HZ[c]), 2));
        let fft = combination.rms_hz(|run| run.pairs[pair].fft_hz);
        let least_squares = combination.rms_hz(|run| run.pairs[pair].least_squares_hz);
        for (hz, paper) in [(fft, paper.fft), (least_squares, paper.least_squares)] {
            row.extend([figure(hz, 3), figure(Some(paper.hz[c]), 3)]);
            row.extend([
                percent(combination, hz, 2),
                figure(Some(paper.percent[c]), 2),
            ]);
        }
        table.row(&row);
    }
    table.end()
}

fn percent(combination: &Combination, hz: Option<f64>, decimals: usize) -> String {
    figure(hz.map(|hz| combination.percent(hz)), decimals)
}

/// The paper's row of the first pair beside all sixteen channels, and the methods' own errors.
fn table_3_all(combinations: &[Combination]) -> String {
    let headings = "C|period, mm|v, mm/s|paper, LSq, %|16: FFT, Hz|16: FFT, %|16: fit, Hz|16: fit, %|own: LSq, 2, %|\
                    own: fit, 16, %|own: firmware, %";
    let mut table = Table::new(1, headings);
    let all_fit = |run: &Run| run.all_fit_hz.map(|fit| fit.0);
    for combination in combinations {
        let Some(c) = combination.number() else {
            continue;
        };
        let mut row = first_cells(combination);
        row.push(figure(Some(TABLE_3[0].least_squares.percent[c]), 2));
        for hz in [
            combination.rms_hz(|run| run.all_fft_hz),
            combination.rms_hz(all_fit),
        ] {
            row.extend([figure(hz, 3), percent(combination, hz, 2)]);
        }
        let own = [
            combination.own_rms_hz(|run| run.pairs[0].least_squares_hz),
            combination.own_rms_hz(all_fit),
            combination.own_rms_hz(|run| run.firmware?.tone_hz.map(|tone| tone.0)),
        ];
        row.extend(own.map(|hz| percent(combination, hz, 3)));
        table.row(&row);
    }
    table.end()
}

/// The error that each imperfection makes alone.
fn causes(reproduction: &Reproduction) -> String {
    let mut table = Table::new(
        1,
        "imperfect|least squares, 2 channels, %|fit, 16 channels, %",
    );
    for cause in &reproduction.causes {
        let [two, all] =
            [cause.least_squares_percent, cause.all_percent].map(|percent| significant(percent, 2));
        table.row(&[cause.name.clone(), two, all]);
    }
    table.end()
}

/// Lengths of windows in the table under Figure 7, seconds.
const LENGTHS_S: [f64; 6] = [0.2, 0.35, 0.4, 0.6, 0.8, 1.0];

/// Figure 7 in short: least, median and greatest of the combinations.
fn windows(combinations: &[Combination]) -> String {
    let headings = "window, s|FFT, 2 channels|least squares, 2 channels|fit, 16 channels|fit, 16 channels, own|\
                    windows with a frequency, %";
    let mut table = Table::new(0, headings);
    for window_s in LENGTHS_S {
        let all: Vec<(&Combination, &Windows)> = combinations
            .iter()
            .flat_map(|c| {
                c.windows
                    .iter()
                    .filter(|w| w.window_s == window_s)
                    .map(move |w| (c, w))
            })
            .collect();
        let of = |hz: &dyn Fn(&Windows) -> Option<f64>| {
            let mut all: Vec<f64> = all
                .iter()
                .filter_map(|(c, w)| Some(c.percent(hz(w)?)))
                .collect();
            all.sort_by(f64::total_cmp);
            let [Some(least), Some(most)] = [all.first(), all.last()] else {
                return "-".into();
            };
            let middle = 0.5 * (all[(all.len() - 1) / 2] + all[all.len() / 2]);
            [*least, middle, *most]
                .map(|percent| significant(percent, 2))
                .join(", ")
        };
        let found = all
            .iter()
            .map(|(_, w)| 100 * w.all_found / w.windows.max(1))
            .min();
        table.row(&[
            window_s.to_string(),
            of(&|window| Some(window.fft_hz)),
            of(&|window| Some(window.least_squares_hz)),
            of(&|window| window.all_hz),
            of(&|window| window.own_all_hz),
            found.map_or_else(|| "-".into(), |percent| percent.to_string()),
        ]);
    }
    table.end()
}

/// Repeatability by combination, and the paper's ranges.
fn repeatability(combinations: &[Combination]) -> String {
    let first = std::iter::once("piezoresistor 1 of".into());
    let headings = first
        .chain(combinations.iter().map(Combination::name))
        .chain(["paper".into()]);
    let mut table = Table::new(1, &headings.collect::<Vec<String>>().join("|"));
    for (n, (least, most)) in REPEATABILITY.into_iter().enumerate() {
        let mut row = vec![format!("MEMS {}", n + 1)];
        row.extend(
            combinations
                .iter()
                .map(|combination| figure(combination.repeatability.map(|both| both[n]), 2)),
        );
        row.push(format!("{least:.2} to {most:.2}"));
        table.row(&row);
    }
    table.end()
}
