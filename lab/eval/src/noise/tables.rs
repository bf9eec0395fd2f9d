//! The tables of `docs/results/noise.md`: columns are lengths of window, those of the estimator first, then
//! its opponent's.

use super::Row;
use super::bars::{self, Figure, bars};
use super::cells::{Group, WINDOWS_S, What};
use super::measure::{Answers, percent};
use crate::page::{Table, over_bound};

/// A standard error of more than this share of an error over bound is shown.
const LARGE: f64 = 0.05;
/// The table of what is beyond its bar.
pub const MISSED: &str = "missed";

/// A table by its name: a group's, or one of what else the group's answers say.
pub fn table(rows: &[Row], name: &str) -> Option<String> {
    let (group, what) = match name.rsplit_once('_') {
        Some((group, "status")) => (group, What::Status),
        Some((group, "intervals")) => (group, What::Intervals),
        _ => (name, What::Main),
    };
    let group = Group::ALL
        .into_iter()
        .find(|candidate| candidate.name() == group)?;
    Some(of_group(group, what, rows))
}

/// Every bar, and the figures beyond it; how many of another seed are.
pub fn missed(rows: &[Row], other_seed: &[Row]) -> String {
    bars::missed(
        &all(rows).collect::<Vec<_>>(),
        &all(other_seed).collect::<Vec<_>>(),
    )
}

/// The names of all tables of a group.
pub fn names(group: Group) -> Vec<String> {
    let intervals = (group == Group::Unsteady).then_some("_intervals");
    let others = ["", "_status"].into_iter().chain(intervals);
    others
        .map(|other| format!("{}{other}", group.name()))
        .collect()
}

/// Every figure of the estimator, and where it stands.
fn all(rows: &[Row]) -> impl Iterator<Item = (String, Figure)> + '_ {
    let of = |(row, what): (&Row, What)| {
        let columns = WINDOWS_S
            .map(|s| format!("{}, {s} s", row.title()))
            .into_iter()
            .zip(own(row, what));
        columns
            .flat_map(|(place, figures)| {
                figures
                    .into_iter()
                    .map(move |figure| (place.clone(), figure))
            })
            .collect::<Vec<_>>()
    };
    let groups = Group::ALL
        .into_iter()
        .flat_map(move |group| rows.iter().filter(move |row| row.group == group));
    groups
        .flat_map(|row| [What::Main, What::Status, What::Intervals].map(|what| (row, what)))
        .flat_map(of)
}

fn of_group(group: Group, what: What, rows: &[Row]) -> String {
    let with_opponent = what == What::Main;
    let opponent = WINDOWS_S.map(|s| format!("NLS, {s} s"));
    let headings = WINDOWS_S
        .map(|s| format!("{s} s"))
        .into_iter()
        .chain(opponent.into_iter().filter(|_| with_opponent));
    let mut table = Table::new(1, &format!("|{}", headings.collect::<Vec<_>>().join("|")));
    let cell = |figures: Vec<Figure>| {
        figures
            .iter()
            .map(Figure::marked)
            .collect::<Vec<_>>()
            .join(" / ")
    };
    for row in rows.iter().filter(|row| row.group == group) {
        // Data of before the opponent have none. Nothing is required of it.
        let opponent = (0..WINDOWS_S.len()).map(|n| {
            row.nls
                .get(n)
                .map_or_else(|| "-".into(), |answers| cell(figures(row, what, answers)))
        });
        let cells = own(row, what)
            .into_iter()
            .map(cell)
            .chain(opponent.filter(|_| with_opponent));
        table.row(&[vec![row.title()], cells.collect()].concat());
    }
    table.end()
}

/// The estimator's figures in each column, with their bars.
fn own(row: &Row, what: What) -> Vec<Vec<Figure>> {
    let cell = row.cell();
    let of = |(window_s, answers): (f64, &Answers)| {
        let bars = cell.map_or([None; 4], |cell| {
            bars(&cell, what, window_s == WINDOWS_S[0])
        });
        figures(row, what, answers)
            .into_iter()
            .zip(bars)
            .map(|(figure, bar)| Figure { bar, ..figure })
            .collect()
    };
    WINDOWS_S.into_iter().zip(&row.answers).map(of).collect()
}

fn figures(row: &Row, what: What, answers: &Answers) -> Vec<Figure> {
    match what {
        What::Main => main(row.group, answers),
        What::Status => status(row.group, answers),
        What::Intervals => intervals(answers),
    }
}

/// The figures that a group is judged by.
fn main(group: Group, answers: &Answers) -> Vec<Figure> {
    let share = |count: u32, of: u32, decimals: usize| {
        Figure::new((of > 0).then(|| percent(count, of)), decimals)
    };
    let good = |decimals| share(answers.good, answers.windows, decimals);
    let of_good = |count: u32, decimals| share(count, answers.good, decimals);
    match group {
        Group::NoTone => vec![good(1)],
        Group::Something => vec![good(1), of_good(answers.wrong, 1)],
        Group::FewCycles => vec![good(1), share(answers.wrong, answers.windows, 1)],
        Group::Sigma => {
            vec![
                of_good(answers.covered, 1),
                Figure::new(answers.error_in_sigmas(), 2),
                times_bound(answers),
            ]
        }
        Group::Accuracy => {
            let octaves = answers.accuracy.map_or(0, |accuracy| accuracy.octaves);
            let not_good = share(answers.windows - answers.good, answers.windows, 1);
            vec![
                times_bound(answers),
                Figure::new(Some(octaves.into()), 0),
                not_good,
                Figure::new(answers.sigma_over_bound, 2),
            ]
        }
        Group::Unsteady => vec![
            good(1),
            of_good(answers.covered, 0),
            of_good(answers.covered_weighted, 0),
        ],
    }
}

/// Error over bound, with its standard error where that is large.
fn times_bound(answers: &Answers) -> Figure {
    let Some(error) = answers.accuracy.and_then(|accuracy| accuracy.error) else {
        return Figure::new(None, 2);
    };
    let sigma = (error.ratio_sigma > LARGE * error.ratio)
        .then(|| format!(" \u{b1} {:.2}", error.ratio_sigma));
    Figure {
        text: over_bound(error.ratio) + &sigma.unwrap_or_default(),
        value: Some(error.ratio),
        bar: None,
    }
}

/// What those are that are not good.
fn status(group: Group, answers: &Answers) -> Vec<Figure> {
    let share = |count: u32| Figure::new(Some(percent(count, answers.windows)), 0);
    let both = vec![share(answers.unsteady), share(answers.ambiguous)];
    let two = vec![
        share(answers.second),
        Figure::new(
            answers.unnamed.map(|count| percent(count, answers.windows)),
            1,
        ),
    ];
    if group == Group::Something {
        [both, two].concat()
    } else {
        both
    }
}

fn intervals(answers: &Answers) -> Vec<Figure> {
    let moves = answers.movement;
    let share = |count: u32, of: u32| Figure::new((of > 0).then(|| percent(count, of)), 0);
    let [weighted, mean, wander] =
        [moves.weighted, moves.mean, moves.wander].map(|count| share(count, moves.answers));
    vec![weighted, mean, wander, share(moves.chirp, moves.lines)]
}
