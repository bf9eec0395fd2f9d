//! The kinds of noise at a glance: the estimator beside its opponent.

use super::Row;
use super::cells::{Group, REAL, WINDOWS_S};
use super::measure::Answers;
use crate::page::{Table, fixed, percent};
use ridgetone_host::chart::{Curve, Look, Panel, Scale, chart};
use serde_json::Value;

/// Names of the cells, with a tone and without one.
const KINDS: [&str; 7] = [
    "white",
    "impulses: 1 % of 20 sigma",
    "pink",
    "AR(1) of 0.9",
    "pink, the same in all channels",
    "pink, shared with random phases",
    REAL,
];
/// Those that are drawn.
const DRAWN: [&str; 3] = ["white", "pink", "pink, the same in all channels"];
/// Power of the tone over that of the noise, decibels.
const SNR_DB: f64 = 20.0;

fn find<'r>(rows: &'r [Row], name: &str, group: Group, snr_db: Option<f64>) -> Option<&'r Row> {
    rows.iter()
        .find(|row| (row.name.as_str(), row.group, row.snr_db) == (name, group, snr_db))
}

/// A row for each kind of noise and length of window.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "noise|window, s|RMS over bound|intervals that hold, %|good, %|good without a tone, %|\
         NLS: RMS over bound|intervals that hold, %|good, %|good without a tone, %",
    );
    for kind in KINDS {
        let Some(with) = find(rows, kind, Group::Sigma, Some(SNR_DB)) else {
            continue;
        };
        let without = find(rows, kind, Group::NoTone, None);
        for (n, window_s) in WINDOWS_S.into_iter().enumerate() {
            let figures = |with: &[Answers], without: Option<&Vec<Answers>>| -> [Value; 4] {
                let (Some(with), without) = (with.get(n), without.and_then(|all| all.get(n)))
                else {
                    return [Value::Null, Value::Null, Value::Null, Value::Null];
                };
                [
                    fixed(with.over_bound(), 2),
                    percent(with.covered, with.good),
                    percent(with.good, with.windows),
                    without.map_or(Value::Null, |none| percent(none.good, none.windows)),
                ]
            };
            let ours = figures(&with.answers, without.map(|row| &row.answers));
            let nls = figures(&with.nls, without.map(|row| &row.nls));
            let names = [Value::from(kind), window_s.into()];
            table.row(names.into_iter().chain(ours).chain(nls));
        }
    }
    table
}

/// Error over bound by length of window.
pub fn picture(rows: &[Row]) -> String {
    let mut curves = Vec::new();
    for (number, kind) in DRAWN.into_iter().enumerate() {
        let Some(row) = find(rows, kind, Group::Sigma, Some(SNR_DB)) else {
            continue;
        };
        for (who, look, answers) in [
            ("Ridgetone", number, &row.answers),
            ("NLS", number + 4, &row.nls),
        ] {
            let points = WINDOWS_S.into_iter().zip(answers);
            curves.push(Curve {
                name: format!("{who}: {kind}"),
                look: Look::Marked(look),
                points: points
                    .filter_map(|(s, answers)| Some((s, answers.over_bound()?)))
                    .collect(),
            });
        }
    }
    let bound = vec![(WINDOWS_S[0], 1.0), (WINDOWS_S[WINDOWS_S.len() - 1], 1.0)];
    curves.push(Curve {
        name: "the bound".into(),
        look: Look::Reference,
        points: bound,
    });
    let panel = Panel {
        title: "RMS error over the bound of the noise's whole covariance, by length of window"
            .into(),
        x: Scale {
            is_log: true,
            range: Some((0.18, 4.3)),
            names: WINDOWS_S.map(|s| (s, format!("{s} s"))).to_vec(),
            ..Scale::default()
        },
        y: Scale {
            label: "RMS error over bound".into(),
            is_log: true,
            ..Scale::default()
        },
        curves,
    };
    chart("Error over bound in noise of three kinds", &[panel])
}
