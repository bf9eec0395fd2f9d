//! The pictures of the other paper's figures.

use super::motion::Motion;
use super::paper::{FITTED_MM, POLYNOMIAL, SPEEDS_MM_S, WAVELENGTHS_MM};
use super::scan::Scan;
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
/// Points of a curve.
const CURVE: usize = 60;

fn x_axis(svg: &mut Svg, frame: &Frame, label: &str) {
    let (left, right, bottom) = (frame.x.at.0, frame.x.at.1, frame.y.at.0);
    for (value, tick) in frame.x.ticks(6) {
        let x = frame.x.place(value);
        svg.line((x, bottom), (x, bottom + 4.0), "axis");
        svg.text(x, bottom + 17.0, Anchor::Middle, "small", &tick);
    }
    svg.text(0.5 * (left + right), bottom + 33.0, Anchor::Middle, "small", label);
}

/// Figures 8 and 9: errors over the wavelength, one panel for each motion.
pub fn errors(scans: &[Scan]) -> String {
    let mut svg = picture(2.0 * PANEL + 66.0, "Errors of wavelengths, by motion: theirs, ours and the bound");
    let motions = SPEEDS_MM_S.map(Motion::Steady).into_iter().chain([Motion::Hand]);
    for (n, motion) in motions.enumerate() {
        let (left, top) = (LEFTS[n % 2], 46.0 + PANEL * (n / 2) as f64);
        let (right, bottom) = (left + PANEL_WIDTH, top + 124.0);
        let (figure, name) = match motion {
            Motion::Steady(speed_mm_s) => (8, format!("{speed_mm_s} mm/s")),
            Motion::Hand => (9, "197 sin(2 pi 1.07 t) mm/s, one way".into()),
        };
        svg.text(left - 40.0, top - 14.0, Anchor::Start, "title", &format!("Figure {figure}: {name}"));
        svg.text(right, top - 14.0, Anchor::End, "small", "RMS error, %");
        let y = Axis { powers: ERRORS, at: (bottom, top) };
        log_axis(&mut svg, &y, (left, right));
        let frame = Frame::new((left, top, right, bottom), (0.4, 3.1), (0.0, 1.0));
        x_axis(&mut svg, &frame, "wavelength, mm");
        let of_motion = || scans.iter().filter(|scan| scan.motion == motion && !scan.is_turning);
        let mut series = |of: &dyn Fn(&Scan) -> Option<f64>, line: &str, mark: Option<(Shape, &str)>| {
            let place = |scan: &Scan, share: f64| {
                let percent = (100.0 * share).clamp(10f64.powf(ERRORS.0), 10f64.powf(ERRORS.1));
                (frame.x.place(scan.wavelength_mm), y.place(percent))
            };
            let points: Vec<(f64, f64)> = of_motion().filter_map(|scan| Some(place(scan, of(scan)?))).collect();
            svg.path(&points, line);
            if let Some((shape, class)) = mark {
                points.iter().for_each(|point| marker(&mut svg, shape, *point, class));
            }
        };
        series(&|scan| scan.short.bound(), "truth", None);
        series(&|scan| scan.fft, "two", Some((Shape::Triangle, "solid two")));
        series(&|scan| scan.short.rms(), "one", Some((Shape::Square, "solid one fillone")));
        series(&|scan| scan.long.rms(), "three", Some((Shape::Diamond, "solid three")));
    }
    let entries = [
        (Sample::Marked("two", Shape::Triangle, "solid two"), "FFT of 32 ms"),
        (Sample::Marked("one", Shape::Square, "solid one fillone"), "firmware, 32 ms"),
        (Sample::Line("truth"), "bound of 32 ms"),
        (Sample::Marked("three", Shape::Diamond, "solid three"), "firmware, for 0.5 %"),
    ];
    key(&mut svg, LEFTS[0], 2.0 * PANEL + 48.0, &entries);
    svg.finish()
}

fn value(factors: &[f64], x: f64) -> f64 {
    factors.iter().rev().fold(0.0, |sum, factor| sum * x + factor)
}

/// Figures 10 and 11: power over the speed, and over the wavelength with both polynomials.
pub fn powers(scans: &[Scan]) -> String {
    let mut svg = picture(332.0, "Power by speed and by wavelength: theirs and ours");
    let (top, bottom) = (46.0, 232.0);
    let steady = || scans.iter().filter(|scan| scan.motion != Motion::Hand && scan.power_mv2.is_some());
    power_by_speed(&mut svg, (top, bottom), &|wavelength_mm, speed_mm_s| {
        let of = (wavelength_mm, Motion::Steady(speed_mm_s));
        steady().find(|scan| (scan.wavelength_mm, scan.motion) == of).and_then(|scan| scan.power_mv2)
    });

    let (left, right) = (LEFTS[1], LEFTS[1] + PANEL_WIDTH);
    svg.text(left - 40.0, top - 14.0, Anchor::Start, "title", "Figure 11: over the power at 2 mm");
    let (from_mm, to_mm) = (*FITTED_MM.start(), *FITTED_MM.end());
    let frame = Frame::new((left, top, right, bottom), (from_mm - 0.1, to_mm + 0.1), (-0.1, 1.1));
    frame.grid(&mut svg, 6);
    x_axis(&mut svg, &frame, "wavelength, mm");
    let mut curve = |factors: &[f64], class: &str| {
        let at = |n: usize| from_mm + (to_mm - from_mm) * n as f64 / CURVE as f64;
        let points: Vec<(f64, f64)> =
            (0..=CURVE).map(|n| frame.at((at(n), value(factors, at(n)) / value(factors, to_mm)))).collect();
        svg.path(&points, class);
    };
    curve(&POLYNOMIAL, "two");
    if let Some((factors, _)) = polynomial(scans) {
        curve(&factors, "one");
        for scan in steady().filter(|scan| FITTED_MM.contains(&scan.wavelength_mm)) {
            let share = scan.power_mv2.unwrap_or_default() / value(&factors, to_mm);
            marker(&mut svg, Shape::Square, frame.at((scan.wavelength_mm, share)), "solid one");
        }
    }
    let entries = [
        (Sample::Line("two"), "their equation 2"),
        (Sample::Marked("one", Shape::Square, "solid one"), "here, three speeds, and polynomial"),
    ];
    key(&mut svg, left, 304.0, &entries);
    svg.finish()
}

fn power_by_speed(svg: &mut Svg, (top, bottom): (f64, f64), power: &dyn Fn(f64, f64) -> Option<f64>) {
    let (left, right) = (LEFTS[0], LEFTS[0] + PANEL_WIDTH);
    svg.text(left - 40.0, top - 14.0, Anchor::Start, "title", "Figure 10: power, mV^2, by wavelength");
    let all = || WAVELENGTHS_MM.into_iter().flat_map(|mm| SPEEDS_MM_S.map(|speed_mm_s| power(mm, speed_mm_s)));
    let y = Axis::around(all().flatten(), (bottom, top));
    log_axis(svg, &y, (left, right));
    // Room for the wavelengths at the right.
    let frame = Frame::new((left, top, right, bottom), (50.0, 230.0), (0.0, 1.0));
    x_axis(svg, &frame, "speed, mm/s");
    for wavelength_mm in WAVELENGTHS_MM {
        let of = |speed_mm_s| Some((frame.x.place(speed_mm_s), y.place(power(wavelength_mm, speed_mm_s)?)));
        let points: Vec<(f64, f64)> = SPEEDS_MM_S.into_iter().filter_map(of).collect();
        svg.path(&points, "one");
        points.iter().for_each(|point| marker(svg, Shape::Square, *point, "solid one"));
        if let Some((x, y)) = points.last() {
            svg.text(x + 9.0, y + 4.0, Anchor::Start, "small", &format!("{wavelength_mm} mm"));
        }
    }
}
