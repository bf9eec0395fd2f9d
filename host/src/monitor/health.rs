//! The board's readings, and everything that was lost, on the board and on the line.

use super::screen::{alarm, boxed};
use super::view::View;
use crate::live::Live;
use crate::names::fault_name;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

/// Draws it.
pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let (title, style) = match live.faults() {
        [] => ("health: nothing is wrong".to_owned(), Default::default()),
        faults => {
            let names: Vec<_> = faults.iter().map(|fault| fault_name(fault.kind)).collect();
            (format!("health: FAULT: {}", names.join(", ")), alarm(view))
        }
    };
    let title = if live.health().is_none() { "health: not told yet".to_owned() } else { title };
    let lines = vec![readings(live), losses(live, view)];
    frame.render_widget(Paragraph::new(lines).block(boxed(title).title_style(style)), area);
}

fn readings(live: &Live) -> Line<'static> {
    let Some(health) = live.health() else { return Line::raw("") };
    let load = if health.load > 0.0 { format!("  load {:.1} %", 100.0 * health.load) } else { String::new() };
    let stack = match health.stack_bytes {
        0 => String::new(),
        bytes => format!("  stack {} %", u64::from(health.stack_used_bytes) * 100 / u64::from(bytes)),
    };
    Line::raw(format!(
        "{:.2} frames/s{load}{stack}  {:.1} C  supply {:.2} V  reference {:.3} V",
        health.frame_rate_hz, health.temperature_c, health.supply_v, health.reference_v
    ))
}

/// Zeros are as they should be; everything else is an alarm.
fn losses(live: &Live, view: &View) -> Line<'static> {
    let counts = live.counts;
    let mut spans = vec![Span::raw(format!("{} packets:", counts.received))];
    let mut count = |count: u64, what: &str| {
        let style = if count == 0 { Default::default() } else { alarm(view) };
        spans.push(Span::styled(format!(" {count} {what}"), style));
        spans.push(Span::raw(","));
    };
    count(counts.missing.into(), "lost");
    count(counts.damaged.into(), "damaged");
    if let Some(health) = live.health() {
        count(health.messages_dropped.into(), "dropped");
        count(health.conversions_lost.into(), "conversions lost");
        count(health.conversions_doubtful.into(), "doubtful");
        count(health.hops_skipped.into(), "hops skipped");
        if health.chip_restarts > 0 {
            count(health.chip_restarts.into(), "ADC restarts");
        }
    }
    spans.pop();
    Line::from(spans)
}
