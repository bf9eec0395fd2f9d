//! Places in the picture, in pixels.

use crate::svg::{Anchor, Svg};
use ridgetone_proto::settings::TAXELS;

pub const STRIP: f64 = 46.0;
/// Baseline of the labels above the strips.
pub const LABELS_Y: f64 = 82.0;
/// Top of the first strip.
pub const STRIPS_Y: f64 = 98.0;
/// Bottom of the last one.
pub const STRIPS_END_Y: f64 = STRIPS_Y + STRIP * TAXELS as f64;

/// Width of a character of a label, rounded up.
const CHARACTER: f64 = 7.0;

/// A part of the picture with a time axis of its own.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    pub left: f64,
    pub right: f64,
}

impl Panel {
    /// Place of a time on the panel's axis from `from_s` to `to_s`.
    pub fn x(&self, t_s: f64, from_s: f64, to_s: f64) -> f64 {
        self.left + (self.right - self.left) * (t_s - from_s) / (to_s - from_s)
    }

    pub fn middle(&self) -> f64 {
        0.5 * (self.left + self.right)
    }
}

/// Centred labels on one line, moved into the panel at its ends; a label that would touch another
/// is left out.
pub fn spaced(mut labels: Vec<(f64, String)>, panel: Panel) -> Vec<(f64, String)> {
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut placed = Vec::new();
    let mut free_from = panel.left;
    for (x, text) in labels {
        let half = 0.5 * CHARACTER * text.chars().count() as f64;
        let x = x.max(panel.left + half).min(panel.right - half);
        if x - half >= free_from {
            free_from = x + half + 10.0;
            placed.push((x, text));
        }
    }
    placed
}

/// The greatest of 1, 2, 5 times a power of ten that is not above `value`.
pub fn nice(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let digit = if value >= 5.0 * power {
        5.0
    } else if value >= 2.0 * power {
        2.0
    } else {
        1.0
    };
    digit * power
}

/// At most four points for each pixel column: first, extremes and last. The others are invisible.
pub fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    for column in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        if column.len() <= 4 {
            out.extend_from_slice(column);
            continue;
        }
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (least, greatest) = (column.iter().min_by(by_y), column.iter().max_by(by_y));
        let mut inner: Vec<(f64, f64)> = least.into_iter().chain(greatest).copied().collect();
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

pub fn axis(svg: &mut Svg, panel: Panel, from_s: f64, to_s: f64, label: &str) {
    let step_s = nice((to_s - from_s) / 4.0);
    let decimals = if step_s < 0.1 {
        2
    } else {
        usize::from(step_s < 1.0)
    };
    svg.line(
        (panel.left, STRIPS_END_Y),
        (panel.right, STRIPS_END_Y),
        "axis",
    );
    let first = (from_s / step_s).ceil() as i64;
    for tick in first..=(to_s / step_s).floor() as i64 {
        let t_s = tick as f64 * step_s;
        let x = panel.x(t_s, from_s, to_s);
        svg.line((x, STRIPS_END_Y), (x, STRIPS_END_Y + 5.0), "axis");
        svg.text(
            x,
            STRIPS_END_Y + 18.0,
            Anchor::Middle,
            "small",
            &format!("{t_s:.decimals$}"),
        );
    }
    svg.text(
        panel.middle(),
        STRIPS_END_Y + 34.0,
        Anchor::Middle,
        "small",
        label,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nice_numbers() {
        assert_eq!((nice(0.026), nice(7.0), nice(1.0)), (0.02, 5.0, 1.0));
    }

    #[test]
    fn labels_do_not_touch() {
        let labels = [(5.0, "contact"), (12.0, "slide"), (300.0, "release")];
        let labels = labels.map(|(x, text)| (x, text.to_owned()));
        let placed = spaced(
            labels.into(),
            Panel {
                left: 0.0,
                right: 310.0,
            },
        );
        assert_eq!(
            placed
                .iter()
                .map(|(_, text)| text.as_str())
                .collect::<Vec<_>>(),
            ["contact", "release"]
        );
        assert!(placed[1].0 < 300.0);
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let points: Vec<(f64, f64)> = (0..1000)
            .map(|i| (f64::from(i) * 0.01, f64::from(i % 97)))
            .collect();
        let thin = thinned(&points);
        assert!(thin.len() <= 40);
        assert!(thin.iter().any(|(_, y)| *y == 96.0) && thin.iter().any(|(_, y)| *y == 0.0));
    }
}
