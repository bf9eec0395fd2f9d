//! The static image: a 4 x 4 map of the level of each taxel in the latest hold.

use super::style::boxed;
use crate::digits::significant;
use crate::live::Live;
use crate::static_image;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Paragraph;
use ridgetone_proto::telemetry::Hold;

pub fn draw(frame: &mut Frame<'_>, area: Rect, live: &Live) {
    let title = match live.image().map(|image| image.hold) {
        Some(Hold::BeforeSlide) => "static image before, mV",
        Some(Hold::AfterSlide) => "static image after, mV",
        None => "static image, mV",
    };
    frame.render_widget(Paragraph::new(lines(live)).block(boxed(title)), area);
}

fn lines(live: &Live) -> Vec<Line<'static>> {
    let Some(image) = live.image() else {
        return vec![
            Line::raw("none yet: it comes when"),
            Line::raw("a hold is over"),
        ];
    };
    let mut lines = Vec::new();
    for (row, text) in static_image::rows(image, 6, 1).into_iter().enumerate() {
        if row == static_image::SIDE / 2 {
            lines.push(Line::raw(format!("{0}-+{0}", "-".repeat(12))));
        }
        lines.push(Line::raw(text));
    }
    let sigma = static_image::max_sigma_v(image);
    lines.push(Line::raw(sigma.map_or(String::new(), |sigma_v| {
        format!("σ at most {} mV", significant(f64::from(1e3 * sigma_v), 2))
    })));
    lines
}
