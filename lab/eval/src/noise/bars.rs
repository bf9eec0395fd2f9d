//! What is required of the answers to a cell's windows.

use super::Row;
use super::cells::{Cell, Group, WINDOWS_S};
use super::measure::Answers;
use super::parts::Extra;
use super::process::Noise;
use crate::page::{Table, fixed};
use serde_json::Value;

/// A figure, and the least and the most that it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    what: &'static str,
    least: f64,
    most: f64,
    value: f64,
}

impl Judged {
    /// The value counts as it is before it is rounded.
    fn is_beyond(&self) -> bool {
        !(self.least..=self.most).contains(&self.value)
    }

    /// By how much of the bar's size it is beyond it.
    fn excess(&self) -> f64 {
        (self.least - self.value).max(self.value - self.most) / self.most.max(1.0)
    }
}

/// The figures of a cell that something is required of, in windows of `window_s` seconds.
fn judge(cell: &Cell, answers: &Answers, window_s: f64) -> Vec<Judged> {
    let (extra, noise) = (cell.recipe.extra, cell.recipe.noise);
    let (cycles, snr_db, harmonics) = cell
        .recipe
        .tone
        .map_or_else(Default::default, |t| (t.cycles.0, t.snr_db, t.harmonics));
    let is_clean = extra == Extra::Nothing;
    let is_shortest = window_s == WINDOWS_S[0];
    // Intervals of few frames: their noise is less certain.
    let least = if is_shortest { 90.0 } else { 92.0 };
    let mut all = Vec::new();
    let mut require = |what, least: f64, most: f64, value: Option<f64>| {
        all.extend(value.map(|value| Judged {
            what,
            least,
            most,
            value,
        }));
    };
    let share = |count: u32, of: u32| (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of));
    let good = share(answers.good, answers.windows);
    let wrong = share(answers.wrong, answers.windows);
    let right = share(answers.good - answers.wrong, answers.windows);
    match cell.group {
        Group::NoTone => require("no tone: good, %", 0.0, 1.0, good),
        Group::Something => {
            let unnamed = answers
                .unnamed
                .and_then(|count| share(count, answers.windows));
            let has_comb = harmonics[0] < harmonics.iter().copied().fold(0.0, f64::max);
            if unnamed.is_some() {
                let what = "two tones: good or unsteady without the second named, %";
                require(what, 0.0, 1.0, unnamed);
            } else if !has_comb {
                require("beside something else: good and wrong, %", 0.0, 1.0, wrong);
            } else if !is_shortest {
                let what = "combs of which the first is faint, from 0.4 s: good and wrong, %";
                require(what, 0.0, 1.0, wrong);
            }
            if matches!(extra, Extra::Step(_)) && window_s == 1.0 {
                let what = "a step of 3 amplitudes, 1 s: good and right, %";
                require(what, 90.0, 100.0, right);
            }
        }
        Group::Sigma => {
            let covered = share(answers.covered, answers.good);
            require("intervals that hold, %", least, 98.0, covered);
            if is_clean && snr_db >= 20.0 && noise != Noise::White && !is_shortest {
                let (what, least) = if window_s < 1.0 {
                    ("any noise, 20 dB, 0.4 s: good, %", 75.0)
                } else {
                    ("any noise, 20 dB, from 1 s: good, %", 90.0)
                };
                require(what, least, 100.0, good);
            }
        }
        Group::Accuracy => {
            let octaves = answers.accuracy.map_or(0, |accuracy| accuracy.octaves);
            require("octave errors", 0.0, 0.0, Some(octaves.into()));
            if cycles >= 1.5 && is_clean {
                let what = "white, from 1.5 cycles on: RMS over bound";
                require(what, 0.0, 1.05, answers.over_bound());
                let what = "white, from 1.5 cycles on: sigma over bound";
                require(what, 0.0, 1.03, answers.sigma_over_bound);
                if snr_db >= 20.0 {
                    let what = "white, from 1.5 cycles on, 20 dB: good, %";
                    require(what, 99.5, 100.0, good);
                }
            }
        }
        Group::FewCycles => {
            if cycles < 1.0 {
                require("below one cycle: good and wrong, %", 0.0, 0.0, wrong);
            }
        }
        Group::Unsteady => {
            let moves = answers.movement;
            let mut holds = |what, value| require(what, least, 100.0, value);
            holds("not steady: mean, %", share(moves.mean, moves.answers));
            holds("not steady: wander, %", share(moves.wander, moves.answers));
            holds("not steady: chirp, %", share(moves.chirp, moves.lines));
        }
    }
    all
}

/// Every bar: how many figures are beyond it, of how many, the worst of them, and all of them.
pub fn table(rows: &[Row]) -> Table {
    let of_row = |row: &Row| {
        let cell = row.cell();
        let columns = WINDOWS_S.into_iter().zip(row.answers.clone());
        let title = row.title();
        columns.flat_map(move |(window_s, answers)| {
            let all = cell.map_or_else(Vec::new, |cell| judge(&cell, &answers, window_s));
            let place = format!("{title}, {window_s} s");
            all.into_iter()
                .map(move |judged| (place.clone(), judged))
                .collect::<Vec<_>>()
        })
    };
    list(&rows.iter().flat_map(of_row).collect::<Vec<_>>())
}

fn list(figures: &[(String, Judged)]) -> Table {
    let mut bars: Vec<Judged> = Vec::new();
    let is_same = |a: &Judged, b: &Judged| (a.what, a.least, a.most) == (b.what, b.least, b.most);
    for (_, judged) in figures {
        if !bars.iter().any(|bar| is_same(bar, judged)) {
            bars.push(*judged);
        }
    }
    let mut table = Table::new("what must hold|bar|beyond it|of|worst||all that are beyond it");
    for bar in bars {
        let of_bar: Vec<_> = figures
            .iter()
            .filter(|(_, judged)| is_same(judged, &bar))
            .collect();
        let mut beyond: Vec<_> = of_bar
            .iter()
            .filter(|(_, judged)| judged.is_beyond())
            .collect();
        beyond.sort_by(|a, b| b.1.excess().total_cmp(&a.1.excess()));
        let texts: Vec<String> = beyond
            .iter()
            .map(|(place, judged)| format!("{place}: {}", fixed(judged.value, 2)))
            .collect();
        let limit = match (bar.least > 0.0, bar.most) {
            (false, most) => format!("at most {most}"),
            (true, 100.0) => format!("at least {}", bar.least),
            (true, most) => format!("{} to {most}", bar.least),
        };
        table.row([
            Value::from(bar.what),
            limit.into(),
            beyond.len().into(),
            of_bar.len().into(),
            texts.first().cloned().unwrap_or_default().into(),
            texts.is_empty().into(),
            texts.join("; ").into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_bar_is_counted_and_named() {
        let figures = [91.96, 92.0, 98.0, 98.04].map(|value| {
            let judged = Judged {
                what: "intervals",
                least: 92.0,
                most: 98.0,
                value,
            };
            (format!("of {value}"), judged)
        });
        let table = list(&figures);
        let [row] = &table.rows[..] else {
            panic!("{table:?}")
        };
        let texts = ["intervals", "92 to 98"].map(Value::from);
        assert_eq!(row[..2], texts);
        assert_eq!(
            row[2..6],
            [
                Value::from(2),
                Value::from(4),
                Value::from("of 91.96: 91.96"),
                Value::from(false)
            ]
        );
        assert_eq!(row[6], "of 91.96: 91.96; of 98.04: 98.04");
        assert_eq!(list(&figures[1..3]).rows[0][5], true);
    }
}
