//! Draws [`Live`] on the terminal, which must have at least 80 x 24 characters.
//!
//! The terminal's own colours are used, so that the screen is readable on dark and on light
//! backgrounds. Important text is bold or reversed; only alarms are red.

use super::style::{alarm, bold, boxed, fitted, wrapped};
use super::view::{HELP, KEYS, View};
use super::{chart, health, map, strips, tone};
use crate::live::{Connection, Live};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Clear, Paragraph};

/// Smallest screen on which everything fits: columns and rows.
pub const SIZE_MIN: (u16, u16) = (80, 24);

/// Width of the right side, columns.
const RIGHT: u16 = 30;

/// Heights of the boxes for the map and for the health readings, rows.
const MAP_ROWS: u16 = 10;
const HEALTH_ROWS: u16 = 4;

/// Rows of the log on screens with more rows than [`LEAST`].
const LOG_ROWS: u16 = 8;

pub fn draw(frame: &mut Frame<'_>, live: &Live, view: &View) {
    let area = frame.area();
    if area.width < SIZE_MIN.0 || area.height < SIZE_MIN.1 {
        let text = format!(
            "{} x {}: the screen needs {} x {}\nq quit; --plain prints lines",
            area.width, area.height, SIZE_MIN.0, SIZE_MIN.1
        );
        frame.render_widget(Paragraph::new(text), area);
        return;
    }
    let spare = area.height - SIZE_MIN.1;
    // Spare rows go to the strips first, one row each, then to the log.
    let log_rows = if spare >= 8 + LOG_ROWS { LOG_ROWS } else { 0 };
    let middle_rows = MAP_ROWS + if spare >= 8 { 8 } else { 0 };
    let [top, above, middle, below, log, keys] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(8),
        Constraint::Length(middle_rows),
        Constraint::Length(HEALTH_ROWS),
        Constraint::Length(log_rows),
        Constraint::Length(1),
    ])
    .areas(area);
    let sides =
        |area| Layout::horizontal([Constraint::Min(0), Constraint::Length(RIGHT)]).areas(area);
    header(frame, top, live, view);
    let [left, right] = sides(above);
    chart::draw(frame, left, live, view);
    tone::draw(frame, right, live, view);
    let [left, right] = sides(middle);
    strips::draw(frame, left, live, view);
    map::draw(frame, right, live);
    health::draw(frame, below, live, view);
    if log_rows > 0 {
        log_lines(frame, log, live);
    }
    frame.render_widget(Line::raw(KEYS), keys);
    if view.shows_help {
        help(frame, area);
    }
}

fn header(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let state = match &live.now.connection {
        Connection::Waiting => Span::raw("nothing received yet"),
        Connection::Connected if live.hello().is_none() && live.now.now_s.is_none() => {
            match &live.now.strangers {
                Some(what) => Span::styled(what.clone(), alarm(view)),
                None => Span::raw("open, nothing received yet"),
            }
        }
        Connection::Connected => Span::raw("connected"),
        Connection::Disconnected { .. } => Span::styled("UNPLUGGED, waiting for it", alarm(view)),
        Connection::Over => Span::raw("over"),
    };
    let mut spans = vec![Span::raw("  "), state];
    if let Some(hello) = live.hello() {
        let [major, minor, patch] = hello.version;
        spans.push(Span::raw(format!("  firmware {major}.{minor}.{patch}")));
    }
    if let Some(now_s) = live.now.now_s {
        spans.push(Span::raw(format!("  {now_s:.1} s")));
    }
    if live.now.restarts > 0 {
        spans.push(Span::styled(
            format!("  {} restarts", live.now.restarts),
            alarm(view),
        ));
    }
    if view.is_paused {
        spans.push(Span::raw("  "));
        spans.push(Span::styled(
            " PAUSED ",
            Style::new().add_modifier(Modifier::REVERSED),
        ));
    }
    // The name of a port may be long, so it is shortened to fit.
    let used: usize = spans.iter().map(Span::width).sum();
    let room = usize::from(area.width).saturating_sub(used + "ridgetone  ".len());
    let source = format!("  {}", fitted(&live.now.source, room));
    spans.splice(0..0, [Span::styled("ridgetone", bold()), Span::raw(source)]);
    frame.render_widget(Line::from(spans), area);
}

fn log_lines(frame: &mut Frame<'_>, area: Rect, live: &Live) {
    let rows = usize::from(area.height.saturating_sub(2));
    let columns = usize::from(area.width.saturating_sub(2));
    let all: Vec<String> = live
        .log
        .iter()
        .flat_map(|line| wrapped(line, columns))
        .collect();
    let latest = all[all.len().saturating_sub(rows)..].iter();
    let lines: Vec<Line<'_>> = latest.map(|line| Line::raw(line.as_str())).collect();
    frame.render_widget(Paragraph::new(lines).block(boxed("events")), area);
}

fn help(frame: &mut Frame<'_>, area: Rect) {
    let (width, height) = (62, HELP.len() as u16 + 2);
    let x = area.x + (area.width - width) / 2;
    let y = area.y + (area.height - height) / 2;
    let place = Rect {
        x,
        y,
        width,
        height,
    };
    frame.render_widget(Clear, place);
    let lines: Vec<Line<'_>> = HELP
        .iter()
        .map(|line| Line::raw(format!(" {line}")))
        .collect();
    frame.render_widget(Paragraph::new(lines).block(boxed("help")), place);
}
