//! The picture of the trade: error against instructions, one line for each method, the bound beside them.
//!
//! Methods are told apart by marker, dash and label; colour only helps.

mod marks;
mod place;

use super::Trade;
use super::grid::Row;
use crate::baselines::Method;
use crate::bench::{HARMONICS, SNR_DB, WINDOWS_S};
use marks::{LOOKS, marker};
use place::{LABEL_HEIGHT, Places};
use ridgetone_host::axis::Axis;
use ridgetone_host::fit_report::significant;
use ridgetone_host::svg::{Anchor, Svg};
use ridgetone_proto::settings::TAXELS;

const STYLE: &str = "text{font:12px system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:#222}\
.title{font-size:17px;font-weight:600}.small{font-size:11px;fill:#555}.head{font-size:11px;font-weight:600}\
.name{font-weight:600}path{fill:none}.card{fill:#fff;stroke:#bbb}.axis{stroke:#555}.grid{stroke:#e4e4e4}\
.label{fill:#f4f5f7;stroke:#ccc}.bare{fill:#fff}.bound{stroke:#555;stroke-width:1.2;stroke-dasharray:2 3}";

const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 680.0;
/// The axes' rectangle.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 930.0;
const TOP: f64 = 96.0;
const BOTTOM: f64 = 610.0;

/// A method's line: its name, and what it costs and brings by window.
struct Line<'a> {
    name: String,
    rows: Vec<&'a Row>,
}

/// Draws it.
pub fn draw(trade: &Trade) -> String {
    let lines = lines(trade);
    let points = || lines.iter().flat_map(|line| &line.rows).filter_map(|row| point(row));
    let bounds: Vec<(f64, f64)> = WINDOWS_S.into_iter().filter_map(|window_s| bound(trade, window_s)).collect();
    let x = Axis::around(points().map(|point| point.0), (LEFT, RIGHT));
    let y = Axis::around(points().map(|point| point.1).chain(bounds.iter().map(|bound| bound.1)), (BOTTOM, TOP));

    let title = "What a fit costs and what it brings";
    let subtitle = format!(
        "A grating with overtones, noise {SNR_DB} dB below its tone. Each marker is a window of {} s: longer windows, smaller errors.",
        WINDOWS_S.map(|window_s| window_s.to_string()).join(", ")
    );
    let mut svg = Svg::new(WIDTH, HEIGHT, &format!("{title}. {subtitle}"), STYLE);
    svg.text(24.0, 30.0, Anchor::Start, "title", title);
    svg.text(24.0, 50.0, Anchor::Start, "small", &subtitle);
    axes(&mut svg, &x, &y);

    let mut places = Places::new((LEFT, TOP, RIGHT, BOTTOM));
    for (_, percent) in &bounds {
        let height = y.place(*percent);
        svg.line((LEFT, height), (RIGHT, height), "bound");
    }
    let heights = spread(bounds.iter().map(|(_, percent)| y.place(*percent)).collect());
    for ((window_s, percent), height) in bounds.iter().zip(heights) {
        let figure = significant(*percent, 2);
        svg.line((RIGHT, y.place(*percent)), (RIGHT + 12.0, height), "bound");
        svg.text(RIGHT + 16.0, height + 4.0, Anchor::Start, "small", &format!("{window_s} s: {figure} %"));
    }
    svg.text(RIGHT + 8.0, TOP - 26.0, Anchor::Start, "head", "the bound,");
    svg.text(RIGHT + 8.0, TOP - 12.0, Anchor::Start, "head", "by window");

    let drawn: Vec<Vec<(f64, f64)>> = lines
        .iter()
        .map(|line| line.rows.iter().filter_map(|row| point(row)).map(|(a, b)| (x.place(a), y.place(b))).collect())
        .collect();
    for points in &drawn {
        points.iter().for_each(|point| places.take_marker(*point));
        points.windows(2).for_each(|pair| places.take_line(pair[0], pair[1]));
    }
    for (points, look) in drawn.iter().zip(LOOKS.iter().cycle()) {
        look.line(&mut svg, points);
        points.iter().for_each(|point| marker(&mut svg, look, *point));
    }
    // Which marker is which window, told once, at the line that matters.
    if let (Some(line), Some(points)) = (lines.first(), drawn.first()) {
        for (row, point) in line.rows.iter().zip(points) {
            places.label(&mut svg, &[*point], &format!("{} s", row.window_s), None);
        }
    }
    for ((line, points), look) in lines.iter().zip(&drawn).zip(LOOKS.iter().cycle()) {
        places.label(&mut svg, points, &line.name, Some(look));
    }
    svg.finish()
}

/// Heights of labels that begin at these and keep a line's distance, in their order from top to bottom.
fn spread(mut heights: Vec<f64>) -> Vec<f64> {
    for n in 1..heights.len() {
        heights[n] = heights[n].max(heights[n - 1] + LABEL_HEIGHT);
    }
    heights
}

/// The lines that have instructions, Ridgetone's first.
fn lines(trade: &Trade) -> Vec<Line<'_>> {
    let [one, .., four] = HARMONICS;
    let ours = |harmonics: u8, name: &str| {
        let rows =
            WINDOWS_S.into_iter().filter_map(|window_s| trade.ridgetone(window_s, four, harmonics, TAXELS as u8));
        Line { name: name.into(), rows: rows.filter(|row| point(row).is_some()).collect() }
    };
    let baseline = |method: Method| {
        let rows = WINDOWS_S.into_iter().flat_map(|window_s| trade.baseline(window_s, four, method));
        let rows: Vec<&Row> = rows.filter(|row| point(row).is_some()).collect();
        let channels = rows.first().map(|row| row.channels).filter(|channels| usize::from(*channels) < TAXELS);
        let name = channels.map_or_else(String::new, |channels| format!(", {channels} channels"));
        Line { name: format!("{}{name}", method.name()), rows }
    };
    let ours = [ours(four, "Ridgetone, four harmonics"), ours(one, "Ridgetone, one harmonic")];
    ours.into_iter().chain(Method::ALL.map(baseline)).filter(|line| !line.rows.is_empty()).collect()
}

/// Instructions and percent.
fn point(row: &Row) -> Option<(f64, f64)> {
    Some((f64::from(row.instructions?), row.rms_percent()?)).filter(|(_, percent)| *percent > 0.0)
}

/// The bound of a window of all channels and harmonics: seconds and percent.
fn bound(trade: &Trade, window_s: f64) -> Option<(f64, f64)> {
    let [.., four] = HARMONICS;
    let row = trade.ridgetone(window_s, four, four, TAXELS as u8)?;
    Some((window_s, row.accuracy.error?.bound_percent))
}

fn axes(svg: &mut Svg, x: &Axis, y: &Axis) {
    for power in x.ticks() {
        let at = x.place(10f64.powi(power));
        svg.line((at, TOP), (at, BOTTOM), "grid");
        svg.line((at, BOTTOM), (at, BOTTOM + 5.0), "axis");
        let label = match power {
            0..3 => 10i32.pow(power as u32).to_string(),
            3..6 => format!("{} thousand", 10i32.pow(power as u32 - 3)),
            6..9 => format!("{} million", 10i32.pow(power as u32 - 6)),
            _ => format!("1e{power}"),
        };
        svg.text(at, BOTTOM + 20.0, Anchor::Middle, "small", &label);
    }
    for power in y.ticks() {
        let at = y.place(10f64.powi(power));
        svg.line((LEFT, at), (RIGHT, at), "grid");
        svg.line((LEFT - 5.0, at), (LEFT, at), "axis");
        let decimals = usize::try_from(-power).unwrap_or(0);
        svg.text(LEFT - 9.0, at + 4.0, Anchor::End, "small", &format!("{:.decimals$}", 10f64.powi(power)));
    }
    svg.line((LEFT, BOTTOM), (RIGHT, BOTTOM), "axis");
    svg.line((LEFT, TOP), (LEFT, BOTTOM), "axis");
    svg.text(24.0, TOP - 16.0, Anchor::Start, "head", "RMS error, % of the frequency");
    let middle = 0.5 * (LEFT + RIGHT);
    svg.text(middle, BOTTOM + 44.0, Anchor::Middle, "head", "instructions on the Cortex-M4F, costliest window");
}
