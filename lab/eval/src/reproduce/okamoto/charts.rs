//! The pictures of the other paper's figures.

use super::motion::Motion;
use super::paper::{FITTED_MM, POLYNOMIAL, SPEEDS_MM_S, WAVELENGTHS_MM};
use super::scan::Scan;
use super::skin::Skin;
use super::tables::polynomial;
use crate::axis::Axis;
use crate::plot::{Frame, Sample, Shape, key, log_axis, marker, picture};
use ridgetone_host::svg::{Anchor, Svg};

/// Height of a panel with all around it, pixels.
const PANEL: f64 = 206.0;
/// Left edges of the two panels of a row, and the width of each, pixels.
const LEFTS: [f64; 2] = [62.0, 538.0];
const PANEL_WIDTH: f64 = 404.0;
/// Errors that a panel shows, decades of percent.
const ERRORS: (f64, f64) = (-3.0, 3.0);
/// Width and height of a wavelength's label, pixels.
const LABEL: (f64, f64) = (46.0, 10.5);
/// Points of a curve.
const CURVE: usize = 60;

fn x_axis(svg: &mut Svg, frame: &Frame, label: &str) {
    let (left, right, bottom) = (frame.x.at.0, frame.x.at.1, frame.y.at.0);
    for (value, tick) in frame.x.ticks(6) {
        let x = frame.x.place(value);
        svg.line((x, bottom), (x, bottom + 4.0), "axis");
        svg.text(x, bottom + 17.0, Anchor::Middle, "small", &tick);
    }
    svg.text(
        0.5 * (left + right),
        bottom + 33.0,
        Anchor::Middle,
        "small",
        label,
    );
}

/// Figures 8 and 9 with a skin: errors over the wavelength, one panel for each motion.
pub fn errors(scans: &[Scan], skin: Skin) -> String {
    let mut svg = picture(
        2.0 * PANEL + 66.0,
        "Errors of wavelengths, by motion: theirs, ours and the bound",
    );
    let motions = SPEEDS_MM_S
        .map(Motion::Steady)
        .into_iter()
        .chain([Motion::Hand]);
    for (n, motion) in motions.enumerate() {
        let (left, top) = (LEFTS[n % 2], 46.0 + PANEL * (n / 2) as f64);
        let (right, bottom) = (left + PANEL_WIDTH, top + 124.0);
        let (figure, name) = match motion {
            Motion::Steady(speed_mm_s) => (8, format!("{speed_mm_s} mm/s")),
            Motion::Hand => (9, "197 sin(2 pi 1.07 t) mm/s, one way".into()),
        };
        svg.text(
            left - 40.0,
            top - 14.0,
            Anchor::Start,
            "title",
            &format!("Figure {figure}: {name}"),
        );
        svg.text(right, top - 14.0, Anchor::End, "small", "RMS error, %");
        let y = Axis {
            powers: ERRORS,
            at: (bottom, top),
        };
        log_axis(&mut svg, &y, (left, right));
        let frame = Frame::new((left, top, right, bottom), (0.4, 3.1), (0.0, 1.0));
        x_axis(&mut svg, &frame, "wavelength, mm");
        let of_motion = || {
            scans
                .iter()
                .filter(|scan| (scan.motion, scan.skin, scan.is_turning) == (motion, skin, false))
        };
        let mut series =
            |of: &dyn Fn(&Scan) -> Option<f64>, line: &str, mark: Option<(Shape, &str)>| {
                let place = |scan: &Scan, share: f64| {
                    let percent = (100.0 * share).clamp(10f64.powf(ERRORS.0), 10f64.powf(ERRORS.1));
                    (frame.x.place(scan.wavelength_mm), y.place(percent))
                };
                let points: Vec<(f64, f64)> = of_motion()
                    .filter_map(|scan| Some(place(scan, of(scan)?)))
                    .collect();
                svg.path(&points, line);
                if let Some((shape, class)) = mark {
                    points
                        .iter()
                        .for_each(|point| marker(&mut svg, shape, *point, class));
                }
            };
        series(&|scan| scan.short.bound(), "truth", None);
        series(
            &|scan| scan.fft,
            "two",
            Some((Shape::Triangle, "solid two")),
        );
        series(
            &|scan| scan.short.rms(),
            "one",
            Some((Shape::Square, "solid one fillone")),
        );
        series(
            &|scan| scan.long.rms(),
            "three",
            Some((Shape::Diamond, "solid three")),
        );
    }
    let entries = [
        (
            Sample::Marked("two", Shape::Triangle, "solid two"),
            "FFT of 32 ms",
        ),
        (
            Sample::Marked("one", Shape::Square, "solid one fillone"),
            "firmware, 32 ms",
        ),
        (Sample::Line("truth"), "bound of 32 ms"),
        (
            Sample::Marked("three", Shape::Diamond, "solid three"),
            "firmware, for 0.5 %",
        ),
    ];
    key(&mut svg, LEFTS[0], 2.0 * PANEL + 48.0, &entries);
    svg.finish()
}

fn value(factors: &[f64], x: f64) -> f64 {
    factors
        .iter()
        .rev()
        .fold(0.0, |sum, factor| sum * x + factor)
}

/// The greatest value of a polynomial where powers were fitted.
fn greatest(factors: &[f64]) -> f64 {
    curve_mm().map(|mm| value(factors, mm)).fold(0.0, f64::max)
}

/// Wavelengths of a curve's points.
fn curve_mm() -> impl Iterator<Item = f64> {
    let (from_mm, to_mm) = (*FITTED_MM.start(), *FITTED_MM.end());
    (0..=CURVE).map(move |n| from_mm + (to_mm - from_mm) * n as f64 / CURVE as f64)
}

/// Figures 10 and 11: power over the speed with the ridged skin, and over the wavelength with both
/// skins, polynomials and theirs.
pub fn powers(scans: &[Scan]) -> String {
    let mut svg = picture(332.0, "Power by speed and by wavelength: theirs and ours");
    let (top, bottom) = (46.0, 232.0);
    let steady = |skin| {
        let is_own = move |scan: &&Scan| {
            scan.skin == skin && scan.motion != Motion::Hand && scan.power_mv2.is_some()
        };
        scans.iter().filter(is_own)
    };
    power_by_speed(&mut svg, (top, bottom), &|wavelength_mm, speed_mm_s| {
        let of = (wavelength_mm, Motion::Steady(speed_mm_s));
        steady(Skin::Ridged)
            .find(|scan| (scan.wavelength_mm, scan.motion) == of)
            .and_then(|scan| scan.power_mv2)
    });

    let (left, right) = (LEFTS[1], LEFTS[1] + PANEL_WIDTH);
    svg.text(
        left - 40.0,
        top - 14.0,
        Anchor::Start,
        "title",
        "Figure 11: over the greatest power of a curve",
    );
    let frame = Frame::new(
        (left, top, right, bottom),
        (FITTED_MM.start() - 0.1, FITTED_MM.end() + 0.1),
        (-0.1, 1.2),
    );
    frame.grid(&mut svg, 6);
    x_axis(&mut svg, &frame, "wavelength, mm");
    let curve = |factors: &[f64]| -> Vec<(f64, f64)> {
        curve_mm()
            .map(|mm| frame.at((mm, value(factors, mm) / greatest(factors))))
            .collect()
    };
    svg.path(&curve(&POLYNOMIAL), "two");
    let marks = [
        (Skin::Ridged, Shape::Square, "one"),
        (Skin::Smooth, Shape::Diamond, "three"),
    ];
    for (skin, shape, class) in marks {
        let Some((factors, _)) = polynomial(scans, skin) else {
            continue;
        };
        svg.path(&curve(&factors), class);
        for scan in steady(skin).filter(|scan| FITTED_MM.contains(&scan.wavelength_mm)) {
            let share = scan.power_mv2.unwrap_or_default() / greatest(&factors);
            marker(
                &mut svg,
                shape,
                frame.at((scan.wavelength_mm, share)),
                &format!("solid {class}"),
            );
        }
    }
    let entries = [
        (Sample::Line("two"), "their equation 2"),
        (
            Sample::Marked("one", Shape::Square, "solid one"),
            "ridged skin",
        ),
        (
            Sample::Marked("three", Shape::Diamond, "solid three"),
            "smooth skin",
        ),
    ];
    key(&mut svg, left, 304.0, &entries);
    svg.finish()
}

fn power_by_speed(
    svg: &mut Svg,
    (top, bottom): (f64, f64),
    power: &dyn Fn(f64, f64) -> Option<f64>,
) {
    let (left, right) = (LEFTS[0], LEFTS[0] + PANEL_WIDTH);
    svg.text(
        left - 40.0,
        top - 14.0,
        Anchor::Start,
        "title",
        "Figure 10: power, mV^2, by wavelength",
    );
    let all = || {
        WAVELENGTHS_MM
            .into_iter()
            .flat_map(|mm| SPEEDS_MM_S.map(|speed_mm_s| power(mm, speed_mm_s)))
    };
    let y = Axis::around(all().flatten(), (bottom, top));
    log_axis(svg, &y, (left, right));
    // Room for the wavelengths at the right.
    let frame = Frame::new((left, top, right, bottom), (50.0, 230.0), (0.0, 1.0));
    x_axis(svg, &frame, "speed, mm/s");
    let mut labels = Vec::new();
    for wavelength_mm in WAVELENGTHS_MM {
        let of = |speed_mm_s| {
            Some((
                frame.x.place(speed_mm_s),
                y.place(power(wavelength_mm, speed_mm_s)?),
            ))
        };
        let points: Vec<(f64, f64)> = SPEEDS_MM_S.into_iter().filter_map(of).collect();
        svg.path(&points, "one");
        points
            .iter()
            .for_each(|point| marker(svg, Shape::Square, *point, "solid one"));
        labels.extend(points.last().map(|(x, y)| (*x, *y, wavelength_mm)));
    }
    // Beside its line, or a column farther where that is taken.
    labels.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut free = [f64::MIN; 3];
    for (x, y, wavelength_mm) in labels {
        let emptiest = (0..free.len())
            .min_by(|a, b| free[*a].total_cmp(&free[*b]))
            .unwrap_or_default();
        let column = free.iter().position(|free| *free <= y).unwrap_or(emptiest);
        let (left, y) = (x + 9.0 + LABEL.0 * column as f64, y.max(free[column]));
        svg.text(
            left,
            y + 4.0,
            Anchor::Start,
            "small",
            &format!("{wavelength_mm} mm"),
        );
        free[column] = y + LABEL.1;
    }
}
