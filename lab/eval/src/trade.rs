//! The cost and the accuracy of each choice: accuracy on this PC, with the code of the chip, beside
//! instructions that were counted before; for docs/results/trade.md.

pub mod contender;
pub mod converters;
pub mod grid;
pub mod plans;
pub mod results;
pub mod scenes;
pub mod setups;
mod units;

use crate::baselines::Method;
use crate::page::{self, Figures, Table, Tables, figure, fixed, percent};
use anyhow::Result;
use grid::{HARMONICS, WINDOWS_S};
use results::{NLS, RIDGETONE, Row, Trade};
use ridgetone_host::chart::{Curve, Look, Panel, Scale, chart};
use ridgetone_host::output::whole_text;
use ridgetone_proto::settings::TAXELS;
use serde_json::Value;
use std::path::Path;

/// Windows of each line of Table 2 for a row: for the page, and for a look.
pub const FULL: u32 = 100;
pub const QUICK: u32 = 10;

pub const TOPIC: &str = "trade";

/// Measures accuracy here. Instructions, plans and converters are those of `before`.
pub fn measure(windows: u32, before: Trade) -> Result<Trade> {
    let mut rows = grid::measure(windows)?;
    for row in &mut rows {
        let same = before.rows.iter().find(|one| one.key() == row.key());
        row.instructions = same.and_then(|one| one.instructions);
    }
    Ok(Trade {
        windows,
        rows,
        ..before
    })
}

pub fn figures(trade: Trade) -> Figures<Trade> {
    let tables = Tables::from([
        ("windows".into(), windows(&trade)),
        ("choices".into(), choices(&trade.rows)),
        ("methods".into(), methods(&trade)),
        ("plans".into(), plans::table(&trade.plans)),
        ("converters".into(), converters::table(&trade.converters)),
        (
            "bars".into(),
            page::bars(trade.chip.iter().chain(&plans::bars(&trade.plans))),
        ),
    ]);
    Figures {
        tables,
        detail: trade,
    }
}

/// Writes the figures, the page and its picture.
pub fn write(trade: Trade, folder: &Path) -> Result<()> {
    let figures = figures(trade);
    page::write(folder, TOPIC, &figures)?;
    whole_text(&folder.join("trade.svg"), &picture(&figures.detail))
}

/// What was measured last in a folder; nothing where nothing was.
pub fn load(folder: &Path) -> Result<Trade> {
    page::load(folder, TOPIC).map(|figures| figures.detail)
}

fn error(row: &Row, of: fn(&crate::accuracy::Error) -> f64) -> Option<f64> {
    row.accuracy.error.as_ref().map(of)
}

fn latency_ms(row: &Row) -> Value {
    fixed(row.latency_s().map(|latency_s| 1e3 * latency_s), 1)
}

/// The default choice by length of window, in a scene with four harmonics.
fn windows(trade: &Trade) -> Table {
    let mut table = Table::new(
        "window, s|RMS, %|RMS over bound|no answer, %|latency, ms|instructions|\
         one harmonic: RMS, %|instructions|four channels: RMS, %|instructions",
    );
    for window_s in WINDOWS_S {
        let of = |harmonics, channels| trade.ridgetone(window_s, 4, harmonics, channels);
        let Some(row) = of(4, TAXELS as u8) else {
            continue;
        };
        let mut cells = vec![
            Value::from(window_s),
            figure(row.rms_percent(), 2),
            fixed(error(row, |error| error.ratio), 2),
            percent(
                row.accuracy.windows - row.accuracy.good,
                row.accuracy.windows,
            ),
            latency_ms(row),
            row.instructions.into(),
        ];
        for other in [of(1, TAXELS as u8), of(4, 4)] {
            cells.push(figure(other.and_then(Row::rms_percent), 2));
            cells.push(other.and_then(|row| row.instructions).into());
        }
        table.row(cells);
    }
    table
}

/// Every choice and every other method.
fn choices(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "method|window, s|harmonics there|set|channels|RMS, Hz|RMS, %|RMS over bound|+-|no answer, %|octaves, %|\
         latency, ms|instructions|passes",
    );
    for row in rows {
        table.row([
            Value::from(row.method.as_str()),
            row.window_s.into(),
            row.carried.into(),
            row.harmonics.into(),
            row.channels.into(),
            figure(error(row, |error| error.rms_hz), 3),
            figure(row.rms_percent(), 3),
            fixed(error(row, |error| error.ratio), 3),
            fixed(error(row, |error| error.ratio_sigma), 3),
            percent(
                row.accuracy.windows - row.accuracy.good,
                row.accuracy.windows,
            ),
            percent(row.accuracy.octaves, row.accuracy.windows),
            latency_ms(row),
            row.instructions.into(),
            fixed(row.passes(), 1),
        ]);
    }
    table
}

/// The methods by name, with their rows in scenes of `carried` harmonics.
fn by_method(trade: &Trade, carried: u8) -> Vec<(String, Vec<&Row>)> {
    let [one, .., four] = HARMONICS;
    let ours = |harmonics: u8| {
        let rows = WINDOWS_S.into_iter();
        rows.filter_map(|s| trade.ridgetone(s, carried, harmonics, TAXELS as u8))
            .collect()
    };
    let other = |name: &str| {
        let rows = WINDOWS_S
            .into_iter()
            .flat_map(|s| trade.baseline(s, carried, name));
        (name.to_owned(), rows.collect())
    };
    let mut all = vec![(format!("{RIDGETONE}, four harmonics"), ours(four))];
    if carried == four {
        all.push((format!("{RIDGETONE}, one harmonic"), ours(one)));
    }
    all.push(other(NLS));
    all.extend(Method::ALL.map(|method| other(method.name())));
    all
}

/// RMS errors of the methods by window, of a tone alone and of one with three overtones.
fn methods(trade: &Trade) -> Table {
    const SHOWN_S: [f64; 4] = [0.2, 0.4, 1.0, 3.9];
    let windows = SHOWN_S.map(|s| format!("RMS at {s} s, %")).join("|");
    let mut table = Table::new(&format!("scene|method|{windows}|instructions at 1 s"));
    for (scene, carried) in [("tone alone", 1), ("three overtones", 4)] {
        for (name, rows) in by_method(trade, carried) {
            let at = |s: f64| rows.iter().find(|row| row.window_s == s);
            let errors = SHOWN_S.map(|s| figure(at(s).and_then(|row| row.rms_percent()), 2));
            let instructions = at(1.0).and_then(|row| row.instructions);
            table.row(
                [Value::from(scene), name.into()]
                    .into_iter()
                    .chain(errors)
                    .chain([instructions.into()]),
            );
        }
    }
    table
}

/// Error and instructions of each method by length of window.
pub fn picture(trade: &Trade) -> String {
    let [.., four] = HARMONICS;
    let methods = by_method(trade, four);
    let curves = |value: &dyn Fn(&Row) -> Option<f64>| -> Vec<Curve> {
        let curve = |(number, (name, rows)): (usize, &(String, Vec<&Row>))| Curve {
            name: name.clone(),
            look: Look::Marked(number),
            points: rows
                .iter()
                .filter_map(|row| Some((row.window_s, value(row)?)))
                .collect(),
        };
        let all = methods.iter().enumerate().map(curve);
        all.filter(|curve| !curve.points.is_empty()).collect()
    };
    let names: Vec<(f64, String)> = WINDOWS_S.map(|s| (s, format!("{s} s"))).to_vec();
    let x = Scale {
        is_log: true,
        range: Some((0.18, 4.3)),
        names,
        ..Scale::default()
    };
    let y = |label: &str| Scale {
        label: label.into(),
        is_log: true,
        ..Scale::default()
    };
    let mut errors = curves(&Row::rms_percent);
    let bounds = WINDOWS_S.into_iter().filter_map(|s| {
        let row = trade.ridgetone(s, four, four, TAXELS as u8)?;
        Some((s, row.accuracy.error?.bound_percent))
    });
    errors.push(Curve {
        name: "the bound".into(),
        look: Look::Reference,
        points: bounds.collect(),
    });
    let title = |what: &str| {
        format!("{what} by length of window; three overtones, noise 20 dB below the tone")
    };
    let panels = [
        Panel {
            title: title("RMS error"),
            x: x.clone(),
            y: y("percent of the frequency"),
            curves: errors,
        },
        Panel {
            title: "Instructions of the costliest window on the Cortex-M4F".into(),
            x,
            y: y("instructions"),
            curves: curves(&|row| row.instructions.map(f64::from)),
        },
    ];
    chart("Error and cost of each method by length of window", &panels)
}
