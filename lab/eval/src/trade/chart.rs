//! The picture of the trade: error against instructions, one line for each method, the bound beside
//! them.

use super::noise_chart::{self, SHAPES};
use super::results::{Row, Trade};
use crate::axis::Axis;
use crate::baselines::Method;
use crate::bench::fits::{HARMONICS, WINDOWS_S};
use crate::noise;
use crate::plot::{Sample, key, log_axis, marker, picture};
use ridgetone_host::digits::significant;
use ridgetone_host::svg::{Anchor, Svg};
use ridgetone_proto::settings::TAXELS;

/// Height of the picture without what may be below it, pixels.
const HEIGHT: f64 = 690.0;
/// Edges of the axes' rectangle, pixels.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 850.0;
const TOP: f64 = 70.0;
const BOTTOM: f64 = 550.0;
/// Distance of two labels of the bound, pixels.
const LABEL_HEIGHT: f64 = 14.0;

/// Classes of lines and their markers; each shape has each of them once.
const LINES: [(&str, &str); 3] = [
    ("one", "solid one fillone"),
    ("two", "solid two filltwo"),
    ("three", "solid three fillthree"),
];

/// A method's line: its name, and cost and error by window.
struct MethodCurve<'a> {
    name: String,
    rows: Vec<&'a Row>,
}

/// The picture; where the noise of `noise` was compared with its bound, that is below.
pub fn draw(trade: &Trade, noise: &[noise::Row]) -> String {
    let lines = lines(trade);
    let points = || {
        lines
            .iter()
            .flat_map(|line| &line.rows)
            .filter_map(|row| point(row))
    };
    let bounds: Vec<(f64, f64)> = WINDOWS_S
        .into_iter()
        .filter_map(|window_s| bound(trade, window_s))
        .collect();
    let x = Axis::around(points().map(|point| point.0), (LEFT, RIGHT));
    let y = Axis::around(
        points()
            .map(|point| point.1)
            .chain(bounds.iter().map(|bound| bound.1)),
        (BOTTOM, TOP),
    );

    let kinds = noise::kinds(noise);
    let has_bounds = kinds
        .iter()
        .flat_map(|kind| &kind.ours)
        .any(|figures| figures.over_bound.is_some());
    let below = if has_bounds { noise_chart::HEIGHT } else { 0.0 };
    let mut svg = picture(HEIGHT + below, "Cost and error of a fit");
    let title = "RMS error, % of the frequency, against instructions; a grating with overtones, noise 20 dB below its tone";
    svg.text(22.0, 26.0, Anchor::Start, "title", title);
    log_axis(&mut svg, &y, (LEFT, RIGHT));
    for power in x.ticks() {
        let at = x.place(10f64.powi(power));
        svg.line((at, TOP), (at, BOTTOM), "grid");
        svg.text(
            at,
            BOTTOM + 20.0,
            Anchor::Middle,
            "small",
            &format!("1e{power}"),
        );
    }
    let below = "instructions on the Cortex-M4F, costliest window; each marker is a length of window, longer ones err less";
    svg.text(
        0.5 * (LEFT + RIGHT),
        BOTTOM + 40.0,
        Anchor::Middle,
        "small",
        below,
    );
    draw_bounds(&mut svg, &y, &bounds);

    let styles = SHAPES
        .into_iter()
        .flat_map(|shape| LINES.map(|(line, class)| (line, shape, class)));
    let mut entries = Vec::new();
    for (line, (class, shape, marker_class)) in lines.iter().zip(styles) {
        let points: Vec<(f64, f64)> = line
            .rows
            .iter()
            .filter_map(|row| point(row))
            .map(|(a, b)| (x.place(a), y.place(b)))
            .collect();
        svg.path(&points, class);
        points
            .iter()
            .for_each(|point| marker(&mut svg, shape, *point, marker_class));
        if entries.is_empty() {
            for (row, (x, y)) in line.rows.iter().zip(points) {
                svg.text(
                    x - 7.0,
                    y - 6.0,
                    Anchor::End,
                    "cell",
                    &format!("{} s", row.window_s),
                );
            }
        }
        entries.push((
            Sample::Marked(class, shape, marker_class),
            line.name.as_str(),
        ));
    }
    for (n, entries) in entries.chunks(3).enumerate() {
        key(&mut svg, LEFT, BOTTOM + 76.0 + 22.0 * n as f64, entries);
    }
    if has_bounds {
        noise_chart::draw(&mut svg, &kinds, HEIGHT, (LEFT, RIGHT));
    }
    svg.finish()
}

/// The bound by window: lines across, labels at the right.
fn draw_bounds(svg: &mut Svg, y: &Axis, bounds: &[(f64, f64)]) {
    svg.text(RIGHT + 8.0, TOP - 14.0, Anchor::Start, "small", "the bound");
    let mut label = f64::NEG_INFINITY;
    for (window_s, percent) in bounds {
        let height = y.place(*percent);
        label = height.max(label + LABEL_HEIGHT);
        svg.line((LEFT, height), (RIGHT, height), "truth");
        svg.line((RIGHT, height), (RIGHT + 8.0, label), "truth");
        let text = format!("{window_s} s: {} %", significant(*percent, 2));
        svg.text(RIGHT + 12.0, label + 4.0, Anchor::Start, "small", &text);
    }
}

/// The lines with instructions, Ridgetone's first.
fn lines(trade: &Trade) -> Vec<MethodCurve<'_>> {
    let [one, .., four] = HARMONICS;
    let ours = |harmonics: u8, name: &str| {
        let rows = WINDOWS_S
            .into_iter()
            .filter_map(|window_s| trade.ridgetone(window_s, four, harmonics, TAXELS as u8));
        MethodCurve {
            name: name.into(),
            rows: rows.filter(|row| point(row).is_some()).collect(),
        }
    };
    let baseline = |method: Method| {
        let rows = WINDOWS_S
            .into_iter()
            .flat_map(|window_s| trade.baseline(window_s, four, method.name()));
        let rows: Vec<&Row> = rows.filter(|row| point(row).is_some()).collect();
        let channels = rows
            .first()
            .map(|row| row.channels)
            .filter(|channels| usize::from(*channels) < TAXELS);
        let name = channels.map_or_else(String::new, |channels| format!(", {channels} channels"));
        MethodCurve {
            name: format!("{}{name}", method.name()),
            rows,
        }
    };
    let ours = [
        ours(four, "Ridgetone, four harmonics"),
        ours(one, "Ridgetone, one harmonic"),
    ];
    ours.into_iter()
        .chain(Method::ALL.map(baseline))
        .filter(|line| !line.rows.is_empty())
        .collect()
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
