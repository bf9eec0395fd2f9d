//! What a finger feels: a bar for each kind of receptor, the scales of soft and rough, and the
//! spectrum under the thresholds.

use super::strips::bar;
use super::style::{alarm, boxed};
use super::view::View;
use crate::digits::{significant, uncertain};
use crate::feel::event::{Reading, levels, ratings, receptors};
use crate::feel::threshold::{Threshold, thresholds};
use crate::live::Live;
use crate::names::name;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph, Wrap};
use ridgetone_proto::settings::Feeling;
use ridgetone_proto::telemetry::{Feel, Measured};

/// Columns of a name, and of a value with its uncertainty.
const NAME: usize = 6;
const VALUE: usize = 16;

/// Rows of the values, and the fewest below them in which a plot can be read: its title, its axis,
/// and 40 dB a row.
const VALUE_ROWS: u16 = 7;
const PLOT_ROWS: u16 = 7;

/// The receptors' range from its least to its greatest frequency, hertz. On a logarithmic axis 20
/// Hz is in its middle.
const HZ: [f64; 3] = [0.5, 20.0, 800.0];

/// What the plot has at least: the lowest threshold is -27 dB, the highest 59 dB.
const LEVELS_DB: [f64; 2] = [-40.0, 60.0];
/// What it has at most: lower levels are far below every threshold.
const LEVEL_LEAST_DB: f64 = -80.0;

/// Points of a threshold: more than a terminal has columns.
const POINTS: usize = 200;

/// What stands for the receptors' thresholds in the plot.
const LETTERS: [char; 4] = ['a', 'b', 'c', 'd'];

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let block = boxed("what a finger feels, a hertz; f: channels");
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(feel) = live.feel() else {
        let why = why_none(&live.settings().feel);
        frame.render_widget(Paragraph::new(why).wrap(Wrap { trim: true }), inner);
        return;
    };
    let [values, plot] =
        Layout::vertical([Constraint::Length(VALUE_ROWS), Constraint::Min(0)]).areas(inner);
    // A board with a fault has no plot on the smallest screen, but the fault.
    frame.render_widget(
        Paragraph::new(lines(feel, usize::from(inner.width))),
        values,
    );
    if !feel.faults.is_none() && plot.height > 0 {
        let names: Vec<_> = feel.faults.iter().map(name).collect();
        let [faults, plot] =
            Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(plot);
        frame.render_widget(
            Line::styled(format!("faults: {}", names.join(", ")), alarm(view)),
            faults,
        );
        spectrum(frame, plot, feel);
    } else {
        spectrum(frame, plot, feel);
    }
}

fn why_none(settings: &Feeling) -> &'static str {
    if settings.is_on() {
        "nothing yet: it comes with each window of a slide"
    } else {
        "The board does not report it: set feel.volts_per_um to what `ridgetone feel` finds for your finger."
    }
}

fn lines(feel: &Feel, width: usize) -> Vec<Line<'static>> {
    let receptors = receptors(feel);
    let most = receptors
        .iter()
        .filter_map(|reading| reading.found)
        .fold(0.0f32, |most, found| most.max(found.value));
    let columns = width.saturating_sub(NAME + VALUE + 1);
    let bars = receptors.iter().map(|reading| {
        row(reading, |found| {
            let share = if most > 0.0 { found.value / most } else { 0.0 };
            bar((share * 8.0 * columns as f32).round() as usize)
        })
    });
    let ratings = ratings(feel);
    let scales = ratings
        .iter()
        .map(|reading| row(reading, |found| scale(found, columns)));
    let m = feel
        .force_ratio
        .map_or("-".to_owned(), |Measured { value, sigma }| {
            text(value, sigma)
        });
    let window = format!(
        "{:.2} s at {:.0} Hz, {} taxels, M {m}",
        feel.window_s,
        feel.rate_hz,
        feel.taxels.count_ones()
    );
    bars.chain(scales)
        .map(Line::raw)
        .chain([Line::raw(window)])
        .collect()
}

/// A name with its value and a drawing of it, or why there is none.
fn row(reading: &Reading, drawing: impl Fn(Measured) -> String) -> String {
    let Reading {
        name,
        found,
        absent,
        ..
    } = reading;
    match (found, absent) {
        (Some(found), _) => {
            format!(
                "{name:<NAME$}{:>VALUE$} {}",
                text(found.value, found.sigma),
                drawing(*found)
            )
        }
        (None, why) => format!("{name:<NAME$}- {}", why.as_deref().unwrap_or_default()),
    }
}

fn text(value: f32, sigma: f32) -> String {
    // Zero: the value was set, or nothing is above a threshold.
    if sigma == 0.0 {
        significant(value.into(), 3)
    } else {
        uncertain(value.into(), sigma.into())
    }
}

/// A scale from 1 to 7 in `columns` columns: the value, and one standard deviation to each side. A
/// value beyond an end is an arrow there.
fn scale(Measured { value, sigma }: Measured, columns: usize) -> String {
    let places = columns.saturating_sub(2);
    let at = |value: f32| (value - 1.0) / 6.0 * places.saturating_sub(1) as f32;
    let (low, middle, high) = (
        at(value - sigma).round(),
        at(value).round(),
        at(value + sigma).round(),
    );
    let mark = |place: usize| match place as f32 {
        0.0 if middle < 0.0 => '◀',
        _ if place + 1 == places && middle > place as f32 => '▶',
        place if place == middle => '●',
        place if (low..=high).contains(&place) => '━',
        _ => '┄',
    };
    format!("1{}7", (0..places).map(mark).collect::<String>())
}

/// Levels of thirds of an octave and the thresholds, over the logarithm of the frequency; nothing
/// where the rows are too few.
fn spectrum(frame: &mut Frame<'_>, area: Rect, feel: &Feel) {
    if area.height < PLOT_ROWS {
        return;
    }
    let [title, plot] = Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(area);
    let thresholds = thresholds();
    let names: Vec<String> = LETTERS
        .iter()
        .zip(&thresholds)
        .map(|(letter, found)| format!("{letter} {}", found.name))
        .collect();
    frame.render_widget(
        Line::raw(format!("dB over 1 um; • level, {}", names.join(", "))),
        title,
    );
    let levels: Vec<(f64, f64)> = levels(feel)
        .map(|(hz, level_db)| (f64::from(hz).log10(), level_db.into()))
        .collect();
    let bounds = bounds(&levels);
    let lines: Vec<Vec<(f64, f64)>> = thresholds.iter().map(points).collect();
    let set = |points, marker| {
        Dataset::default()
            .data(points)
            .marker(marker)
            .style(Style::new())
            .graph_type(GraphType::Scatter)
    };
    let mut sets: Vec<Dataset<'_>> = lines
        .iter()
        .zip(LETTERS)
        .map(|(points, letter)| set(points, Marker::Custom(letter)))
        .collect();
    sets.push(set(&levels, Marker::Dot));
    let labels = [bounds[0], 0.5 * (bounds[0] + bounds[1]), bounds[1]]
        .map(|level_db| format!("{level_db:.0}"));
    let chart = Chart::new(sets)
        .x_axis(
            Axis::default()
                .bounds([HZ[0].log10(), HZ[2].log10()])
                .labels(HZ.map(|hz| format!("{hz} Hz"))),
        )
        .y_axis(Axis::default().bounds(bounds).labels(labels))
        .legend_position(None);
    frame.render_widget(chart, plot);
}

/// From the lowest to the highest level or threshold, decibels, in steps of 20 so that the axis
/// stands still.
fn bounds(levels: &[(f64, f64)]) -> [f64; 2] {
    let [least, most] = levels.iter().fold(LEVELS_DB, |[least, most], (_, db)| {
        [least.min(*db), most.max(*db)]
    });
    [
        ((least / 20.0).floor() * 20.0).max(LEVEL_LEAST_DB),
        (most / 20.0).ceil() * 20.0,
    ]
}

/// A threshold as points over the logarithm of the frequency, from end to end of each of its two
/// lines.
fn points(threshold: &Threshold) -> Vec<(f64, f64)> {
    let ends: Vec<(f64, f64)> = threshold
        .hz
        .iter()
        .zip(threshold.level_db)
        .map(|(hz, level_db)| (f64::from(*hz).log10(), level_db.into()))
        .collect();
    let between = |pair: &[(f64, f64)], at: usize| {
        let share = at as f64 / POINTS as f64;
        (
            pair[0].0 + share * (pair[1].0 - pair[0].0),
            pair[0].1 + share * (pair[1].1 - pair[0].1),
        )
    };
    ends.chunks_exact(2)
        .flat_map(|pair| (0..=POINTS).map(move |at| between(pair, at)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_has_its_value_its_sigma_and_its_ends() {
        let scale = |value, sigma| scale(Measured { value, sigma }, 15);
        assert_eq!(scale(1.0, 0.0), "1●┄┄┄┄┄┄┄┄┄┄┄┄7");
        assert_eq!(scale(4.0, 1.0), "1┄┄┄┄━━●━━┄┄┄┄7");
        assert_eq!(scale(7.0, 0.0), "1┄┄┄┄┄┄┄┄┄┄┄┄●7");
        assert_eq!(scale(-9.0, 0.5), "1◀┄┄┄┄┄┄┄┄┄┄┄┄7");
        assert_eq!(scale(9.0, 0.5), "1┄┄┄┄┄┄┄┄┄┄┄┄▶7");
    }

    #[test]
    fn the_axis_holds_every_threshold_and_the_levels() {
        let all = thresholds();
        let inside = |[least, most]: [f64; 2]| {
            all.iter()
                .flat_map(points)
                .all(|(_, db)| (least..=most).contains(&db))
        };
        assert!(inside(LEVELS_DB) && inside(bounds(&[(0.0, 93.0), (1.0, -128.0)])));
        assert_eq!(bounds(&[(0.0, 93.0), (1.0, -128.0)]), [-80.0, 100.0]);
        assert!((HZ[0] * HZ[2]).sqrt() == HZ[1]);
    }
}
