//! Style, frames with axes, markers and keys of all pictures; legible on light and on dark.

use crate::axis::{Axis, Linear};
use ridgetone_host::picture::layout::thinned;
use ridgetone_host::svg::{Anchor, Svg};

/// Width of every picture, pixels.
const WIDTH: f64 = 960.0;

/// CSS of all pictures. Colours are those of Okabe and Ito, lighter on dark. Dash, marker or place
/// differ too.
const STYLE: &str = "svg text{font:12px system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:#222}\
svg .title{font-size:14px;font-weight:600}svg .small{font-size:11px;fill:#555}svg .cell{font-size:12px}\
svg path{fill:none}svg .card{fill:#fff;stroke:#bbb}svg .axis{stroke:#555}svg .grid{stroke:#e2e2e2}\
svg .data{stroke:#667;stroke-width:.9;stroke-linejoin:round}\
svg .one{stroke:#0064a4;stroke-width:1.4;stroke-linejoin:round}\
svg .two{stroke:#c4480a;stroke-width:1.4;stroke-dasharray:5 3;stroke-linejoin:round}\
svg .three{stroke:#00795a;stroke-width:1.6;stroke-dasharray:1.5 3;stroke-linecap:round}\
svg .dot{stroke:#667;stroke-width:2.6;stroke-linecap:round}\
svg .fillone{fill:#0064a4}svg .filltwo{fill:#c4480a}svg .fillthree{fill:#00795a}svg .hollow{fill:#fff}\
svg .bar{fill:#9fb4c7}svg .mark{stroke:#a01050;stroke-width:1.3;stroke-dasharray:5 3}\
svg .truth{stroke:#222;stroke-width:1.2;stroke-dasharray:2 3}svg .slide{fill:#cfe3f5;fill-opacity:.6}\
svg .band{fill:#888;fill-opacity:.18}svg .plus{fill:#e07b27}svg .minus{fill:#2f7fc0}svg .box{stroke:#999;fill:none}\
@media(prefers-color-scheme:dark){svg text{fill:#e4e6ea}svg .small{fill:#b4b8c0}svg .card{fill:#16191e;stroke:#444}\
svg .axis{stroke:#aab}svg .grid{stroke:#2c3138}svg .data,svg .dot{stroke:#99a3b3}svg .one{stroke:#6bb8f0}\
svg .two{stroke:#ff9a5c}svg .three{stroke:#4fd0a4}svg .fillone{fill:#6bb8f0}svg .filltwo{fill:#ff9a5c}\
svg .fillthree{fill:#4fd0a4}svg .hollow{fill:#16191e}svg .bar{fill:#51677c}svg .mark{stroke:#ff7fb0}\
svg .truth{stroke:#eee}svg .slide{fill:#274a68}svg .band{fill:#aaa;fill-opacity:.2}svg .box{stroke:#777}}\
svg .solid{stroke-dasharray:none;stroke-width:1.4}";

/// A picture of some height, its first line a title.
pub fn picture(height: f64, title: &str) -> Svg {
    Svg::new(WIDTH, height, title, STYLE)
}

/// A frame with an axis along each side.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub x: Linear,
    pub y: Linear,
}

impl Frame {
    /// Between left, top, right and bottom edges in pixels, for some ranges of x and y.
    pub fn new(
        (left, top, right, bottom): (f64, f64, f64, f64),
        x: (f64, f64),
        y: (f64, f64),
    ) -> Self {
        Self {
            x: Linear {
                range: x,
                at: (left, right),
            },
            y: Linear {
                range: y,
                at: (bottom, top),
            },
        }
    }

    pub fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.place(x), self.y.place(y))
    }

    /// Ticks with labels at both axes, thin lines across. The axis of x has its label below, where
    /// it has one.
    pub fn axes(&self, svg: &mut Svg, ticks: (u32, u32), x_label: &str, y_label: &str) {
        let ((left, right), (bottom, top)) = (self.x.at, self.y.at);
        self.grid(svg, ticks.1);
        for (value, label) in self.x.ticks(ticks.0) {
            let x = self.x.place(value);
            svg.line((x, bottom), (x, bottom + 4.0), "axis");
            if !x_label.is_empty() {
                svg.text(x, bottom + 17.0, Anchor::Middle, "small", &label);
            }
        }
        svg.line((left, bottom), (right, bottom), "axis");
        svg.line((left, bottom), (left, top), "axis");
        if !x_label.is_empty() {
            svg.text(
                0.5 * (left + right),
                bottom + 34.0,
                Anchor::Middle,
                "small",
                x_label,
            );
        }
        svg.text(left - 40.0, top - 9.0, Anchor::Start, "small", y_label);
    }

    /// About `ticks` thin lines across, with labels at the left.
    pub fn grid(&self, svg: &mut Svg, ticks: u32) {
        let (left, right) = self.x.at;
        for (value, label) in self.y.ticks(ticks) {
            let y = self.y.place(value);
            svg.line((left, y), (right, y), "grid");
            svg.text(left - 7.0, y + 4.0, Anchor::End, "small", &label);
        }
    }

    /// A curve, thinned to what can be seen.
    pub fn curve(&self, svg: &mut Svg, points: &[(f64, f64)], class: &str) {
        let placed: Vec<(f64, f64)> = points.iter().map(|point| self.at(*point)).collect();
        svg.path(&thinned(&placed), class);
    }

    /// A line across at some x, from the bottom to the top.
    pub fn upright(&self, svg: &mut Svg, x: f64, class: &str) {
        let x = self.x.place(x);
        svg.line((x, self.y.at.0), (x, self.y.at.1), class);
    }

    /// The area between two x, from the bottom to the top.
    pub fn area(&self, svg: &mut Svg, (from, to): (f64, f64), class: &str) {
        let (left, right) = (self.x.place(from), self.x.place(to));
        svg.rect(
            left,
            self.y.at.1,
            right - left,
            self.y.at.0 - self.y.at.1,
            class,
        );
    }
}

/// Powers of ten with their labels, in percent, and thin lines across.
pub fn log_axis(svg: &mut Svg, axis: &Axis, (left, right): (f64, f64)) {
    for power in axis.ticks() {
        let value = 10f64.powi(power);
        let (y, decimals) = (axis.place(value), usize::try_from(-power).unwrap_or(0));
        svg.line((left, y), (right, y), "grid");
        svg.text(
            left - 7.0,
            y + 4.0,
            Anchor::End,
            "small",
            &format!("{value:.decimals$}"),
        );
    }
    svg.line((left, axis.at.0), (left, axis.at.1), "axis");
    svg.line((left, axis.at.0), (right, axis.at.0), "axis");
}

/// Least and greatest of some values, with a margin.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| {
        (v.min(l), v.max(m))
    });
    if least > most {
        return (-1.0, 1.0);
    }
    let margin = 0.06 * (most - least).max(1e-6);
    (least - margin, most + margin)
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Square,
    /// A triangle that stands on its base.
    Triangle,
    Diamond,
}

/// A marker, filled or hollow, of a line's class.
pub fn marker(svg: &mut Svg, shape: Shape, (x, y): (f64, f64), class: &str) {
    let corners: &[(f64, f64)] = match shape {
        Shape::Square => &[
            (-3.2, -3.2),
            (3.2, -3.2),
            (3.2, 3.2),
            (-3.2, 3.2),
            (-3.2, -3.2),
        ],
        Shape::Triangle => &[(0.0, -4.4), (4.2, 3.2), (-4.2, 3.2), (0.0, -4.4)],
        Shape::Diamond => &[
            (0.0, -4.8),
            (4.8, 0.0),
            (0.0, 4.8),
            (-4.8, 0.0),
            (0.0, -4.8),
        ],
    };
    let points: Vec<(f64, f64)> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    svg.path(&points, class);
}

/// What stands in front of an entry of a key, with its class.
#[derive(Clone, Copy, Debug)]
pub enum Sample {
    Line(&'static str),
    Area(&'static str),
    /// A line with a marker on it: classes of line and marker.
    Marked(&'static str, Shape, &'static str),
    Marker(Shape, &'static str),
    Dots(&'static str),
}

/// A key in one line from `x` on; gives where it ends.
pub fn key(svg: &mut Svg, mut x: f64, y: f64, entries: &[(Sample, &str)]) -> f64 {
    for (sample, text) in entries {
        let middle = y - 4.0;
        match *sample {
            Sample::Line(class) => svg.line((x, middle), (x + 26.0, middle), class),
            Sample::Area(class) => svg.rect(x, middle - 6.0, 26.0, 12.0, class),
            Sample::Marked(line, shape, class) => {
                svg.line((x, middle), (x + 26.0, middle), line);
                marker(svg, shape, (x + 13.0, middle), class);
            }
            Sample::Marker(shape, class) => marker(svg, shape, (x + 13.0, middle), class),
            Sample::Dots(class) => svg.dots(
                &[(x + 4.0, middle), (x + 13.0, middle), (x + 22.0, middle)],
                class,
            ),
        }
        svg.text(x + 32.0, y, Anchor::Start, "small", text);
        // That many pixels a character are on the safe side.
        x += 32.0 + 6.4 * text.chars().count() as f64 + 20.0;
    }
    x
}

/// What the paper calls a taxel.
pub fn taxel_name(taxel: usize) -> String {
    format!("MEMS {}, piezoresistor {}", taxel / 4 + 1, taxel % 4 + 1)
}
