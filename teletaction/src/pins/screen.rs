//! The screen: strain in the sensor, forces of the pins, strain in the finger, as shades and
//! numbers.

use super::player::{Player, Update};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph, Wrap};

/// From nothing to the greatest.
const SHADES: [char; 5] = [' ', '\u{2591}', '\u{2592}', '\u{2593}', '\u{2588}'];

/// What passes for rest, as a strain and in newtons: shades are of more than that.
const REST_STRAIN: f32 = 5e-4;
const REST_N: f32 = 0.01;

/// Columns from which on cells have no numbers.
const WIDE: usize = 6;

pub fn draw(frame: &mut Frame<'_>, source: &str, update: Option<&Update>, player: &Player) {
    let setup = player.setup();
    let rows = setup.pins.rows().max(4) as u16;
    let [top, middle, below, keys, _] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(2 * rows + 2),
        Constraint::Length(2),
        Constraint::Length(1),
        Constraint::Min(0),
    ])
    .areas(frame.area());
    let Some(update) = update else {
        frame.render_widget(
            Line::raw(format!(
                "ridgetone pins  {source}  learning the level without touch"
            )),
            top,
        );
        frame.render_widget(Line::raw("q quit"), keys);
        return;
    };
    frame.render_widget(
        Line::raw(format!(
            "ridgetone pins  {source}  {:.2} s",
            update.pins.t_s
        )),
        top,
    );
    let boxes: [Rect; 3] = Layout::horizontal([Constraint::Ratio(1, 3); 3]).areas(middle);
    let gained: Vec<f32> = update
        .sensor_strain
        .iter()
        .map(|strain| setup.gain as f32 * strain)
        .collect();
    let greatest = |values: &[f32]| {
        values
            .iter()
            .fold(REST_STRAIN, |most, value| most.max(*value))
    };
    // One scale for both strains, so that equal shades are equal strains.
    let strain = greatest(&gained).max(greatest(&update.felt_strain));
    let force = setup
        .limits
        .max_n()
        .min(greatest(&update.pins.forces_n).max(5.0 * REST_N));
    for (position, title, values, columns, most, scale, decimals) in [
        (
            boxes[0],
            "strain in the sensor, %",
            &gained,
            4,
            strain,
            100.0,
            2,
        ),
        (
            boxes[1],
            "forces of the pins, N",
            &update.pins.forces_n,
            update.pins.columns,
            force,
            1.0,
            2,
        ),
        (
            boxes[2],
            "strain in the finger, %",
            &update.felt_strain,
            4,
            strain,
            100.0,
            2,
        ),
    ] {
        let lines: Vec<Line<'static>> = cells(values, columns, most, scale, decimals)
            .into_iter()
            .map(Line::raw)
            .collect();
        frame.render_widget(
            Paragraph::new(lines).block(Block::bordered().title(format!(" {title} "))),
            position,
        );
    }
    let summary = Paragraph::new(summary(update, setup.gain)).wrap(Wrap { trim: true });
    frame.render_widget(summary, below);
    frame.render_widget(Line::raw("q quit"), keys);
}

/// Two lines a row: shades, and below them numbers if there is room.
fn cells(values: &[f32], columns: usize, most: f32, scale: f32, decimals: usize) -> Vec<String> {
    let shade = |value: &f32| SHADES[((value / most).clamp(0.0, 1.0) * 4.0).round() as usize];
    let mut lines = Vec::new();
    for row in values.chunks(columns) {
        let width = if columns < WIDE { 6 } else { 2 };
        let shades: String = row
            .iter()
            .map(|value| shade(value).to_string().repeat(width))
            .collect();
        let numbers: String = match columns < WIDE {
            true => row
                .iter()
                .map(|value| format!("{:>6}", number(scale * value, decimals)))
                .collect(),
            false => shades.clone(),
        };
        lines.extend([shades, numbers]);
    }
    lines
}

/// A number without the sign of a zero.
fn number(value: f32, decimals: usize) -> String {
    let shown = format!("{value:.decimals$}");
    match shown.strip_prefix('-') {
        Some(zero) if zero.parse() == Ok(0.0f32) => zero.to_owned(),
        _ => shown,
    }
}

/// What a person wants to know of an update, in a line.
pub fn summary(update: &Update, gain: f64) -> String {
    let most = |values: &[f32]| values.iter().fold(f32::MIN, |most, value| most.max(*value));
    let limited = if update.pins.limited > 0 {
        format!(", {} pins at their limit", update.pins.limited)
    } else {
        String::new()
    };
    format!(
        "{:8.3} s  sensor {} %  finger {} %, error {:.2} % rms; pins: {:.2} N max, {:.2} N total{limited}",
        update.pins.t_s,
        number(100.0 * gain as f32 * most(&update.sensor_strain), 2),
        number(100.0 * most(&update.felt_strain), 2),
        100.0 * update.error(gain),
        most(&update.pins.forces_n),
        update.pins.forces_n.iter().sum::<f32>(),
    )
}
