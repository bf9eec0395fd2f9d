//! The lower half of the trade's picture: error over bound by length of window, in noise of several
//! kinds.

use super::results::{NLS, RIDGETONE};
use crate::axis::Axis;
use crate::noise::{Kind, WINDOWS_S};
use crate::plot::{Sample, Shape, key, log_axis, marker};
use ridgetone_host::svg::{Anchor, Svg};

pub const SHAPES: [Shape; 3] = [Shape::Diamond, Shape::Square, Shape::Triangle];

/// Height of it all, pixels.
pub const HEIGHT: f64 = 330.0;

/// Kinds that are drawn, and what they are called there: a shape each.
const KINDS: [(&str, &str); SHAPES.len()] = [
    ("white", "white"),
    ("pink", "pink"),
    ("pink, the same in all channels", "pink, shared"),
];
/// Classes of lines and of markers of the two methods.
const METHODS: [(&str, &str, &str); 2] = [
    (RIDGETONE, "one", "solid one fillone"),
    (NLS, "two", "solid two filltwo"),
];

/// Draws it from `top` on, between the edges of the picture above.
pub fn draw(svg: &mut Svg, kinds: &[Kind], top: f64, (left, right): (f64, f64)) {
    let (from, to) = (top + 50.0, top + 230.0);
    let title = "RMS error over the bound of the noise's whole covariance, by length of window; noise 20 dB below the tone";
    svg.text(22.0, top + 20.0, Anchor::Start, "title", title);
    let drawn = || {
        KINDS.iter().filter_map(|(name, label)| {
            Some((kinds.iter().find(|kind| kind.name == *name)?, label))
        })
    };
    let of = |kind: &Kind, method: usize| -> Vec<Option<f64>> {
        [&kind.ours, &kind.nls][method]
            .iter()
            .map(|figures| figures.over_bound)
            .collect()
    };
    let all = drawn()
        .flat_map(|(kind, _)| [of(kind, 0), of(kind, 1)])
        .flatten()
        .flatten();
    // An RMS below the bound is luck: few windows.
    let y = Axis::around(all.chain([1.0]), (to, from));
    log_axis(svg, &y, (left, right));
    let place = |n: usize| left + (right - left) * (n as f64 + 0.5) / WINDOWS_S.len() as f64;
    for (n, window_s) in WINDOWS_S.iter().enumerate() {
        svg.text(
            place(n),
            to + 20.0,
            Anchor::Middle,
            "small",
            &format!("{window_s} s"),
        );
    }
    svg.line((left, y.place(1.0)), (right, y.place(1.0)), "truth");
    for (method, (method_name, class, marker_class)) in METHODS.into_iter().enumerate() {
        let mut entries = Vec::new();
        for ((kind, label), shape) in drawn().zip(SHAPES) {
            let points = of(kind, method).into_iter().enumerate();
            let points: Vec<_> = points
                .filter_map(|(n, ratio)| Some((place(n), y.place(ratio?))))
                .collect();
            svg.path(&points, class);
            points
                .iter()
                .for_each(|point| marker(svg, shape, *point, marker_class));
            entries.push((
                Sample::Marked(class, shape, marker_class),
                format!("{method_name}: {label}"),
            ));
        }
        let entries: Vec<_> = entries
            .iter()
            .map(|(sample, text)| (*sample, text.as_str()))
            .collect();
        key(svg, left, to + 50.0 + 22.0 * method as f64, &entries);
    }
}
