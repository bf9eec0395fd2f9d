//! The figures of Oddo et al. beside ours, as tables, and their picture.

use super::paper::{FREQUENCY_HZ, LENGTH_MM, NOT_TESTED, REPEATABILITY, TABLE_3};
use super::results::{Combination, Reproduction, Run, Windows};
use crate::page::{self, Bar, Table, Tables, figure, fixed};
use ridgetone_host::chart::{Curve, Look, Panel, Scale, chart};
use serde_json::Value;

/// Three standard deviations of a figure of four runs: the paper's scatter of 0.166 % around the
/// line through its Table 3, over the root of four.
const PAPER_SCATTER_PERCENT: f64 = 0.25;

/// The tables by names that tell them from those of the other paper.
pub fn tables(reproduction: &Reproduction) -> Tables {
    let combinations = &reproduction.combinations;
    let tables = [
        ("oddo_bars", page::bars(&bars(reproduction))),
        ("oddo_table_2", table_2(reproduction)),
        ("oddo_table_3", table_3(combinations)),
        ("oddo_causes", causes(reproduction)),
        ("oddo_figure_7", windows(combinations)),
        ("oddo_repeatability", repeatability(combinations)),
    ];
    tables
        .into_iter()
        .map(|(name, table)| (name.to_owned(), table))
        .collect()
}

fn fit(run: &Run) -> Option<f64> {
    run.all_fit_hz.map(|fit| fit.0)
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

/// What the paper found, and whether it comes out here.
fn bars(reproduction: &Reproduction) -> Vec<Bar> {
    let combinations = &reproduction.combinations;
    let numbered = || {
        combinations
            .iter()
            .filter_map(|own| Some((own.number()?, own)))
    };
    let mut bars = Vec::new();
    let mut bar = |what: &str, limit: &str, measured: String, met: bool| {
        bars.push(Bar {
            bar: what.into(),
            limit: limit.into(),
            measured,
            met,
        });
    };
    for (pair, (units, paper)) in ["1 and 2", "4 and 2"].into_iter().zip(TABLE_3).enumerate() {
        let off = numbered().filter_map(|(c, own)| {
            let here = own.percent(own.rms_hz(|run| run.pairs[pair].least_squares_hz)?);
            Some((here - paper.least_squares.percent[c]).abs())
        });
        let off: Vec<f64> = off.collect();
        for (limit_percent, of) in [
            (0.4, "ours"),
            (PAPER_SCATTER_PERCENT, "the paper's scatter"),
        ] {
            let within = off.iter().filter(|off| **off <= limit_percent).count();
            bar(
                &format!("Table 3, units {units}: least squares beside the paper, by {of}"),
                &format!("at most {limit_percent} % of the frequency"),
                format!(
                    "{within} of {}, up to {:.2} %",
                    off.len(),
                    greatest(off.iter().copied())
                ),
                within == off.len(),
            );
        }
        let near = numbered().filter(|(c, own)| {
            let here_hz = own.rms_hz(|run| run.pairs[pair].fft_hz);
            here_hz
                .is_some_and(|hz| (hz - paper.fft.hz[*c]).abs() * LENGTH_MM / own.speed_mm_s < 0.2)
        });
        let near = near.count();
        bar(
            &format!("Table 3, units {units}: FFT within a fifth of a line of the paper"),
            "at least 7 of 10",
            format!("{near} of {}", combinations.len()),
            near >= 7,
        );
    }
    let at = combinations.iter().filter_map(|own| {
        let window = own.windows.iter().find(|window| window.window_s == 0.4)?;
        Some(own.percent(window.least_squares_hz))
    });
    let at = greatest(at);
    bar(
        "Figure 7: least squares in 0.4 s",
        "within 2 %",
        format!("{at:.1} %"),
        at <= 2.0,
    );
    // As the paper prints them.
    let rounded = |r: f64| (100.0 * r).round() / 100.0;
    let range = |unit: usize| {
        let all = combinations
            .iter()
            .filter_map(|own| Some(own.repeatability?[unit]));
        all.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), r| {
            (a.min(r), b.max(r))
        })
    };
    for (unit, (from, to)) in REPEATABILITY.into_iter().enumerate() {
        let (least, most) = range(unit);
        bar(
            &format!("repeatability of unit {} (equation 11)", unit + 1),
            &format!("{from:.2} to {to:.2}"),
            format!("{least:.2} to {most:.2}"),
            rounded(least) >= from && rounded(most) <= to,
        );
    }
    bars
}

/// The columns that every table of combinations begins with.
fn first_cells(own: &Combination) -> [Value; 3] {
    [
        own.name().into(),
        own.period_mm.into(),
        own.speed_mm_s.into(),
    ]
}

fn table_2(reproduction: &Reproduction) -> Table {
    let mut table = Table::new(
        "speed, mm/s|period, mm|paper, Hz|here, Hz|firmware, Hz|slide's end late, s|tested by the paper",
    );
    for cell in &reproduction.expected {
        let line = (cell.speed_mm_s, cell.period_mm);
        let tested = hal_mock::TABLE_2
            .into_iter()
            .position(|tested| tested == line);
        let other = NOT_TESTED
            .into_iter()
            .find(|other| (other.0, other.1) == line);
        let paper = tested
            .map(|c| FREQUENCY_HZ[c])
            .or(other.map(|other| other.2));
        table.row([
            cell.speed_mm_s.into(),
            cell.period_mm.into(),
            fixed(paper, 2),
            fixed(cell.hz, 4),
            fixed(cell.firmware_hz, 4),
            fixed(cell.end_late_s, 3),
            if tested.is_some() { "yes" } else { "no" }.into(),
        ]);
    }
    table
}

/// Table 3 of both pairs, all sixteen channels, and the errors against the true frequency.
fn table_3(combinations: &[Combination]) -> Table {
    let mut table = Table::new(
        "C|period, mm|v, mm/s|units 1, 2: FFT, %|paper|least squares, %|paper|\
         units 4, 2: FFT, %|paper|least squares, %|paper|16: FFT, %|16: fit, %|\
         own: least squares, 2, %|own: fit, 16, %|own: firmware, %",
    );
    for own in combinations {
        let Some(c) = own.number() else { continue };
        let percent = |hz: Option<f64>, decimals| fixed(hz.map(|hz| own.percent(hz)), decimals);
        let mut cells = first_cells(own).to_vec();
        for (pair, paper) in TABLE_3.into_iter().enumerate() {
            cells.extend([
                percent(own.rms_hz(|run| run.pairs[pair].fft_hz), 2),
                paper.fft.percent[c].into(),
                percent(own.rms_hz(|run| run.pairs[pair].least_squares_hz), 2),
                paper.least_squares.percent[c].into(),
            ]);
        }
        cells.extend([
            percent(own.rms_hz(|run| run.all_fft_hz), 2),
            percent(own.rms_hz(fit), 2),
            percent(own.own_rms_hz(|run| run.pairs[0].least_squares_hz), 3),
            percent(own.own_rms_hz(fit), 3),
            percent(
                own.own_rms_hz(|run| run.firmware?.tone_hz.map(|tone| tone.0)),
                3,
            ),
        ]);
        table.row(cells);
    }
    table
}

/// The error that each imperfection makes alone.
fn causes(reproduction: &Reproduction) -> Table {
    let mut table = Table::new("imperfect|least squares, 2 channels, %|fit, 16 channels, %");
    for cause in &reproduction.causes {
        let errors = [cause.least_squares_percent, cause.all_percent].map(|error| figure(error, 2));
        table.row([Value::from(cause.name.as_str())].into_iter().chain(errors));
    }
    table
}

/// Figure 7: every length of window, least, median and greatest of the combinations.
fn windows(combinations: &[Combination]) -> Table {
    let names = ["FFT, 2", "least squares, 2", "fit, 16", "fit, 16, own"];
    let columns = names
        .map(|name| format!("{name}: least, %|median, %|greatest, %"))
        .join("|");
    let mut table = Table::new(&format!(
        "window, s|{columns}|least share with a frequency, %"
    ));
    for window_s in super::measure::window_lengths_s() {
        let of_length =
            |own: &Combination| own.windows.iter().find(|w| w.window_s == window_s).copied();
        let all: Vec<(&Combination, Windows)> = combinations
            .iter()
            .filter_map(|own| Some((own, of_length(own)?)))
            .collect();
        let spread = |hz: &dyn Fn(&Windows) -> Option<f64>| {
            let errors = all.iter().filter_map(|(own, w)| Some(own.percent(hz(w)?)));
            let mut errors: Vec<f64> = errors.collect();
            errors.sort_by(f64::total_cmp);
            let middle = (!errors.is_empty())
                .then(|| 0.5 * (errors[(errors.len() - 1) / 2] + errors[errors.len() / 2]));
            [errors.first().copied(), middle, errors.last().copied()].map(|error| figure(error, 2))
        };
        let errors = [
            spread(&|window| Some(window.fft_hz)),
            spread(&|window| Some(window.least_squares_hz)),
            spread(&|window| window.all_hz),
            spread(&|window| window.own_all_hz),
        ];
        let found = all
            .iter()
            .map(|(_, w)| 100 * w.all_found / w.windows.max(1))
            .min();
        table.row(
            [window_s.into()]
                .into_iter()
                .chain(errors.concat())
                .chain([found.into()]),
        );
    }
    table
}

/// Repeatability by combination, beside the paper's ranges.
fn repeatability(combinations: &[Combination]) -> Table {
    let mut table = Table::new("C|period, mm|v, mm/s|unit 1|unit 2|paper: unit 1|paper: unit 2");
    for own in combinations {
        let here = [0, 1].map(|unit| fixed(own.repeatability.map(|both| both[unit]), 2));
        let paper = REPEATABILITY.map(|(from, to)| Value::from(format!("{from:.2} to {to:.2}")));
        table.row(first_cells(own).into_iter().chain(here).chain(paper));
    }
    table
}

/// Errors by combination: the paper's and ours near 1 %, those against the true speed far below.
pub fn picture(reproduction: &Reproduction) -> String {
    let combinations = &reproduction.combinations;
    let curve = |name: &str, look, error: &dyn Fn(usize, &Combination) -> Option<f64>| {
        let points = combinations.iter().filter_map(|own| {
            let c = own.number()?;
            Some(((c + 1) as f64, error(c, own)?))
        });
        Curve {
            name: name.to_owned(),
            look,
            points: points.collect(),
        }
    };
    let paper = TABLE_3[0];
    let curves = vec![
        curve("paper, FFT", Look::Marked(0), &|c, _| {
            Some(paper.fft.percent[c])
        }),
        curve("FFT, 2 channels", Look::Marked(4), &|_, own| {
            Some(own.percent(own.rms_hz(|run| run.pairs[0].fft_hz)?))
        }),
        curve("paper, least squares", Look::Marked(1), &|c, _| {
            Some(paper.least_squares.percent[c])
        }),
        curve("least squares, 2 channels", Look::Marked(5), &|_, own| {
            Some(own.percent(own.rms_hz(|run| run.pairs[0].least_squares_hz)?))
        }),
        curve(
            "fit, 16 channels, against the true speed",
            Look::Marked(2),
            &|_, own| Some(own.percent(own.own_rms_hz(fit)?)),
        ),
    ];
    let names = combinations
        .iter()
        .filter_map(|own| Some(((own.number()? + 1) as f64, own.name())));
    let panel = Panel {
        title: "RMS error by combination, % of the nominal frequency".into(),
        x: Scale {
            label: "combination of grating and speed".into(),
            names: names.collect(),
            ..Scale::default()
        },
        y: Scale {
            label: "percent".into(),
            is_log: true,
            ..Scale::default()
        },
        curves,
    };
    chart(
        "Errors of each combination: the paper's and the simulated ones",
        &[panel],
    )
}
