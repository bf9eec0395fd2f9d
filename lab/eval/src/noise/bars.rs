//! What is required of the figures of a cell. A figure beyond its bar is bold on the page, and all
//! of them are listed.

use super::cells::{Cell, Group, What};
use super::parts::Extra;
use super::process::Noise;
use crate::page::{Table, figure};

/// What a figure is, and the least and the most that it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar(&'static str, f64, f64);

/// A figure of a table, and its bar if it has one.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub text: String,
    pub value: Option<f64>,
    pub bar: Option<Bar>,
}

impl Figure {
    /// With `decimals` decimals, or a dash.
    pub fn new(value: Option<f64>, decimals: usize) -> Self {
        Self {
            text: figure(value, decimals),
            value,
            bar: None,
        }
    }

    /// The value counts as it is before it is rounded.
    fn is_beyond(&self) -> bool {
        self.value
            .zip(self.bar)
            .is_some_and(|(value, Bar(_, least, most))| !(least..=most).contains(&value))
    }

    pub fn marked(&self) -> String {
        if self.is_beyond() {
            format!("**{}**", self.text)
        } else {
            self.text.clone()
        }
    }
}

/// The bars of the figures of a cell, in their order, in a window of the shortest length or of
/// another.
pub fn bars(cell: &Cell, what: What, is_shortest: bool) -> [Option<Bar>; 4] {
    let at_most = |what: &'static str, most: f64| Some(Bar(what, 0.0, most));
    let (extra, noise) = (cell.recipe.extra, cell.recipe.noise);
    let (cycles, snr_db, harmonics) = cell
        .recipe
        .tone
        .map_or_else(Default::default, |t| (t.cycles.0, t.snr_db, t.harmonics));
    let is_clean = extra == Extra::Nothing;
    // Intervals of few frames: their noise is less certain.
    let least = if is_shortest { 90.0 } else { 92.0 };
    let holds = |what| Some(Bar(what, least, 100.0));
    let bound = match noise {
        Noise::White if cycles < 1.5 => at_most("white noise, 1 to 1.5 cycles: x bound", 1.1),
        Noise::White => at_most("white noise, from 1.5 cycles on: x bound", 1.05),
        Noise::Impulses => at_most("impulses: x bound", 1.15),
        Noise::SharedPink | Noise::SharedPhases => at_most("shared noise: x bound", 1.3),
        _ => None,
    };
    match (cell.group, what) {
        (Group::NoTone, What::Main) => {
            let good = match extra {
                Extra::Relaxations(1, _) => at_most("no tone, one relaxation: good, %", 0.0),
                Extra::Relaxations(..)
                | Extra::LogCreep(_)
                | Extra::Step(_)
                | Extra::Bump(_)
                | Extra::Spike(_) => at_most("no tone, other drifts: good, %", 1.0),
                _ if is_shortest || noise == Noise::NarrowBand => {
                    at_most("no tone, 0.2 s or narrow band: good, %", 10.0)
                }
                _ => at_most("no tone: good, %", 3.0),
            };
            [good, None, None, None]
        }
        // A multiple of a fundamental that stands out is never to be good.
        (Group::Something, What::Main) if harmonics[0] < harmonics[1] => [
            None,
            at_most("a faint fundamental: wrong of the good, %", 0.0),
            None,
            None,
        ],
        (Group::Something, What::Main) => [
            None,
            at_most("something else: wrong of the good, %", 2.0),
            None,
            None,
        ],
        (Group::Something, What::Status) => [
            None,
            None,
            None,
            at_most("two tones: neither both named nor ambiguous, %", 0.0),
        ],
        (Group::Sigma, What::Main) => {
            let bound = bound.filter(|_| is_clean);
            [
                Some(Bar("intervals that hold, %", least, 98.0)),
                Some(Bar("RMS of the error over sigma", 0.85, 1.2)),
                bound,
                None,
            ]
        }
        (Group::Accuracy, What::Main) => {
            let not_good = if snr_db < 20.0 {
                at_most("clean, from 1.5 cycles on, 10 dB: not good, %", 1.0)
            } else {
                at_most("clean, from 1.5 cycles on, 20 dB: not good, %", 0.5)
            };
            // For the bound a drift's size is unknown, though an answer may need none.
            let sigma = at_most("white noise: sigma, x bound", 1.03).filter(|_| is_clean);
            [
                bound,
                at_most("octave errors", 0.0),
                not_good.filter(|_| is_clean && cycles >= 1.5),
                sigma,
            ]
        }
        (Group::FewCycles, What::Main) => {
            let good = at_most("below 0.7 cycles: good, %", 0.0).filter(|_| cycles < 0.7);
            [
                good,
                at_most("below one cycle: good and wrong, %", 1.0).filter(|_| cycles < 1.0),
                None,
                None,
            ]
        }
        (Group::Unsteady, What::Main) => [
            None,
            None,
            holds("not steady: weighted mean, by good answers, %"),
            None,
        ],
        (Group::Unsteady, What::Intervals) => [
            holds("not steady: weighted mean, %"),
            holds("not steady: mean, %"),
            holds("not steady: wander, %"),
            holds("not steady: chirp, %"),
        ],
        _ => [None; 4],
    }
}

/// How many figures are beyond each bar, of how many, of another seed, and where.
pub fn missed(figures: &[(String, Figure)], other_seed: &[(String, Figure)]) -> String {
    let judged = |(_, figure): &&(String, Figure)| figure.value.is_some() && figure.bar.is_some();
    let mut all: Vec<Bar> = Vec::new();
    for bar in figures
        .iter()
        .filter(judged)
        .filter_map(|(_, figure)| figure.bar)
    {
        if !all.contains(&bar) {
            all.push(bar);
        }
    }
    let mut table = Table::new(2, "figure|bar|beyond it|of|other seed|where");
    for bar in all {
        let of = |figures: &[(String, Figure)]| {
            let of_bar = figures
                .iter()
                .filter(judged)
                .filter(|(_, figure)| figure.bar == Some(bar));
            let places = of_bar.clone().filter(|(_, figure)| figure.is_beyond());
            (
                places
                    .map(|(place, figure)| format!("{place}: {}", figure.text))
                    .collect::<Vec<_>>(),
                of_bar.count(),
            )
        };
        let ((beyond, count), (others, of_others)) = (of(figures), of(other_seed));
        let other = if of_others == 0 {
            "-".into()
        } else {
            format!("{} of {of_others}", others.len())
        };
        let Bar(what, least, most) = bar;
        let limit = match (least > 0.0, most) {
            (false, _) => format!("at most {most}"),
            (true, 100.0) => format!("at least {least}"),
            _ => format!("{least} to {most}"),
        };
        table.row(&[
            what.into(),
            limit,
            beyond.len().to_string(),
            count.to_string(),
            other,
            beyond.join("; "),
        ]);
    }
    table.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_bar_is_bold_and_is_listed() {
        let bar = Some(Bar("intervals", 92.0, 98.0));
        let figures = [91.96, 92.0, 98.0, 98.04].map(|value| Figure {
            bar,
            ..Figure::new(Some(value), 1)
        });
        assert_eq!(
            figures.each_ref().map(Figure::marked),
            ["**92.0**", "92.0", "98.0", "**98.0**"]
        );
        let none = [
            Figure {
                bar,
                ..Figure::new(None, 1)
            },
            Figure::new(Some(5.0), 0),
        ];
        assert_eq!(none.each_ref().map(Figure::marked), ["-", "5"]);
        let placed: Vec<_> = figures
            .into_iter()
            .chain(none)
            .map(|figure| ("here".to_owned(), figure))
            .collect();
        let table = missed(&placed, &placed[3..]);
        assert!(
            table.ends_with("| intervals | 92 to 98 | 2 | 4 | 1 of 1 | here: 92.0; here: 98.0 |"),
            "{table}"
        );
    }
}
