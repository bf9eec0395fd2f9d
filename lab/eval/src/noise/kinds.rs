//! The kinds of noise at a glance, for the trade.

use super::Row;
use super::cells::{Group, REAL};
use super::measure::{Answers, percent};

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
/// Power of the tone over that of the noise, decibels.
const SNR_DB: f64 = 20.0;

/// A kind of noise, a column for each length of window.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    pub name: String,
    pub ours: Vec<Figures>,
    pub nls: Vec<Figures>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// RMS of error over the bound of the noise's whole covariance, where there is one.
    pub over_bound: Option<f64>,
    /// Of the good answers, those whose 95 % interval holds the frequency.
    pub covered_percent: f64,
    pub good_percent: f64,
    /// Good answers to windows without a tone.
    pub false_alarms_percent: Option<f64>,
}

/// The kinds that were measured.
pub fn kinds(rows: &[Row]) -> Vec<Kind> {
    let find = |name: &str, group: Group, snr_db: Option<f64>| {
        rows.iter()
            .find(|row| (row.name.as_str(), row.group, row.snr_db) == (name, group, snr_db))
    };
    let figures = |with: &[Answers], without: Option<&Vec<Answers>>| {
        let figures = |(n, answers): (usize, &Answers)| Figures {
            over_bound: answers.over_bound(),
            covered_percent: percent(answers.covered, answers.good),
            good_percent: percent(answers.good, answers.windows),
            false_alarms_percent: without
                .and_then(|all| all.get(n))
                .map(|none| percent(none.good, none.windows)),
        };
        with.iter().enumerate().map(figures).collect()
    };
    let kind = |name: &str| {
        let (with, without) = (
            find(name, Group::Sigma, Some(SNR_DB))?,
            find(name, Group::NoTone, None),
        );
        Some(Kind {
            name: name.to_owned(),
            ours: figures(&with.answers, without.map(|row| &row.answers)),
            nls: figures(&with.nls, without.map(|row| &row.nls)),
        })
    };
    KINDS.into_iter().filter_map(kind).collect()
}
