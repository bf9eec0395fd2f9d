//! A strip for each channel: the whole part with its residual, a few periods close up with the fit,
//! and what the tone is of it.

use super::channels::{Channel, Fitted, Range};
use crate::chart::{Anchor, Axis, CHART_WIDTH, Svg, thinned};
use crate::digits::significant;
use crate::table_fit::{ChannelResult, TableFit};
use crate::tone::Domain;

/// Top of the first strip.
pub const STRIPS_Y: f64 = 106.0;
/// Below the last strip: axes and the key.
const BELOW: f64 = 78.0;

const ALL: Range = Range {
    from: 150.0,
    to: 500.0,
};
const CLOSE: Range = Range {
    from: 530.0,
    to: 786.0,
};
const AMPLITUDE_X: f64 = 862.0;
const SHARE: (f64, f64) = (876.0, 916.0);

/// Share of a strip's height that its channel takes.
const FILLED: f64 = 0.84;
/// Most samples of a channel in the close-up that are drawn as dots.
const DOTS_MAX: usize = 240;
/// Most characters of a name.
const NAME_MAX: usize = 18;

/// Height of a strip: few channels have more room.
fn strip(channels: usize) -> f64 {
    (720.0 / channels.max(1) as f64).clamp(46.0, 130.0)
}

pub fn height(channels: usize) -> f64 {
    strip(channels) * channels as f64 + BELOW
}

/// Draws the strips and what is above and below them.
pub fn strips(svg: &mut Svg, fitted: &Fitted, fit: &TableFit) {
    let strip = strip(fitted.channels.len());
    let bottom = STRIPS_Y + strip * fitted.channels.len() as f64;
    let above = |svg: &mut Svg, x: f64, anchor: Anchor, text: &str| {
        svg.text([x, STRIPS_Y - 8.0], anchor, "head", text);
    };
    above(svg, 24.0, Anchor::Start, "channel");
    above(svg, ALL.from, Anchor::Start, "each to its own scale");
    if let Some(close) = fitted.close {
        above(svg, CLOSE.from, Anchor::Start, "close up, with the fit");
        above(svg, AMPLITUDE_X, Anchor::End, "amplitude");
        above(svg, SHARE.1, Anchor::End, "share");
        axis(svg, axis_of(close, CLOSE), bottom, fit.domain);
    }
    let all = axis_of(fitted.range(), ALL);
    for (number, (channel, found)) in fitted.channels.iter().zip(&fit.channels).enumerate() {
        let top = STRIPS_Y + strip * number as f64;
        if number % 2 == 0 {
            svg.rect([16.0, top], [CHART_WIDTH - 32.0, strip], "odd");
        }
        let strip = Strip {
            channel,
            at: &fitted.at,
            middle: top + 0.5 * strip,
            height: FILLED * strip,
        };
        strip.whole(svg, all);
        strip.names(svg, found);
        if let Some(close) = fitted.close {
            strip.close_up(svg, close);
        }
    }
    axis(svg, all, bottom, fit.domain);
    key(svg, bottom + 60.0, fitted.close.is_some());
}

/// A channel and its place.
struct Strip<'a> {
    channel: &'a Channel,
    at: &'a [f64],
    middle: f64,
    height: f64,
}

/// The middle of some values, and the pixels of one of their unit.
struct Fill {
    middle: f64,
    pixels: f64,
}

impl Strip<'_> {
    fn fill(&self, values: impl Iterator<Item = f64>) -> Fill {
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| {
            (v.min(least), v.max(most))
        });
        match least < most {
            true => Fill {
                middle: 0.5 * (least + most),
                pixels: self.height / (most - least),
            },
            false => Fill {
                middle: if least.is_finite() { least } else { 0.0 },
                pixels: 1.0,
            },
        }
    }

    fn y(&self, fill: &Fill, value: f64) -> f64 {
        self.middle - fill.pixels * (value - fill.middle)
    }

    fn readings(&self) -> impl Iterator<Item = (f64, f64)> {
        let known = self.at.iter().zip(&self.channel.readings);
        known.filter_map(|(at, value)| Some((*at, f64::from((*value)?))))
    }

    /// All readings, and what is left of them to the same scale.
    fn whole(&self, svg: &mut Svg, axis: Axis) {
        let left = self.channel.residual.iter().flatten();
        let left: Vec<(f64, f64)> = self.at.iter().copied().zip(left.copied()).collect();
        let most = left.iter().map(|(_, left)| left.abs()).fold(0.0, f64::max);
        let mut fill = self.fill(self.readings().map(|(_, value)| value));
        if most > 0.0 {
            fill.pixels = fill.pixels.min(0.5 * self.height / most);
        }
        let place = |(at, value): (f64, f64)| (axis.place(at), self.y(&fill, value));
        let points: Vec<(f64, f64)> = self.readings().map(place).collect();
        svg.path(&thinned(&points), "data");
        // Zero, where a reading is missing, is not a residual.
        let known = left.iter().zip(&self.channel.readings);
        let known = known.filter(|(_, reading)| reading.is_some());
        let points: Vec<(f64, f64)> = known
            .map(|((at, left), _)| (axis.place(*at), self.middle - fill.pixels * left))
            .collect();
        if !points.is_empty() {
            svg.path(&thinned(&points), "c0");
        }
    }

    fn close_up(&self, svg: &mut Svg, close: Range) {
        let axis = axis_of(close, CLOSE);
        let inside: Vec<(f64, f64)> = self
            .readings()
            .filter(|(at, _)| close.contains(*at))
            .collect();
        let curve = &self.channel.curve;
        let fill = self.fill(inside.iter().chain(curve).map(|(_, value)| *value));
        let place = |(at, value): &(f64, f64)| (axis.place(*at), self.y(&fill, *value));
        let dots: Vec<(f64, f64)> = inside.iter().map(place).collect();
        // Dots that would run together are a line.
        match dots.len() > DOTS_MAX {
            true => svg.path(&thinned(&dots), "data"),
            false => svg.dots(&dots, "dot"),
        }
        let line: Vec<(f64, f64)> = curve.iter().map(place).collect();
        if !line.is_empty() {
            svg.path(&line, "fit");
        }
    }

    fn names(&self, svg: &mut Svg, found: &ChannelResult) {
        let middle = self.middle + 4.0;
        svg.text(
            [24.0, middle],
            Anchor::Start,
            "label",
            &shortened(&self.channel.name),
        );
        let below = |svg: &mut Svg, text: &str| {
            svg.text([24.0, middle + 14.0], Anchor::Start, "small", text);
        };
        if !found.usable {
            below(svg, "not usable");
        } else if self.channel.is_clipped {
            below(svg, "clipped");
        }
        if let Some(amplitude) = found.amplitude {
            let amplitude = significant(amplitude, 3);
            svg.text([AMPLITUDE_X, middle], Anchor::End, "label", &amplitude);
        }
        if let Some(share) = self.channel.share {
            let text = format!(
                "{} %",
                significant(100.0 * share, if share < 0.1 { 2 } else { 3 })
            );
            svg.text([SHARE.1, middle - 4.0], Anchor::End, "label", &text);
            let (from, full) = (SHARE.0, SHARE.1 - SHARE.0);
            let y = middle + 6.0;
            svg.line([(from, y), (SHARE.1, y)], "grid");
            svg.line([(from, y), (from + full * share, y)], "window");
        }
    }
}

fn axis_of(range: Range, at: Range) -> Axis {
    Axis {
        range: (range.from, range.to),
        at: (at.from, at.to),
        is_log: false,
    }
}

/// A name that is too long keeps its end, where units and numbers are.
fn shortened(name: &str) -> String {
    let count = name.chars().count();
    if count <= NAME_MAX {
        return name.to_owned();
    }
    let end: String = name.chars().skip(count + 1 - NAME_MAX).collect();
    format!("\u{2026}{end}")
}

/// An axis with round values under the strips.
fn axis(svg: &mut Svg, axis: Axis, bottom: f64, domain: Domain) {
    let (left, right) = axis.at;
    svg.line([(left, bottom), (right, bottom)], "axis");
    for (value, label) in axis.ticks(4) {
        let x = axis.place(value);
        svg.line([(x, bottom), (x, bottom + 5.0)], "axis");
        svg.text([x, bottom + 18.0], Anchor::Middle, "small", &label);
    }
    let label = match domain {
        Domain::Time => "time, s",
        Domain::Position => "position, mm",
    };
    svg.text(
        [0.5 * (left + right), bottom + 34.0],
        Anchor::Middle,
        "small",
        label,
    );
}

fn key(svg: &mut Svg, y: f64, has_tone: bool) {
    let mut entry = |x: f64, class: &str, text: &str| {
        svg.line([(x, y - 4.0), (x + 24.0, y - 4.0)], class);
        svg.text([x + 32.0, y], Anchor::Start, "small", text);
    };
    entry(ALL.from, "data", "readings");
    if has_tone {
        entry(ALL.from + 110.0, "c0", "residual, to the same scale");
        entry(CLOSE.from + 90.0, "fit", "fit");
        svg.dots(&[(CLOSE.from, y - 4.0), (CLOSE.from + 8.0, y - 4.0)], "dot");
        svg.text([CLOSE.from + 18.0, y], Anchor::Start, "small", "readings");
        let share = "share: power that the fit explains";
        svg.text([SHARE.1, y], Anchor::End, "small", share);
    }
}
