//! Draws the latest frequency, period and speed, and the phase of the touch.

use super::style::{alarm, bold, boxed};
use super::view::View;
use crate::digits::{seconds, uncertain};
use crate::live::{Live, Phase};
use crate::names::name;
use crate::remarks::{phrases, remedy};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};
use ridgetone_proto::telemetry::{Direction, Estimate, Status, Travel, TravelStatus};

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live, view: &View) {
    let text = Paragraph::new(lines(live, view)).wrap(Wrap { trim: true });
    frame.render_widget(text.block(boxed(phase(live))), area);
}

fn phase(live: &Live) -> String {
    let name = phase_name(live.now.phase);
    match live.now.phase_since_s.filter(|_| live.now.touches > 0) {
        Some(since_s) => format!("{name} since {since_s:.2} s"),
        None => name.to_owned(),
    }
}

fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Unknown => "not known yet",
        Phase::Idle => "no contact",
        Phase::Held => "contact, held",
        Phase::Sliding => "sliding",
        Phase::HeldAfter => "held again",
    }
}

fn lines(live: &Live, view: &View) -> Vec<Line<'static>> {
    let Some(estimate) = live.estimate() else {
        return vec![
            Line::raw("no estimate yet"),
            Line::raw("touch, hold, slide"),
        ];
    };
    let before = |estimate| match live.is_past(estimate) {
        true => "touch before: ",
        false => "",
    };
    let shown = format!("{}{}", before(estimate), frequency(estimate));
    let mut lines = vec![Line::styled(shown, bold())];
    let remedy = remedy(estimate.status);
    let mut remarks = phrases(estimate).into_iter().peekable();
    let mut status = name(estimate.status).to_owned();
    // The smallest screen has six rows here, so a remedy replaces the time.
    match remedy {
        None => {
            status += &format!(
                ", {:.2} s, to {:.2} s",
                estimate.window_s,
                seconds(estimate.t_us)
            )
        }
        Some(_) => status.extend(
            remarks
                .next_if(|remark| remark.starts_with("wander"))
                .map(|wander| format!(", {wander}")),
        ),
    }
    let style = if estimate.status == Status::Good {
        Default::default()
    } else {
        alarm(view)
    };
    lines.push(Line::styled(status, style));
    lines.extend(remedy.map(|remedy| Line::styled(remedy, style)));
    lines.extend(travel(&estimate.travel).into_iter().map(Line::raw));
    if !estimate.faults.is_none() {
        let names: Vec<_> = estimate.faults.iter().map(name).collect();
        lines.push(Line::styled(
            format!("faults: {}", names.join(", ")),
            alarm(view),
        ));
    }
    lines.extend(remarks.map(Line::raw));
    if let Some(whole) = live.whole_slide() {
        let shown = format!("{}slide {}", before(whole), frequency(whole));
        lines.push(Line::raw(shown));
    }
    lines
}

/// Returns the frequency with its uncertainty, or the status if there is no frequency.
fn frequency(estimate: &Estimate) -> String {
    if !estimate.status.has_tone() {
        return format!("- ({})", name(estimate.status));
    }
    let shown = uncertain(estimate.frequency.into(), estimate.sigma.into());
    format!("{shown} Hz")
}

fn travel(travel: &Travel) -> [String; 2] {
    if !travel.is_known() {
        let why = match travel.status {
            TravelStatus::Nothing => "not known",
            status => name(status),
        };
        return [format!("period {why}"), format!("speed  {why}")];
    }
    let Travel {
        spatial_period_mm,
        spatial_period_sigma_mm,
        speed_mm_s,
        speed_sigma_mm_s,
        ..
    } = *travel;
    let period = uncertain(spatial_period_mm.into(), spatial_period_sigma_mm.into());
    let speed = uncertain(speed_mm_s.into(), speed_sigma_mm_s.into());
    let arrow = match travel.direction {
        Direction::Forward => " →",
        Direction::Backward => " ←",
        Direction::Unknown => "",
    };
    let doubt = match travel.status {
        TravelStatus::Uncalibrated => " uncal.",
        _ => "",
    };
    [
        format!("period {period} mm{doubt}"),
        format!("speed  {speed} mm/s{arrow}"),
    ]
}
