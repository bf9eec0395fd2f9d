//! The tables of `docs/noise.md`: columns are lengths of window, those of the estimator first, then its opponent's.

use super::Row;
use super::cells::{Group, WINDOWS_S};
use super::measure::{Answers, percent};
use crate::page::{Table, figure, over_bound};

/// A table by its name: a group's, or one of what else the group's answers say.
pub fn table(rows: &[Row], name: &str) -> Option<String> {
    let (group, what) = match name.rsplit_once('_') {
        Some((group, "status")) => (group, What::Status),
        Some((group, "intervals")) => (group, What::Intervals),
        _ => (name, What::Main),
    };
    let group = Group::ALL.into_iter().find(|candidate| candidate.name() == group)?;
    Some(of_group(group, what, rows))
}

/// The names of all tables of a group.
pub fn names(group: Group) -> Vec<String> {
    let intervals = (group == Group::Unsteady).then_some("_intervals");
    let others = ["", "_status"].into_iter().chain(intervals);
    others.map(|other| format!("{}{other}", group.name())).collect()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Main,
    Status,
    Intervals,
}

fn of_group(group: Group, what: What, rows: &[Row]) -> String {
    let with_opponent = what == What::Main;
    let opponent = WINDOWS_S.map(|s| format!("NLS, {s} s"));
    let headings = WINDOWS_S.map(|s| format!("{s} s")).into_iter().chain(opponent.into_iter().filter(|_| with_opponent));
    let mut table = Table::new(1, &format!("|{}", headings.collect::<Vec<_>>().join("|")));
    for row in rows.iter().filter(|row| row.group == group) {
        let cell = |answers: &Answers| match what {
            What::Main => main(group, answers),
            What::Status => status(group, answers),
            What::Intervals => intervals(answers),
        };
        let own = row.answers.iter().map(cell);
        // Data of before the opponent have none.
        let opponent = (0..WINDOWS_S.len()).map(|n| row.nls.get(n).map_or_else(|| "-".into(), cell));
        let cells = own.chain(opponent.filter(|_| with_opponent));
        table.row(&[vec![row.title()], cells.collect()].concat());
    }
    table.end()
}

/// The figures that a group is judged by.
fn main(group: Group, answers: &Answers) -> String {
    let good = percent(answers.good, answers.windows);
    let covered = percent(answers.covered, answers.good);
    match group {
        Group::NoTone => format!("{good:.1}"),
        Group::Something | Group::FewCycles => format!("{good:.0} / {:.1}", percent(answers.wrong, answers.good)),
        Group::Sigma => {
            format!("{covered:.1} / {} / {}", figure(answers.error_in_sigmas(), 2), times_bound(answers))
        }
        Group::Accuracy => {
            let octaves = answers.accuracy.map_or(0, |accuracy| accuracy.octaves);
            format!("{} / {octaves} / {:.1}", times_bound(answers), 100.0 - good)
        }
        Group::Unsteady => format!("{good:.0} / {covered:.0} / {:.0}", percent(answers.covered_weighted, answers.good)),
    }
}

/// Error over bound, or a dash.
fn times_bound(answers: &Answers) -> String {
    answers.over_bound().map_or_else(|| "-".into(), over_bound)
}

/// What those are that are not good.
fn status(group: Group, answers: &Answers) -> String {
    let share = |count: u32| percent(count, answers.windows);
    let both = format!("{:.0} / {:.0}", share(answers.unsteady), share(answers.ambiguous));
    if group == Group::Something { format!("{both} / {:.0}", share(answers.second)) } else { both }
}

fn intervals(answers: &Answers) -> String {
    let moves = answers.movement;
    let share = |count: u32, of: u32| figure((of > 0).then(|| percent(count, of)), 0);
    let [weighted, mean, wander] = [moves.weighted, moves.mean, moves.wander].map(|count| share(count, moves.answers));
    [weighted, mean, wander, share(moves.chirp, moves.lines)].join(" / ")
}
