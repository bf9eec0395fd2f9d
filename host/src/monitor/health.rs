//! Draws the board's health readings, and all losses on the board and on the line.

use super::style::{alarm, boxed, fitted};
use super::view::View;
use crate::live::Live;
use crate::names::name;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let (title, style) = match live.now.faults.as_slice() {
        [] => (
            format!("health: OK; {} packets", live.now.counts.received),
            Default::default(),
        ),
        faults => {
            let names: Vec<_> = faults.iter().map(|fault| name(fault.kind)).collect();
            (format!("health: FAULT: {}", names.join(", ")), alarm(view))
        }
    };
    let title = if live.health().is_none() {
        "health: none yet".to_owned()
    } else {
        title
    };
    let losses = losses(live, view);
    // If the losses need both lines, drop the readings: losses matter more.
    let lines = if losses.width() > usize::from(area.width.saturating_sub(2)) {
        vec![losses]
    } else {
        vec![readings(live), losses]
    };
    let title = fitted(&title, usize::from(area.width.saturating_sub(4)));
    let text = Paragraph::new(lines).wrap(Wrap { trim: true });
    frame.render_widget(text.block(boxed(title).title_style(style)), area);
}

fn readings(live: &Live) -> Line<'static> {
    let Some(health) = live.health() else {
        return Line::raw("");
    };
    let load = if health.load > 0.0 {
        format!("  load {:.1} %", 100.0 * health.load)
    } else {
        String::new()
    };
    let stack = match health.stack_bytes {
        0 => String::new(),
        bytes => format!(
            "  stack {} %",
            u64::from(health.stack_used_bytes) * 100 / u64::from(bytes)
        ),
    };
    Line::raw(format!(
        "{:.2} frames/s{load}{stack}  {:.1} C  supply {:.2} V  ref {:.3} V",
        health.frame_rate_hz, health.temperature_c, health.supply_v, health.reference_v
    ))
}

/// Returns the counts of losses; each one that is not zero is shown as an alarm.
fn losses(live: &Live, view: &View) -> Line<'static> {
    let mut spans = Vec::new();
    let mut count = |before: &str, count: u32, what: &str| {
        let style = if count == 0 {
            Default::default()
        } else {
            alarm(view)
        };
        spans.push(Span::raw(before.to_owned()));
        spans.push(Span::styled(format!("{count} {what}"), style));
    };
    count("line: ", live.now.counts.missing, "lost");
    count(", ", live.now.counts.damaged, "damaged");
    if let Some(health) = live.health() {
        count(", ", health.messages_dropped, "dropped");
        if health.frames_thinned > 0 {
            count(", ", health.frames_thinned, "raw frames not sent");
        }
        count("; ADC: ", health.conversions_lost, "lost");
        count(", ", health.conversions_doubtful, "doubtful");
        count("; ", health.overruns, "overruns");
        if health.chip_restarts > 0 {
            count(", ", health.chip_restarts, "ADC restarts");
        }
    }
    Line::from(spans)
}
