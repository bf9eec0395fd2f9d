//! Draws the history of the frequency with its uncertainty.

use super::style::{alarm, boxed};
use super::view::View;
use crate::events::view::Estimate;
use crate::live::Live;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph};
use ridgetone_proto::telemetry::Status;

/// Minimum height of the chart, as a fraction of the frequency. In a lower chart, changes of a
/// millionth would look like noise.
const MIN_FRACTION: f64 = 1e-4;

/// Margin above and below, as a fraction of the height.
const MARGIN: f64 = 0.1;

/// Number of dots in an error bar: more than the chart has rows of dots.
const BAR_DOTS: usize = 96;

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let block = boxed(format!("frequency, Hz, last {} s", view.history_s()));
    let last_s = live
        .history
        .iter()
        .map(|point| point.t_s)
        .fold(f64::NEG_INFINITY, f64::max);
    let end_s = live.now.now_s.unwrap_or(last_s).max(last_s);
    // Show the full length of the axis from the start.
    let begin_s = (end_s - view.history_s()).max(0.0);
    let end_s = begin_s + view.history_s();
    let shown: Vec<&Estimate> = live
        .history
        .iter()
        .filter(|point| point.t_s >= begin_s)
        .collect();
    let Some(bounds) = bounds(&shown) else {
        let text = if live.history.is_empty() {
            "no frequency yet"
        } else {
            "no frequency in this time"
        };
        frame.render_widget(Paragraph::new(text).block(block), area);
        return;
    };
    let place = |good: bool| -> Vec<(f64, f64)> {
        let fits = |point: &&&Estimate| (point.status == Status::Good) == good;
        shown
            .iter()
            .filter(fits)
            .filter_map(|point| Some((point.t_s, point.frequency_hz?.into())))
            .collect()
    };
    let (good, others, bars) = (place(true), place(false), bars(&shown));
    let set = |points, marker, style| {
        Dataset::default()
            .data(points)
            .marker(marker)
            .style(style)
            .graph_type(GraphType::Scatter)
    };
    let sets = vec![
        set(&bars, Marker::Braille, Style::new()),
        set(&good, Marker::Dot, Style::new()),
        set(&others, Marker::Custom('x'), alarm(view)),
    ];
    let decimals = decimals(bounds);
    let labels = [bounds[0], 0.5 * (bounds[0] + bounds[1]), bounds[1]]
        .map(|value| format!("{value:.decimals$}"));
    let times = [begin_s, end_s].map(|t_s| format!("{t_s:.1} s"));
    let chart = Chart::new(sets)
        .block(block)
        .x_axis(Axis::default().bounds([begin_s, end_s]).labels(times))
        .y_axis(Axis::default().bounds(bounds).labels(labels))
        .legend_position(None);
    frame.render_widget(chart, area);
}

/// Returns the frequency of an estimate and its standard deviation, hertz.
fn found(point: &Estimate) -> Option<(f64, f64)> {
    Some((point.frequency_hz?.into(), point.sigma_hz?.into()))
}

/// Returns the range of the frequencies and their uncertainties; `None` if there is no frequency.
fn bounds(points: &[&Estimate]) -> Option<[f64; 2]> {
    let known = points.iter().filter_map(|point| found(point));
    let (low, high) = known.fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(low, high), (frequency, sigma)| {
            // A very uncertain estimate must not flatten the rest of the curve.
            let sigma = sigma.min(0.1 * frequency);
            (low.min(frequency - sigma), high.max(frequency + sigma))
        },
    );
    if low > high {
        return None;
    }
    let min = 0.5 * MIN_FRACTION * high;
    let middle = 0.5 * (low + high);
    let half = (0.5 * (high - low) * (1.0 + 2.0 * MARGIN)).max(min);
    Some([middle - half, middle + half])
}

/// Returns the number of decimals needed to tell the labels apart.
fn decimals(bounds: [f64; 2]) -> usize {
    (1.0 - (bounds[1] - bounds[0]).log10().floor()).clamp(0.0, 7.0) as usize
}

fn bars(points: &[&Estimate]) -> Vec<(f64, f64)> {
    let mut dots = Vec::new();
    for point in points {
        let Some((frequency, sigma)) = found(point) else {
            continue;
        };
        let dot = |dot: usize| frequency + sigma * (2.0 * dot as f64 / BAR_DOTS as f64 - 1.0);
        dots.extend((0..=BAR_DOTS).map(|number| (point.t_s, dot(number))));
    }
    dots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_tell_the_chart_s_ends_apart() {
        for bounds in [
            [8.3331, 8.3336],
            [8.0, 9.0],
            [0.0, 100.0],
            [0.27777, 0.27778],
        ] {
            let places = decimals(bounds);
            assert_ne!(
                format!("{:.places$}", bounds[0]),
                format!("{:.places$}", bounds[1])
            );
            let middle = 0.5 * (bounds[0] + bounds[1]);
            assert_ne!(
                format!("{:.places$}", bounds[0]),
                format!("{middle:.places$}")
            );
        }
    }
}
