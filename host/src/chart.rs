//! Draws pictures as SVG: charts of curves with a key, and [`strips`] of channels.
//!
//! | what | where |
//! |---|---|
//! | shapes, axes, panels of curves | here |
//! | a row for each channel, whole and close up | [`strips`] |

pub mod strips;

use std::fmt::Write;

#[derive(Debug)]
struct Svg {
    body: String,
}

impl Svg {
    /// Starts a picture of this height on a white card, legible on light and dark pages. `title` is
    /// for screen readers.
    fn new(height: f64, title: &str) -> Self {
        let width = CHART_WIDTH;
        let mut body = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\n"
        );
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            body,
            "<title>{}</title>\n<style>{STYLE}</style>",
            escape(title)
        );
        let mut svg = Self { body };
        svg.push(&format!(
            "<rect x=\"0.5\" y=\"0.5\" width=\"{}\" height=\"{}\" rx=\"8\" class=\"card\"/>",
            width - 1.0,
            height - 1.0
        ));
        svg
    }

    fn push(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// Draws a line of text; `y` is its baseline, `anchor` is `start`, `middle` or `end`.
    fn text(&mut self, [x, y]: [f64; 2], anchor: &str, class: &str, text: &str) {
        let text = escape(text);
        self.push(&format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{text}</text>"));
    }

    fn line(&mut self, ends: [(f64, f64); 2], class: &str) {
        self.path(&ends, class);
    }

    fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], class: &str) {
        self.push(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\"/>"
        ));
    }

    fn path(&mut self, points: &[(f64, f64)], class: &str) {
        let mut d = String::new();
        for (i, (x, y)) in points.iter().enumerate() {
            let _ = write!(d, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        self.push(&format!("<path d=\"{d}\" class=\"{class}\"/>"));
    }

    /// Draws dots, as a path of zero-length strokes with round ends.
    fn dots(&mut self, points: &[(f64, f64)], class: &str) {
        let mut d = String::new();
        for (x, y) in points {
            let _ = write!(d, "M{x:.1} {y:.1}h0");
        }
        self.push(&format!("<path d=\"{d}\" class=\"{class}\"/>"));
    }

    fn finish(mut self) -> String {
        self.push("</svg>");
        self.body
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// Style of all pictures: legible on light and dark pages. The colours are those of Okabe and Ito,
/// lighter on dark pages; dashes and markers distinguish the curves without colour.
const STYLE: &str = "svg text{font:12px system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:#222}\
svg .title{font-size:16px;font-weight:600}svg .small{font-size:11px;fill:#555}svg .head{font-size:11px;font-weight:600}\
svg path{fill:none}svg path.shade{fill:#5b6470}svg path.dots{stroke-width:5;stroke-linecap:round}svg .card{fill:#fff;stroke:#bbb}svg .odd{fill:#f4f5f7}svg .axis{stroke:#555}svg .grid{stroke:#ddd}\
svg .slide{fill:#cfe3f5;fill-opacity:.55}svg .mark{stroke:#a01050;stroke-width:1.2;stroke-dasharray:4 3}\
svg .window{stroke:#0064a4;stroke-width:3}svg .edge{stroke:#0064a4;stroke-dasharray:1 3}svg .bar{stroke:#222;stroke-width:2}\
svg .data{stroke:#556;stroke-width:.8;stroke-linejoin:round}svg .dot{stroke:#556;stroke-width:2.6;stroke-linecap:round}\
svg .fit{stroke:#c4480a;stroke-width:1.6}svg .reference{stroke:#222;stroke-width:1.2;stroke-dasharray:2 3}\
svg .c0,svg .c1,svg .c2,svg .c3{stroke-width:1.5;stroke-linejoin:round}svg .c0{stroke:#0064a4}svg .c1{stroke:#c4480a}\
svg .c2{stroke:#00795a}svg .c3{stroke:#a01050}svg .d1{stroke-dasharray:7 3}svg .d2{stroke-dasharray:2 3}svg .d3{stroke-dasharray:9 3 2 3}\
@media(prefers-color-scheme:dark){svg text{fill:#e4e6ea}svg .small{fill:#b4b8c0}svg .card{fill:#16191e;stroke:#444}\
svg .odd{fill:#1c2026}svg .axis{stroke:#aab}svg .grid{stroke:#2c3138}svg .slide{fill:#274a68}svg .mark{stroke:#ff7fb0}\
svg .window,svg .edge{stroke:#6bb8f0}svg .bar,svg .reference{stroke:#eee}svg .data,svg .dot{stroke:#99a3b3}\
svg .fit{stroke:#ff9a5c}svg .c0{stroke:#6bb8f0}svg .c1{stroke:#ff9a5c}svg .c2{stroke:#4fd0a4}svg .c3{stroke:#ff7fb0}}";

/// Widths of a character in small labels and in all other labels, rounded up, pixels.
const CHARACTER: f64 = 6.4;
const WIDE_CHARACTER: f64 = 7.0;

/// Axis that maps a range of values to a range of pixels, evenly divided or by decades.
#[derive(Clone, Copy, Debug)]
struct Axis {
    range: (f64, f64),
    at: (f64, f64),
    is_log: bool,
}

impl Axis {
    fn place(&self, value: f64) -> f64 {
        let scaled = |value: f64| if self.is_log { value.log10() } else { value };
        let (from, to) = (scaled(self.range.0), scaled(self.range.1));
        self.at.0 + (self.at.1 - self.at.0) * (scaled(value) - from) / (to - from)
    }

    /// Returns round values within the range, about `wanted` of them on a linear axis.
    fn ticks(&self, wanted: u32) -> Vec<(f64, String)> {
        let (from, to) = self.range;
        if self.is_log {
            let decades = from.log10().floor() as i32..=to.log10().ceil() as i32;
            let digits: &[f64] = if (to / from).log10() > 4.0 {
                &[1.0]
            } else {
                &[1.0, 2.0, 5.0]
            };
            let values =
                decades.flat_map(|power| digits.iter().map(move |d| d * 10f64.powi(power)));
            let inside = values.filter(|value| (from * 0.999..=to * 1.001).contains(value));
            return inside.map(|value| (value, plain(value))).collect();
        }
        let step = nice((to - from) / f64::from(wanted));
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let numbers = (from / step - 1e-9).ceil() as i64..=(to / step + 1e-9).floor() as i64;
        let values = numbers.map(|number| number as f64 * step);
        values
            .map(|value| (value, format!("{value:.decimals$}")))
            .collect()
    }
}

/// Formats a power of ten times 1, 2 or 5 without rounding errors.
fn plain(value: f64) -> String {
    if !(1e-3..1e5).contains(&value) {
        return format!("{value:.0e}");
    }
    let decimals = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// Returns the greatest of 1, 2, 5 times a power of ten that is not above `value`.
fn nice(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let digits = [5.0, 2.0].into_iter().find(|digit| value >= digit * power);
    digits.unwrap_or(1.0) * power
}

/// Centres labels on one line and shifts them to stay between its ends; leaves out labels that
/// would touch another.
fn spaced(mut labels: Vec<(f64, String)>, left: f64, right: f64) -> Vec<(f64, String)> {
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut placed = Vec::new();
    let mut free_from = left;
    for (x, text) in labels {
        let half = 0.5 * WIDE_CHARACTER * text.chars().count() as f64;
        let x = x.max(left + half).min(right - half);
        if x - half >= free_from {
            free_from = x + half + 10.0;
            placed.push((x, text));
        }
    }
    placed
}

/// Returns at most four points per pixel column: first, extremes and last. Others would be
/// invisible.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    for column in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        if column.len() <= 4 {
            out.extend_from_slice(column);
            continue;
        }
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (min, max) = (column.iter().min_by(by_y), column.iter().max_by(by_y));
        let mut inner: Vec<(f64, f64)> = min.into_iter().chain(max).copied().collect();
        inner.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.extend(
            column
                .first()
                .into_iter()
                .chain(&inner)
                .chain(column.last()),
        );
    }
    out
}

/// Shades behind the curves of a panel: columns of equal width over its horizontal range, with
/// levels from 0 (nothing) to 7 at equal steps of its vertical range.
#[derive(Clone, Debug)]
pub struct Shades {
    /// Meaning of the shades, for the key.
    pub name: String,
    pub columns: Vec<Vec<u8>>,
}

impl Shades {
    /// Draws the shades between the left and right edge, upwards from `lower`, one path per level.
    fn draw(&self, svg: &mut Svg, [left, right]: [f64; 2], [lower, upper]: [f64; 2]) {
        let width = (right - left) / self.columns.len().max(1) as f64;
        for level in 1..=7 {
            let mut d = String::new();
            for (at, column) in self.columns.iter().enumerate() {
                let height = (lower - upper) / column.len().max(1) as f64;
                let mut row = 0;
                for run in column.chunk_by(|a, b| (*a == level) == (*b == level)) {
                    let (begin, length) = (row, run.len());
                    row += length;
                    if run[0] != level {
                        continue;
                    }
                    let (x, y) = (left + width * at as f64, lower - height * begin as f64);
                    let tall = height * length as f64;
                    let _ = write!(d, "M{x:.1} {y:.1}h{width:.2}v{:.1}h-{width:.2}z", -tall);
                }
            }
            shade(svg, &d, level);
        }
    }
}

fn shade(svg: &mut Svg, shape: &str, level: u8) {
    let opacity = f64::from(level) / 9.0;
    svg.push(&format!(
        "<path d=\"{shape}\" class=\"shade\" fill-opacity=\"{opacity:.2}\"/>"
    ));
}

/// Style of a curve. A number selects the colour, the dashes and the marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    Line(usize),
    Marked(usize),
    /// Only dots, in the colour of this number.
    Dots(usize),
    /// Measured samples: thin and grey.
    Data,
    /// Reference to compare a curve with, such as a bound: black and dotted.
    Reference,
    /// Shades behind the curves, in the key.
    Shades,
}

impl Look {
    fn class(self) -> String {
        match self {
            Self::Line(number) => format!("c{} d{}", number % 4, number % 4),
            Self::Marked(number) => format!("c{} d{}", number % 4, number / 4),
            Self::Dots(number) => format!("dots c{}", number % 4),
            Self::Data => "data".into(),
            Self::Reference => "reference".into(),
            Self::Shades => "shade".into(),
        }
    }

    /// Returns a marker's vertices relative to its centre, as alternating x and y, and its class.
    fn marker(self) -> Option<(&'static [f64], String)> {
        const SHAPES: [&[f64]; 4] = [
            &[-3.2, -3.2, 3.2, -3.2, 3.2, 3.2, -3.2, 3.2, -3.2, -3.2],
            &[0.0, -4.4, 4.2, 3.2, -4.2, 3.2, 0.0, -4.4],
            &[0.0, -4.8, 4.8, 0.0, 0.0, 4.8, -4.8, 0.0, 0.0, -4.8],
            &[-3.5, -3.5, 3.5, 3.5, 0.0, 0.0, -3.5, 3.5, 3.5, -3.5],
        ];
        match self {
            Self::Marked(number) => Some((SHAPES[number % 4], format!("c{}", number % 4))),
            _ => None,
        }
    }
}

#[derive(Clone, Debug)]
pub struct Curve {
    pub name: String,
    pub look: Look,
    pub points: Vec<(f64, f64)>,
}

/// Scale of one side of a panel; without a range it spans the drawn values.
#[derive(Clone, Debug, Default)]
pub struct Scale {
    pub label: String,
    pub is_log: bool,
    pub range: Option<(f64, f64)>,
    /// Ticks by name instead of round numbers.
    pub names: Vec<(f64, String)>,
}

impl Scale {
    /// Makes an axis from the pixel `from` to the pixel `to`.
    fn axis(&self, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let usable = values.filter(|value| value.is_finite() && (!self.is_log || *value > 0.0));
        let (min, max) = usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| {
            (value.min(min), value.max(max))
        });
        let found = match (self.is_log, min < max) {
            (true, true) => (0.9 * min, 1.1 * max),
            (false, true) => (min - 0.05 * (max - min), max + 0.05 * (max - min)),
            (_, false) => (1.0, 10.0),
        };
        Axis {
            range: self.range.unwrap_or(found),
            at: (from, to),
            is_log: self.is_log,
        }
    }

    fn ticks(&self, axis: &Axis, wanted: u32) -> Vec<(f64, String)> {
        if self.names.is_empty() {
            axis.ticks(wanted)
        } else {
            self.names.clone()
        }
    }
}

/// Curves over one pair of axes.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    pub title: String,
    pub x: Scale,
    pub y: Scale,
    pub curves: Vec<Curve>,
    pub shades: Option<Shades>,
}

const CHART_WIDTH: f64 = 940.0;
const EDGES: (f64, f64) = (74.0, 910.0);
const PLOT_HEIGHT: f64 = 250.0;
const KEY_ROW: f64 = 20.0;

impl Panel {
    /// Lays out the key, row by row.
    fn key(&self) -> Vec<Vec<KeyEntry<'_>>> {
        let mut rows = vec![Vec::new()];
        let mut x = EDGES.0;
        let curves = self.curves.iter().filter(|curve| !curve.name.is_empty());
        let shades = self
            .shades
            .iter()
            .map(|shades| (Look::Shades, &shades.name));
        for (look, name) in curves.map(|curve| (curve.look, &curve.name)).chain(shades) {
            let width = 58.0 + CHARACTER * name.chars().count() as f64;
            if x + width > EDGES.1 + 20.0 && x > EDGES.0 {
                rows.push(Vec::new());
                x = EDGES.0;
            }
            if let Some(row) = rows.last_mut() {
                row.push(KeyEntry { x, look, name });
            }
            x += width;
        }
        rows
    }

    /// Returns the height of the panel with its title and its key.
    fn height(&self) -> f64 {
        PLOT_HEIGHT + 108.0 + KEY_ROW * self.key().len() as f64
    }

    fn draw(&self, svg: &mut Svg, top: f64) {
        let (left, right) = EDGES;
        let (upper, lower) = (top + 56.0, top + 56.0 + PLOT_HEIGHT);
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let x = self.x.axis(points().map(|point| point.0), left, right);
        let y = self.y.axis(points().map(|point| point.1), lower, upper);
        if let Some(shades) = &self.shades {
            shades.draw(svg, [left, right], [lower, upper]);
        }
        svg.text([24.0, top + 28.0], "start", "title", &self.title);
        svg.text([24.0, upper - 10.0], "start", "small", &self.y.label);
        for (value, label) in self.y.ticks(&y, 6) {
            let at = y.place(value);
            svg.line([(left, at), (right, at)], "grid");
            svg.text([left - 7.0, at + 4.0], "end", "small", &label);
        }
        let ticks = self.x.ticks(&x, 8).into_iter();
        let ticks: Vec<(f64, String)> = ticks
            .map(|(value, label)| (x.place(value), label))
            .collect();
        for (at, _) in &ticks {
            svg.line([(*at, lower), (*at, lower + 4.0)], "axis");
        }
        for (at, label) in spaced(ticks, left - 24.0, right + 24.0) {
            svg.text([at, lower + 18.0], "middle", "small", &label);
        }
        svg.line([(left, lower), (right, lower)], "axis");
        svg.line([(left, lower), (left, upper)], "axis");
        svg.text(
            [0.5 * (left + right), lower + 36.0],
            "middle",
            "small",
            &self.x.label,
        );
        for Curve { look, points, .. } in &self.curves {
            let is_seen = |(_, y): &&(f64, f64)| !self.y.is_log || *y > 0.0;
            let place = |(a, b): &(f64, f64)| (x.place(*a), y.place(*b).clamp(upper, lower));
            let placed: Vec<(f64, f64)> = points.iter().filter(is_seen).map(place).collect();
            match look {
                Look::Dots(_) => svg.dots(&placed, &look.class()),
                _ => svg.path(&thinned(&placed), &look.class()),
            }
            placed.iter().for_each(|(x, y)| marker(svg, *look, *x, *y));
        }
        for (row, entries) in self.key().into_iter().enumerate() {
            let base = lower + 62.0 + KEY_ROW * row as f64;
            for KeyEntry { x, look, name } in entries {
                let ends = [(x, base - 4.0), (x + 28.0, base - 4.0)];
                match look {
                    Look::Dots(_) => svg.dots(&[(x + 14.0, base - 4.0)], &look.class()),
                    Look::Shades => {
                        for (at, level) in [1, 4, 7].into_iter().enumerate() {
                            let left = x + 9.0 * at as f64;
                            shade(svg, &format!("M{left:.1} {base:.1}h9v-10h-9z"), level);
                        }
                    }
                    _ => svg.line(ends, &look.class()),
                }
                marker(svg, look, x + 14.0, base - 4.0);
                svg.text([x + 35.0, base], "start", "small", name);
            }
        }
    }
}

/// Entry of the key: a sample of the curve, and its name.
struct KeyEntry<'a> {
    x: f64,
    look: Look,
    name: &'a str,
}

fn marker(svg: &mut Svg, look: Look, x: f64, y: f64) {
    if let Some((shape, class)) = look.marker() {
        let corners = shape.chunks_exact(2).map(|d| (x + d[0], y + d[1]));
        let corners: Vec<(f64, f64)> = corners.collect();
        svg.path(&corners, &class);
    }
}

pub fn chart(title: &str, panels: &[Panel]) -> String {
    let height: f64 = panels.iter().map(Panel::height).sum();
    let mut svg = Svg::new(height, title);
    let mut top = 0.0;
    for panel in panels {
        panel.draw(&mut svg, top);
        top += panel.height();
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new(10.0, "a<b");
        svg.text([1.0, 2.0], "end", "label", "R&D");
        let text = svg.finish();
        assert!(
            text.contains("<title>a&lt;b</title>") && text.contains(">R&amp;D</text>"),
            "{text}"
        );
    }

    #[test]
    fn nice_numbers() {
        assert_eq!((nice(0.026), nice(7.0), nice(1.0)), (0.02, 5.0, 1.0));
    }

    #[test]
    fn labels_do_not_touch() {
        let labels = [(5.0, "contact"), (12.0, "slide"), (300.0, "release")];
        let labels = labels.map(|(x, text)| (x, text.to_owned()));
        let placed = spaced(labels.into(), 0.0, 310.0);
        let names: Vec<&str> = placed.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(names, ["contact", "release"]);
        assert!(placed[1].0 < 300.0);
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let points = (0..1000).map(|i| (f64::from(i) * 0.01, f64::from(i % 97)));
        let thin = thinned(&points.collect::<Vec<_>>());
        assert!(thin.len() <= 40);
        assert!(thin.iter().any(|(_, y)| *y == 96.0) && thin.iter().any(|(_, y)| *y == 0.0));
    }

    #[test]
    fn ticks_are_round_and_within() {
        let axis = |range, is_log| Axis {
            range,
            at: (100.0, 0.0),
            is_log,
        };
        let labels = |axis: Axis| {
            axis.ticks(5)
                .into_iter()
                .map(|tick| tick.1)
                .collect::<Vec<_>>()
        };
        let even = axis((-0.3, 1.0), false);
        assert_eq!(
            labels(even),
            ["-0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert!((even.place(0.35) - 50.0).abs() < 1e-9);
        let decades = axis((0.05, 5.0), true);
        assert_eq!(
            labels(decades),
            ["0.05", "0.1", "0.2", "0.5", "1", "2", "5"]
        );
        assert!((decades.place(0.5) - 50.0).abs() < 1e-9);
        assert_eq!(
            labels(axis((1e3, 1e8), true)).last().map(String::as_str),
            Some("1e8")
        );
    }

    #[test]
    fn a_chart_has_every_curve_and_no_place_that_is_no_number() {
        let curve = |name: &str, look, points: &[(f64, f64)]| Curve {
            name: name.into(),
            look,
            points: points.into(),
        };
        let panel = Panel {
            y: Scale {
                is_log: true,
                ..Scale::default()
            },
            curves: vec![
                curve(
                    "one",
                    Look::Marked(0),
                    &[(1.0, 2.0), (2.0, 0.0), (3.0, 4.0)],
                ),
                curve("none", Look::Reference, &[]),
            ],
            ..Panel::default()
        };
        let svg = chart("a chart", &[panel, Panel::default()]);
        assert!(svg.contains(">one</text>") && svg.contains(">none</text>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
