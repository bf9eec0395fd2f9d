//! The pictures that show runs: Figures 3, 4, 5, 6 and 10 of the paper.

use super::results::{Contact, Opposite, Overlay, Spectrum};
use crate::plot::{Frame, Sample, key, picture, range, taxel_name};
use ridgetone_host::svg::{Anchor, Svg};
use std::f64::consts::TAU;

/// Highest frequency in the periodograms, hertz.
const SPECTRUM_HZ: f64 = 40.0;

/// Left and right edges of two columns, pixels.
const COLUMNS: [(f64, f64); 2] = [(62.0, 466.0), (538.0, 942.0)];

/// Figure 3: contact detection and cropping.
pub fn contacts(contacts: &[Contact]) -> String {
    let title = "Contact detection and the slide cut out of it";
    let mut svg = picture(430.0, title);
    for (contact, (left, right)) in contacts.iter().zip(COLUMNS) {
        svg.text(
            left - 40.0,
            26.0,
            Anchor::Start,
            "title",
            &format!("Data series {}", contact.series),
        );
        let all = contact
            .curves
            .iter()
            .flat_map(|curve| curve.mv.iter().copied());
        let y = range(all);
        for (n, curve) in contact.curves.iter().enumerate() {
            let top = 62.0 + 160.0 * n as f64;
            let points = curve.points();
            let x = (0.0, points.last().map_or(1.0, |point| point.0));
            let frame = Frame::new((left, top, right, top + 120.0), x, y);
            frame.area(&mut svg, contact.slide_s, "slide");
            let x_label = if n == 1 { "time, s" } else { "" };
            frame.axes(
                &mut svg,
                (6, 4),
                x_label,
                &format!("mV, {}", taxel_name(contact.taxels[n])),
            );
            frame.curve(&mut svg, &points, "data");
            let inside =
                |point: &&(f64, f64)| (contact.cut_s.0..contact.cut_s.1).contains(&point.0);
            frame.curve(
                &mut svg,
                &points.iter().filter(inside).copied().collect::<Vec<_>>(),
                "one",
            );
            frame.upright(&mut svg, contact.spike_s, "mark");
            for t_s in contact
                .found_s
                .into_iter()
                .flat_map(|(from_s, to_s)| [from_s, to_s])
            {
                frame.upright(&mut svg, t_s, "truth");
            }
        }
    }
    let entries = [
        (Sample::Line("mark"), "spike (equations 2, 3)"),
        (Sample::Line("one"), "cut out (equations 4, 5)"),
        (Sample::Area("slide"), "true slide"),
        (Sample::Line("truth"), "slide found by the firmware"),
    ];
    key(&mut svg, 62.0, 412.0, &entries);
    svg.finish()
}

/// Figures 4 and 5: a part of a channel above its periodogram.
pub fn spectra(spectra: &[Spectrum]) -> String {
    let mut svg = picture(480.0, "Periodograms of a whole slide and of 0.35 s");
    for (n, (spectrum, (left, right))) in spectra.iter().zip(COLUMNS).enumerate() {
        let points = spectrum.curve.points();
        let length_s = spectrum.curve.step_s * points.len() as f64;
        let title = format!(
            "Figure {}: data series {}, {length_s:.2} s",
            4 + n,
            spectrum.series
        );
        svg.text(left - 40.0, 26.0, Anchor::Start, "title", &title);
        let x = (spectrum.curve.from_s, spectrum.curve.from_s + length_s);
        let frame = Frame::new(
            (left, 62.0, right, 182.0),
            x,
            range(points.iter().map(|point| point.1)),
        );
        frame.axes(
            &mut svg,
            (6, 4),
            "time, s",
            &format!("mV, {}", taxel_name(spectrum.taxel)),
        );
        frame.curve(&mut svg, &points, "one");
        lines(&mut svg, spectrum, (left, right));
    }
    let entries = [
        (Sample::Area("fillone"), "highest line: the estimate"),
        (Sample::Area("bar"), "other lines"),
        (Sample::Line("mark"), "nominal frequency"),
    ];
    key(&mut svg, 62.0, 462.0, &entries);
    svg.finish()
}

/// The lower half: one bar for each line.
fn lines(svg: &mut Svg, spectrum: &Spectrum, (left, right): (f64, f64)) {
    let most = spectrum.mv.iter().copied().fold(0.0, f64::max);
    let frame = Frame::new(
        (left, 262.0, right, 402.0),
        (0.0, SPECTRUM_HZ),
        (0.0, 1.12 * most),
    );
    frame.axes(svg, (8, 4), "frequency, Hz", "amplitude, mV");
    let mut highest = 0.0;
    for (n, mv) in spectrum.mv.iter().enumerate() {
        let hz = (n + 1) as f64 * spectrum.line_hz;
        let (from, to) = (hz - 0.42 * spectrum.line_hz, hz + 0.42 * spectrum.line_hz);
        if to > SPECTRUM_HZ {
            break;
        }
        let (x, y) = frame.at((from, *mv));
        let is_highest = *mv == most;
        highest = if is_highest { hz } else { highest };
        let class = if is_highest { "fillone" } else { "bar" };
        svg.rect(x, y, frame.x.place(to) - x, frame.y.at.0 - y, class);
    }
    frame.upright(svg, spectrum.nominal_hz, "mark");
    let text = format!(
        "estimate {highest:.2} Hz, nominal {:.2} Hz",
        spectrum.nominal_hz
    );
    let beside = frame
        .x
        .place(spectrum.nominal_hz.max(highest) + 0.5 * spectrum.line_hz)
        + 10.0;
    svg.text(beside, 280.0, Anchor::Start, "small", &text);
    svg.text(
        beside,
        295.0,
        Anchor::Start,
        "small",
        &format!("lines {:.2} Hz apart", spectrum.line_hz),
    );
}

/// Figure 6: two channels and the sines of one frequency fitted to them, the second shifted down.
pub fn overlay(overlay: &Overlay) -> String {
    let mut svg = picture(360.0, "Least squares over the whole slide");
    let title = format!(
        "Data series {}: one frequency for both, {:.4} Hz",
        overlay.series, overlay.hz
    );
    svg.text(22.0, 26.0, Anchor::Start, "title", &title);
    let span = |n: usize| range(overlay.curves[n].mv.iter().copied());
    let ((low, _), (_, second_high)) = (span(0), span(1));
    let shift = low - second_high;
    let y = (span(1).0 + shift, span(0).1);
    let points = [overlay.curves[0].points(), overlay.curves[1].points()];
    let ends = |points: &[(f64, f64)]| {
        (
            points.first().map_or(0.0, |p| p.0),
            points.last().map_or(1.0, |p| p.0),
        )
    };
    let frame = Frame::new((62.0, 62.0, 942.0, 282.0), ends(&points[0]), y);
    frame.axes(&mut svg, (10, 6), "time, s", "mV");
    for (n, points) in points.iter().enumerate() {
        let down = if n == 0 { 0.0 } else { shift };
        let dots: Vec<(f64, f64)> = points
            .iter()
            .map(|(t_s, mv)| frame.at((*t_s, mv + down)))
            .collect();
        svg.dots(&dots, "dot");
        let [offset, cos, sin] = overlay.sines_mv[n];
        let model = |t_s: f64| {
            let (s, c) = (TAU * overlay.hz * (t_s - overlay.curves[n].from_s)).sin_cos();
            offset + cos * c + sin * s + down
        };
        let line: Vec<(f64, f64)> = points.iter().map(|(t_s, _)| (*t_s, model(*t_s))).collect();
        frame.curve(&mut svg, &line, ["one", "two"][n]);
    }
    let second = format!(
        "fit of {}, shifted by {shift:.1} mV",
        taxel_name(overlay.taxels[1])
    );
    let first = format!("fit of {}", taxel_name(overlay.taxels[0]));
    let entries = [
        (Sample::Line("one"), first.as_str()),
        (Sample::Line("two"), &second),
        (Sample::Dots("dot"), "samples"),
    ];
    key(&mut svg, 62.0, 342.0, &entries);
    svg.finish()
}

/// Figure 10: two piezoresistors that face each other along the motion.
pub fn opposite(opposite: &Opposite) -> String {
    let mut svg = picture(340.0, "Piezoresistors 1 and 3 have opposite signs");
    let title = format!(
        "Data series {}: correlation {:+.2}",
        opposite.series, opposite.correlation
    );
    svg.text(22.0, 26.0, Anchor::Start, "title", &title);
    let points = [opposite.curves[0].points(), opposite.curves[1].points()];
    let x = (
        points[0].first().map_or(0.0, |p| p.0),
        points[0].last().map_or(1.0, |p| p.0),
    );
    let y = range(points.iter().flatten().map(|point| point.1));
    let frame = Frame::new((62.0, 62.0, 942.0, 262.0), x, y);
    frame.axes(&mut svg, (10, 5), "time, s", "mV");
    for (points, class) in points.iter().zip(["one", "two"]) {
        frame.curve(&mut svg, points, class);
    }
    let names = opposite.taxels.map(taxel_name);
    key(
        &mut svg,
        62.0,
        322.0,
        &[
            (Sample::Line("one"), &names[0]),
            (Sample::Line("two"), &names[1]),
        ],
    );
    svg.finish()
}
