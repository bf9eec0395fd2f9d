//! Draws a row for each channel: all of its readings, and a close-up of a few periods with the
//! fitted curve.
//!
//! Position and label distinguish the channels, dots and line distinguish readings and fit; colour
//! only helps.

use super::{Axis, CHARACTER, Panel, Svg, WIDE_CHARACTER, nice, spaced, thinned};
use crate::digits::significant;
use std::ops::RangeInclusive;

/// Top edges of the first row, and of the phase labels above it, pixels.
const TOP: f64 = 106.0;
const LABELS_Y: f64 = TOP - 18.0;
/// Room below the last row, for axes and key.
const BELOW: f64 = 78.0;
/// Edges of the picture's content.
const LEFT: f64 = 24.0;
const RIGHT: f64 = super::CHART_WIDTH - 24.0;
/// Widths of the close-up, of the amplitudes and of the bars of explained power.
const CLOSE: f64 = 256.0;
const AMPLITUDE: f64 = 76.0;
const EXPLAINED: f64 = 54.0;
const BAR: f64 = 40.0;
/// Gap between the readings and the close-up.
const GAP: f64 = 30.0;
/// Fraction of a row's height that its curves fill.
const FILLED: f64 = 0.84;
/// Maximum number of readings that a close-up draws as dots: more would run together.
const DOTS_MAX: usize = 240;
/// Longest name, characters.
const NAME_MAX: usize = 18;

/// Values over seconds or millimetres.
pub type Points = Vec<(f64, f64)>;

#[derive(Clone, Debug, Default)]
pub struct Strip {
    pub name: String,
    /// A word below the name.
    pub note: &'static str,
    pub readings: Points,
    /// Readings less the fit.
    pub residual: Points,
    /// The fitted curve in the close-up.
    pub curve: Points,
    pub amplitude: String,
    /// Fraction of the readings' power that the fit explains.
    pub explained: Option<f64>,
}

/// Phases of a touch, drawn across all rows.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    /// Moments with their labels.
    pub marks: Vec<(f64, String)>,
    pub slides: Vec<RangeInclusive<f64>>,
    pub window: Option<RangeInclusive<f64>>,
}

#[derive(Clone, Debug)]
pub struct Strips {
    pub title: String,
    pub subtitle: String,
    pub warning: Option<String>,
    /// Heading of the rows.
    pub row: &'static str,
    /// Headings of the readings and of the close-up.
    pub headings: [&'static str; 2],
    pub axis: &'static str,
    pub range: RangeInclusive<f64>,
    /// Range of the close-up; `None` without a tone.
    pub close: Option<RangeInclusive<f64>>,
    /// True to draw all channels to one scale in volts; otherwise each has its own scale.
    pub is_in_volts: bool,
    pub phases: Option<Phases>,
    pub strips: Vec<Strip>,
}

struct Column {
    axis: Axis,
    range: RangeInclusive<f64>,
    /// Pixels per volt, if all rows have one scale.
    scale: Option<f64>,
}

impl Strips {
    pub fn picture(&self, panel: Option<&Panel>) -> String {
        let strips_height = TOP + self.row_height() * self.strips.len() as f64 + BELOW;
        let height = strips_height + panel.map_or(0.0, Panel::height);
        let title = format!("{}. {}", self.title, self.subtitle);
        let mut svg = Svg::new(height, &title);
        svg.text([LEFT, 30.0], "start", "title", &self.title);
        svg.text([LEFT, 50.0], "start", "small", &self.subtitle);
        if let Some(warning) = &self.warning {
            svg.text([LEFT, 67.0], "start", "head", warning);
        }
        self.draw(&mut svg);
        if let Some(panel) = panel {
            panel.draw(&mut svg, strips_height);
        }
        svg.finish()
    }

    /// Returns the height of a row, which is larger with fewer channels.
    fn row_height(&self) -> f64 {
        (720.0 / self.strips.len().max(1) as f64).clamp(46.0, 130.0)
    }

    fn bottom(&self) -> f64 {
        TOP + self.row_height() * self.strips.len() as f64
    }

    fn has_explained(&self) -> bool {
        self.strips.iter().any(|strip| strip.explained.is_some())
    }

    fn amplitude_right(&self) -> f64 {
        RIGHT - if self.has_explained() { EXPLAINED } else { 0.0 }
    }

    /// Returns the columns for the readings and for the close-up, if there is one.
    fn columns(&self) -> (Column, Option<Column>) {
        let names = self.strips.iter().map(|strip| shortened(&strip.name));
        let longest = names.map(|name| name.chars().count()).max();
        let longest = longest.unwrap_or_default().max(self.row.len());
        let close_right = self.amplitude_right() - AMPLITUDE;
        let column = |range: &RangeInclusive<f64>, at| {
            let heights = self.strips.iter().map(|strip| {
                let (low, high) = extremes(inside(&strip.readings, range));
                high - low
            });
            let highest = heights.fold(1e-9, f64::max);
            Column {
                axis: Axis {
                    range: (*range.start(), *range.end()),
                    at,
                    is_log: false,
                },
                range: range.clone(),
                scale: self
                    .is_in_volts
                    .then(|| FILLED * self.row_height() / highest),
            }
        };
        let left = LEFT + WIDE_CHARACTER * longest as f64 + 14.0;
        let close = self.close.as_ref();
        let right = close.map_or(RIGHT, |_| close_right - CLOSE - GAP);
        let whole = column(&self.range, (left, right));
        let close = close.map(|range| column(range, (close_right - CLOSE, close_right)));
        (whole, close)
    }

    fn draw(&self, svg: &mut Svg) {
        let (whole, close) = self.columns();
        let above = |svg: &mut Svg, x, anchor, text: &str| {
            svg.text([x, TOP - 8.0], anchor, "head", text);
        };
        for number in (0..self.strips.len()).step_by(2) {
            let top = TOP + self.row_height() * number as f64;
            let size = [RIGHT - LEFT + 16.0, self.row_height()];
            svg.rect([LEFT - 8.0, top], size, "odd");
        }
        above(svg, LEFT, "start", self.row);
        above(svg, whole.axis.at.0, "start", self.headings[0]);
        if let Some(phases) = &self.phases {
            self.phases(svg, phases, &whole.axis);
        }
        self.below(svg, &whole, &self.whole_key());
        if let Some(close) = &close {
            above(svg, close.axis.at.0, "start", self.headings[1]);
            above(svg, self.amplitude_right(), "end", "amplitude");
            self.below(svg, close, &[("dot", "readings"), ("fit", "fit")]);
        }
        if self.has_explained() {
            above(svg, RIGHT, "end", "share");
            let at = [RIGHT, self.bottom() + 60.0];
            svg.text(at, "end", "small", "share: power explained");
        }
        for (number, strip) in self.strips.iter().enumerate() {
            let middle = TOP + self.row_height() * (number as f64 + 0.5);
            self.whole(svg, &whole, strip, middle);
            if let Some(close) = &close {
                self.close_up(svg, close, strip, middle);
            }
            self.labels(svg, strip, middle + 4.0);
        }
    }

    fn whole_key(&self) -> Vec<(&'static str, &'static str)> {
        let mut key = Vec::new();
        if self.phases.is_some() {
            key.push(("window", "window of the fit"));
            key.push(("slide", "sliding phase"));
            key.push(("mark", "contact, release"));
        } else {
            key.push(("data", "readings"));
        }
        if self.strips.iter().any(|strip| !strip.residual.is_empty()) {
            key.push(("c0", "residual, to the same scale"));
        }
        key
    }

    /// Returns the scale in pixels per unit, and the y coordinate of zero, so that the range from
    /// `low` to `high` is centred on `middle`. Without a common scale of the column, the range
    /// fills the row.
    fn scaled(&self, column: &Column, low: f64, high: f64, middle: f64) -> (f64, f64) {
        let own = if high > low {
            FILLED * self.row_height() / (high - low)
        } else {
            1.0
        };
        let pixels = column.scale.unwrap_or(own);
        (pixels, middle + pixels * 0.5 * (low + high))
    }

    fn whole(&self, svg: &mut Svg, column: &Column, strip: &Strip, middle: f64) {
        let (mut low, mut high) = extremes(strip.readings.iter());
        // The residual, which is drawn about zero, must fit into the row as well.
        let max = strip
            .residual
            .iter()
            .fold(0.0, |max: f64, (_, left)| left.abs().max(max));
        let missing = (max - 0.5 * (high - low)).max(0.0);
        (low, high) = (low - missing, high + missing);
        let (pixels, zero) = self.scaled(column, low, high, middle);
        let points = |points: &Points, zero: f64| {
            let at = |(at, value): &(f64, f64)| (column.axis.place(*at), zero - pixels * value);
            thinned(&points.iter().map(at).collect::<Points>())
        };
        svg.path(&points(&strip.readings, zero), "data");
        if !strip.residual.is_empty() {
            svg.path(&points(&strip.residual, middle), "c0");
        }
    }

    fn close_up(&self, svg: &mut Svg, column: &Column, strip: &Strip, middle: f64) {
        let readings = || inside(&strip.readings, &column.range);
        let (low, high) = extremes(readings().chain(&strip.curve));
        let (pixels, zero) = self.scaled(column, low, high, middle);
        let at = |(at, value): &(f64, f64)| (column.axis.place(*at), zero - pixels * value);
        let dots: Points = readings().map(at).collect();
        if dots.len() > DOTS_MAX {
            svg.path(&thinned(&dots), "data");
        } else {
            svg.dots(&dots, "dot");
        }
        if !strip.curve.is_empty() {
            svg.path(&strip.curve.iter().map(at).collect::<Points>(), "fit");
        }
    }

    fn labels(&self, svg: &mut Svg, strip: &Strip, y: f64) {
        svg.text([LEFT, y], "start", "label", &shortened(&strip.name));
        if !strip.note.is_empty() {
            svg.text([LEFT, y + 14.0], "start", "small", strip.note);
        }
        svg.text(
            [self.amplitude_right(), y],
            "end",
            "label",
            &strip.amplitude,
        );
        if let Some(explained) = strip.explained {
            let digits = if explained < 0.1 { 2 } else { 3 };
            let text = format!("{} %", significant(100.0 * explained, digits));
            svg.text([RIGHT, y - 4.0], "end", "label", &text);
            let (from, y) = (RIGHT - BAR, y + 6.0);
            svg.line([(from, y), (RIGHT, y)], "grid");
            svg.line([(from, y), (from + BAR * explained, y)], "window");
        }
    }

    /// Draws contact, slides, fitted window and release, with labels above that do not overlap.
    fn phases(&self, svg: &mut Svg, phases: &Phases, axis: &Axis) {
        let (x, bottom) = (|value: &f64| axis.place(*value), self.bottom());
        for slide in &phases.slides {
            let (from, to) = (x(slide.start()), x(slide.end()));
            svg.rect([from, TOP], [to - from, bottom - TOP], "slide");
        }
        for (at, _) in &phases.marks {
            svg.line([(x(at), TOP - 2.0), (x(at), bottom)], "mark");
        }
        let marks = phases
            .marks
            .iter()
            .map(|(at, label)| (x(at), label.clone()));
        let slides = phases.slides.iter().map(|slide| {
            let (from, to) = (slide.start(), slide.end());
            let middle = 0.5 * (x(from) + x(to));
            (middle, format!("slide {from:.2} to {to:.2} s"))
        });
        let labels = marks.chain(slides).collect();
        for (x, label) in spaced(labels, axis.at.0, axis.at.1) {
            svg.text([x, LABELS_Y], "middle", "label", &label);
        }
        if let Some(window) = &phases.window {
            let (from, to) = (x(window.start()), x(window.end()));
            svg.line([(from, TOP - 3.0), (to, TOP - 3.0)], "window");
            for x in [from, to] {
                svg.line([(x, TOP - 8.0), (x, bottom)], "edge");
            }
        }
    }

    /// Draws an axis with round values under a column, its scale bar if it has one, and its key.
    fn below(&self, svg: &mut Svg, column: &Column, key: &[(&str, &str)]) {
        let ((left, right), bottom) = (column.axis.at, self.bottom());
        svg.line([(left, bottom), (right, bottom)], "axis");
        for (value, label) in column.axis.ticks(4) {
            let x = column.axis.place(value);
            svg.line([(x, bottom), (x, bottom + 5.0)], "axis");
            svg.text([x, bottom + 18.0], "middle", "small", &label);
        }
        let middle = 0.5 * (left + right);
        svg.text([middle, bottom + 34.0], "middle", "small", self.axis);
        let (mut x, y) = (left, bottom + 60.0);
        if let Some(pixels) = column.scale {
            let bar_v = nice(26.0 / pixels);
            svg.line(
                [(x + 4.0, y + 8.0), (x + 4.0, y + 8.0 - bar_v * pixels)],
                "bar",
            );
            let label = format!("{} mV", (bar_v * 1e6).round() * 1e-3);
            svg.text([x + 12.0, y], "start", "small", &label);
            x += 70.0;
        }
        for (class, text) in key {
            match *class {
                "dot" => svg.dots(&[(x + 6.0, y - 4.0), (x + 14.0, y - 4.0)], class),
                "slide" => svg.rect([x, y - 10.0], [24.0, 12.0], class),
                _ => svg.line([(x, y - 4.0), (x + 24.0, y - 4.0)], class),
            }
            svg.text([x + 32.0, y], "start", "small", text);
            x += 50.0 + CHARACTER * text.len() as f64;
        }
    }
}

fn inside<'a>(
    points: &'a Points,
    range: &RangeInclusive<f64>,
) -> impl Iterator<Item = &'a (f64, f64)> {
    points.iter().filter(move |(at, _)| range.contains(at))
}

/// Returns the minimum and maximum value; zeros without a point.
fn extremes<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> (f64, f64) {
    let grow = |ends: Option<(f64, f64)>, (_, value): &(f64, f64)| {
        let (low, high) = ends.unwrap_or((*value, *value));
        Some((low.min(*value), high.max(*value)))
    };
    points.fold(None, grow).unwrap_or_default()
}

/// Shortens a name that is too long, but keeps its end, where units and numbers are.
fn shortened(name: &str) -> String {
    let count = name.chars().count();
    if count <= NAME_MAX {
        return name.to_owned();
    }
    let end: String = name.chars().skip(count + 1 - NAME_MAX).collect();
    format!("\u{2026}{end}")
}
