//! The sixteen channels: strips of their voltage if raw frames arrive, otherwise their amplitudes
//! in the latest window.

use super::style::{alarm, boxed};
use super::view::View;
use crate::feed::RawFrames;
use crate::frame::Frame as RawFrame;
use crate::live::Live;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use ridgetone_proto::settings::TAXELS;

/// Bars of increasing height, from none to full.
const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let rows = area.height.saturating_sub(2);
    let columns = if usize::from(rows) >= TAXELS { 1 } else { 2 };
    let width = usize::from(area.width.saturating_sub(2)) / columns;
    let (title, lines) = if live.strips.is_empty() {
        (
            format!("amplitudes in the window; {}", no_frames(view)),
            amplitudes(live, width),
        )
    } else {
        raw(live, view, width)
    };
    let style = if matches!(view.raw, RawFrames::Refused(_)) {
        alarm(view)
    } else {
        Default::default()
    };
    let block = boxed(title).title_style(style);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let areas = Layout::horizontal(vec![Constraint::Fill(1); columns]).split(inner);
    for (chunk, area) in lines.chunks(TAXELS / columns).zip(areas.iter()) {
        frame.render_widget(Paragraph::new(chunk.to_vec()), *area);
    }
}

fn no_frames(view: &View) -> String {
    match &view.raw {
        RawFrames::Unavailable => "no raw frames".into(),
        RawFrames::Off => "r: channels".into(),
        RawFrames::On => "waiting for frames".into(),
        RawFrames::Refused(why) => why.clone(),
    }
}

fn label(taxel: usize) -> String {
    format!("{taxel:>2} ")
}

/// Draws a bar for each channel of the latest estimate, all on one scale.
fn amplitudes(live: &Live, width: usize) -> Vec<Line<'static>> {
    let found: [Option<f32>; TAXELS] = std::array::from_fn(|taxel| {
        let channels = live
            .estimate()
            .filter(|estimate| estimate.status.has_tone())
            .map(|estimate| &estimate.channels);
        channels?
            .iter()
            .find(|channel| usize::from(channel.taxel) == taxel)
            .map(|channel| channel.amplitude_v)
    });
    let max_v = found.iter().flatten().copied().fold(0.0f32, f32::max);
    let columns = width.saturating_sub(3 + 10 + 1);
    let line = |(taxel, amplitude_v): (usize, &Option<f32>)| {
        let value = match amplitude_v {
            None => format!("{:>10}", "-"),
            Some(volts) => format!("{:>7.3} mV", 1e3 * volts),
        };
        let fraction = amplitude_v
            .filter(|_| max_v > 0.0)
            .map_or(0.0, |volts| volts / max_v);
        let eighths = (fraction * 8.0 * columns as f32).round() as usize;
        Line::raw(format!("{}{value} {}", label(taxel), bar(eighths)))
    };
    found.iter().enumerate().map(line).collect()
}

/// Returns a horizontal bar; its length is in eighths of a column.
pub fn bar(eighths: usize) -> String {
    const PARTS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    "█".repeat(eighths / 8) + PARTS[eighths % 8]
}

/// Draws the voltage of each channel about its mean, all on one scale.
fn raw(live: &Live, view: &View, width: usize) -> (String, Vec<Line<'static>>) {
    let end_s = live
        .strips
        .iter()
        .next_back()
        .map_or(0.0, |frame| frame.t_s);
    let begin_s = end_s - view.strips_s();
    let frames: Vec<&RawFrame> = live
        .strips
        .iter()
        .filter(|frame| frame.t_s > begin_s)
        .collect();
    let places = width.saturating_sub(3 + 1);
    let means: Vec<Vec<Option<f32>>> = (0..TAXELS)
        .map(|taxel| columns(&frames, taxel, begin_s, view.strips_s(), places))
        .collect();
    let half_v = means
        .iter()
        .flatten()
        .flatten()
        .map(|volts| volts.abs())
        .fold(0.0f32, f32::max);
    let lines = means.iter().enumerate().map(|(taxel, means)| {
        let strip: String = means
            .iter()
            .map(|mean| mean.map_or(' ', |volts| height(volts, half_v)))
            .collect();
        let alive = means.iter().any(Option::is_some);
        Line::from(vec![
            Span::raw(label(taxel)),
            if alive {
                Span::raw(strip)
            } else {
                Span::styled("no valid frame", alarm(view))
            },
        ])
    });
    (
        format!("channels, {} s, ±{:.3} mV", view.strips_s(), 1e3 * half_v),
        lines.collect(),
    )
}

/// Averages a channel over each of `places` columns of time and subtracts the mean of all columns.
/// A column is `None` if its frame is missing. If there are more columns than frames, a frame
/// fills all columns up to the next frame.
fn columns(
    frames: &[&RawFrame],
    taxel: usize,
    begin_s: f64,
    length_s: f64,
    places: usize,
) -> Vec<Option<f32>> {
    let mut sums = vec![(0.0f64, 0u32); places];
    let place = |frame: &RawFrame| {
        let place = ((frame.t_s - begin_s) / length_s * places as f64) as usize;
        place.min(places.saturating_sub(1))
    };
    let apart = |pair: &[&RawFrame]| pair[1].number.wrapping_sub(pair[0].number);
    let step = frames.windows(2).map(apart).min();
    for (at, frame) in frames.iter().enumerate() {
        let begin = place(frame);
        let next = frames
            .get(at..at + 2)
            .filter(|pair| Some(apart(pair)) == step);
        let end = next.map_or(0, |pair| place(pair[1])).max(begin + 1);
        for sum in sums.get_mut(begin..end).unwrap_or_default() {
            if let Some(volts) = frame.volts[taxel] {
                *sum = (sum.0 + f64::from(volts), sum.1 + 1);
            }
        }
    }
    let (sum, count) = sums
        .iter()
        .fold((0.0, 0), |all, one| (all.0 + one.0, all.1 + one.1));
    let mean = sum / f64::from(count.max(1));
    sums.iter()
        .map(|(sum, count)| (*count > 0).then(|| (sum / f64::from(*count) - mean) as f32))
        .collect()
}

/// Returns the bar for a voltage from -`half_v` to +`half_v`; 0 V has half the full height.
fn height(volts: f32, half_v: f32) -> char {
    let fraction = if half_v > 0.0 {
        0.5 + 0.5 * volts / half_v
    } else {
        0.5
    };
    BARS[1 + (fraction * 7.0).round().clamp(0.0, 7.0) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_their_length_and_height() {
        assert_eq!(
            (bar(0), bar(3), bar(16), bar(17)),
            (String::new(), "▍".into(), "██".into(), "██▏".into())
        );
        assert_eq!(
            [-1.0, 0.0, 1.0, 2.0].map(|volts| height(volts, 1.0)),
            ['▁', '▅', '█', '█']
        );
        assert_eq!(height(0.0, 0.0), '▅');
    }

    #[test]
    fn a_column_is_the_mean_of_its_frames_about_the_channel_s_own() {
        let frame = |number: u32, volts: Option<f32>| RawFrame {
            t_s: f64::from(number) * 0.25,
            number,
            volts: [volts; TAXELS],
        };
        // Three columns: the first and the last with frames, the middle one without.
        let frames = [
            frame(0, Some(1.0)),
            frame(1, Some(3.0)),
            frame(2, None),
            frame(3, None),
            frame(4, Some(4.0)),
            frame(5, Some(8.0)),
        ];
        let found = columns(&frames.each_ref(), 5, 0.0, 1.5, 3);
        assert_eq!(found, [Some(-2.0), None, Some(2.0)]);
        // Three columns per frame: only missing frames leave a hole.
        let near = [0, 1, 4, 5].map(|number| frame(number, Some(number as f32)));
        let found = columns(&near.each_ref(), 5, 0.0, 1.5, 18);
        let is_there: Vec<bool> = found.iter().map(Option::is_some).collect();
        let expected = [[true; 4], [false; 4]].concat();
        assert_eq!(is_there[..8], expected);
        assert!(is_there[12..16].iter().all(|there| *there));
    }
}
