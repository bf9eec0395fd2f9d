//! The tables of `docs/results/trade.md`.

use super::bars::{Bars, LENGTHS, SNRS_DB};
use super::results::{NLS, RIDGETONE, Row, Trade};
use crate::accuracy::Accuracy;
use crate::bar;
use crate::baselines::Method;
use crate::bench::baselines::CARRIED;
use crate::bench::feels;
use crate::bench::fits::{CHANNELS, HARMONICS, WINDOWS_S};
use crate::noise;
use crate::page::{Table, figure, grouped, over_bound};
use crate::setting::Setting;
use hal_mock::TABLE_2;
use ridgetone_host::digits::significant;
use ridgetone_proto::settings::TAXELS;

pub fn table(trade: &Trade, name: &str) -> Option<String> {
    Some(match name {
        "windows" => windows(trade),
        "ridgetone" => ridgetone(trade),
        "harmonics" => harmonics(trade),
        "baselines" => baselines(trade),
        "bars" => bar::table(&trade.all_bars()),
        "feels" => feels::table(&trade.feels),
        "cells" => cells(&trade.bars),
        _ => return None,
    })
}

fn windows(trade: &Trade) -> String {
    let of_bars = trade.bars.windows;
    let headings =
        "each combination, for each setting|for each accuracy bar|of noise alone, for each length";
    let mut table = Table::new(0, headings);
    table.row(&[trade.windows, of_bars.accuracy, of_bars.noise].map(|count| grouped(count.into())));
    table.end()
}

/// A figure, or a dash where there is none.
pub fn or_dash(figure: Option<String>) -> String {
    figure.unwrap_or_else(|| "-".into())
}

fn percent(row: &Row) -> String {
    or_dash(row.rms_percent().map(|percent| significant(percent, 2)))
}

fn ratio(row: &Row) -> String {
    or_dash(row.accuracy.error.map(|error| over_bound(error.ratio)))
}

/// Latency, passes and instructions.
fn costs(row: &Row) -> [String; 3] {
    let latency = row
        .latency_s()
        .map(|latency_s| format!("{:.2}", 1e3 * latency_s));
    let instructions = row
        .instructions
        .map(|instructions| grouped(instructions.into()));
    [
        or_dash(latency),
        or_dash(instructions),
        or_dash(row.passes().map(|passes| format!("{passes:.1}"))),
    ]
}

/// `count` as a share of `of`, percent.
pub fn share(count: u32, of: u32) -> String {
    match 100.0 * f64::from(count) / f64::from(of) {
        0.0 => "0".into(),
        percent => significant(percent, 2),
    }
}

/// Windows without a single frequency, and those with a multiple or a fraction of the true one,
/// percent of all.
fn failures(row: &Row) -> [String; 2] {
    let Accuracy {
        windows,
        good,
        octaves,
        ..
    } = row.accuracy;
    [share(windows - good, windows), share(octaves, windows)]
}

/// An estimator's error, and how often it fails: under RMS in percent, x bound, no answer and
/// octaves.
fn quality(row: &Row) -> impl Iterator<Item = String> {
    [percent(row), ratio(row)].into_iter().chain(failures(row))
}

/// Ridgetone: one table for each window.
fn ridgetone(trade: &Trade) -> String {
    let of_window = |window_s: f64| {
        let headings = "channels|harmonics|RMS, Hz|RMS, %|x bound|no answer, %|octaves, %|latency, ms|instructions|passes";
        let mut table = Table::new(0, headings);
        for channels in CHANNELS {
            for harmonics in HARMONICS {
                let Some(row) = trade.ridgetone(window_s, harmonics, harmonics, channels) else {
                    continue;
                };
                let rms_hz = or_dash(row.accuracy.error.map(|error| significant(error.rms_hz, 2)));
                let mut cells = vec![channels.to_string(), harmonics.to_string(), rms_hz];
                cells.extend(quality(row));
                cells.extend(costs(row));
                table.row(&cells);
            }
        }
        format!("### {window_s} s\n\n{}", table.end())
    };
    WINDOWS_S.map(of_window).join("\n\n")
}

/// The effect of a setting of other harmonics than there are.
fn harmonics(trade: &Trade) -> String {
    let [fewest, .., most] = HARMONICS;
    let all = TAXELS as u8;
    let headings = "window, s|harmonics there|harmonics set|RMS, %|x bound|no answer, %|octaves, %|instructions|passes";
    let mut table = Table::new(0, headings);
    for window_s in WINDOWS_S {
        let grating = HARMONICS.map(|harmonics| (most, harmonics));
        for (carried, harmonics) in grating
            .into_iter()
            .chain([(fewest, fewest), (fewest, most)])
        {
            let Some(row) = trade.ridgetone(window_s, carried, harmonics, all) else {
                continue;
            };
            let [_, instructions, passes] = costs(row);
            let mut cells = vec![
                window_s.to_string(),
                carried.to_string(),
                harmonics.to_string(),
            ];
            cells.extend(quality(row));
            cells.extend([instructions, passes]);
            table.row(&cells);
        }
    }
    table.end()
}

/// Ridgetone beside the others, in each scene.
fn baselines(trade: &Trade) -> String {
    let of_scene = |carried: u8| {
        let headings = "window, s|method|channels|RMS, %|x bound|no answer, %|octaves, %|latency, ms|instructions|passes";
        let mut table = Table::new(2, headings);
        for window_s in WINDOWS_S {
            let ours = trade.ridgetone(window_s, carried, carried, TAXELS as u8);
            let names = Method::ALL.map(Method::name).into_iter().chain([NLS]);
            let others = names.flat_map(|name| trade.baseline(window_s, carried, name));
            for row in ours.into_iter().chain(others) {
                let name = if row.method == RIDGETONE {
                    format!("**{RIDGETONE}**")
                } else {
                    row.method.clone()
                };
                let mut cells = vec![window_s.to_string(), name, row.channels.to_string()];
                cells.extend(quality(row));
                cells.extend(costs(row));
                table.row(&cells);
            }
        }
        let what = if carried == 1 {
            "The tone alone"
        } else {
            "A grating: the tone and its overtones"
        };
        format!("### {what}\n\n{}", table.end())
    };
    CARRIED.map(of_scene).join("\n\n")
}

/// Noise of each kind: the estimator and its opponent, by window.
pub fn noise(rows: &[noise::Row]) -> String {
    let windows = noise::WINDOWS_S
        .map(|window_s| format!("{window_s} s"))
        .join("|");
    let mut table = Table::new(2, &format!("noise|method|{windows}"));
    for kind in noise::kinds(rows) {
        for (method, by_window) in [
            (format!("**{RIDGETONE}**"), kind.ours),
            (NLS.to_owned(), kind.nls),
        ] {
            let cells = by_window.iter().map(|figures| {
                let ratio = or_dash(figures.over_bound.map(over_bound));
                let alarms = figure(figures.false_alarms_percent, 1);
                format!(
                    "{ratio} / {:.0} / {:.0} / {alarms}",
                    figures.covered_percent, figures.good_percent
                )
            });
            table.row(&[vec![kind.name.clone(), method], cells.collect()].concat());
        }
    }
    table.end()
}

/// Error over bound in every setting of the bar.
fn cells(bars: &Bars) -> String {
    let of_noise = |snr_db: f64| {
        let lengths = LENGTHS.map(|length| length.to_string());
        let mut table = Table::new(0, &format!("mm/s|mm|Hz|{}", lengths.join("|")));
        for line in TABLE_2 {
            let of_line = |setting: &Setting| (setting.speed_mm_s, setting.period_mm) == line;
            let ours = |length| {
                let mut cells = bars.cells.iter();
                let same = |setting: &Setting| {
                    of_line(setting) && (setting.length, setting.snr_db) == (length, snr_db)
                };
                let Some(cell) = cells.find(|cell| same(&cell.setting)) else {
                    return String::new();
                };
                let Some(error) = cell.accuracy.error else {
                    return "-".into();
                };
                let figure = format!("{:.3} \u{b1} {:.3}", error.ratio, error.ratio_sigma);
                if cell.is_above() {
                    format!("**{figure}**")
                } else {
                    figure
                }
            };
            let (speed_mm_s, period_mm) = line;
            let mut row = vec![
                speed_mm_s.to_string(),
                period_mm.to_string(),
                format!("{:.2}", speed_mm_s / period_mm),
            ];
            row.extend(LENGTHS.map(ours));
            table.row(&row);
        }
        format!("### {snr_db} dB\n\n{}", table.end())
    };
    SNRS_DB.map(of_noise).join("\n\n")
}
