//! The pictures of the page.

use super::bars::TABLE_6;
use super::gratings::{
    INDENT_MM, Indices, PERIODS_MM, SPACING_MM, figure_17d, figure_22, places_mm, pressure,
};
use super::layers::{Filter, figure_12, figure_16};
use super::matching::Figure8;
use crate::plot::{Frame, Sample, Shape, key, marker, picture, range};
use anyhow::Result;
use ridgetone_display::SUBJECTS;
use ridgetone_host::pins::{NOTICEABLE, ridges};
use ridgetone_host::svg::{Anchor, Svg};

/// Left and right edges of two columns, pixels.
const COLUMNS: [(f64, f64); 2] = [(62.0, 466.0), (538.0, 942.0)];

/// Figure 8: forces above, strains below.
pub fn matching(figure: &Figure8) -> String {
    let mut svg = picture(470.0, "Strain matching of a block 4 mm wide");
    let x = (-5.2, 5.2);
    let classes = ["two", "three", "one"];
    let all = figure
        .ways
        .iter()
        .flat_map(|way| way.forces.iter().copied())
        .chain([0.0, 1.0]);
    let frame = Frame::new((62.0, 46.0, 942.0, 196.0), x, range(all));
    frame.axes(
        &mut svg,
        (10, 5),
        "",
        "pressure on the sensor, N/mm^2; forces of pins 1 mm apart, N/mm",
    );
    frame.curve(&mut svg, &zip(&figure.x_mm, &figure.pressure), "data");
    for (n, (way, class)) in figure
        .ways
        .iter()
        .zip(["filltwo", "fillthree", "fillone"])
        .enumerate()
    {
        let bar = 5.0;
        for (x, force) in figure.pin_mm.iter().zip(&way.forces) {
            let (left, top) = frame.at((*x, force.max(0.0)));
            let zero = frame.y.place(force.min(0.0));
            svg.rect(left + bar * (n as f64 - 1.5), top, bar, zero - top, class);
        }
    }
    let frame = Frame::new(
        (62.0, 246.0, 942.0, 396.0),
        x,
        range(figure.strain.iter().copied()),
    );
    frame.axes(
        &mut svg,
        (10, 5),
        "place, mm",
        "strain times Young's modulus, N/mm^2, 1.5 mm deep",
    );
    frame.curve(&mut svg, &zip(&figure.x_mm, &figure.strain), "data");
    for (way, class) in figure.ways.iter().zip(classes) {
        frame.curve(&mut svg, &zip(&figure.x_mm, &way.strain), class);
    }
    let mut entries = vec![(Sample::Line("data"), "in the sensor".to_owned())];
    entries.extend(
        figure
            .ways
            .iter()
            .zip(classes)
            .map(|(way, class)| (Sample::Line(class), format!("finger, {}", way.name))),
    );
    named(&mut svg, 454.0, &entries);
    svg.finish()
}

/// Figure 12: what the layers pass on.
pub fn layers() -> String {
    let mut svg = picture(
        330.0,
        "What two layers of rubber pass on, with and without shear stress between them",
    );
    let curve = |of: fn((f64, f64)) -> f64| {
        (0..=200)
            .map(move |n| 0.002 * f64::from(n))
            .map(|c| (c, of(figure_12(c))))
            .collect::<Vec<_>>()
    };
    let frame = Frame::new((62.0, 46.0, 942.0, 256.0), (0.0, 0.4), (0.0, 1.7));
    frame.axes(
        &mut svg,
        (8, 6),
        "cycles per millimetre",
        "strain 2.7 mm deep, over that of an even load",
    );
    frame.curve(&mut svg, &curve(|pair| pair.0), "one");
    frame.curve(&mut svg, &curve(|pair| pair.1), "two");
    key(
        &mut svg,
        62.0,
        314.0,
        &[
            (Sample::Line("one"), "with shear"),
            (Sample::Line("two"), "without shear"),
        ],
    );
    svg.finish()
}

/// Figure 16: sampling, with each way to make a profile of samples.
pub fn sampling() -> String {
    let mut svg = picture(
        380.0,
        "What sampling leaves of the strain under a line load",
    );
    let ratios = || (6..=60).map(|n| 0.05 * f64::from(n));
    for (shear, (left, right)) in [true, false].into_iter().zip(COLUMNS) {
        let frame = Frame::new((left, 46.0, right, 296.0), (0.3, 3.0), (-8.0, 40.0));
        let title = if shear {
            "signal over noise, dB, with shear"
        } else {
            "signal over noise, dB, without shear"
        };
        frame.axes(
            &mut svg,
            (6, 5),
            "spacing over the thickness of a layer",
            title,
        );
        for (filter, class) in Filter::ALL.into_iter().zip(CLASSES) {
            let curve: Vec<(f64, f64)> = ratios()
                .map(|ratio| (ratio, figure_16(ratio, filter, shear)))
                .filter(|(_, db)| *db <= 40.0)
                .collect();
            frame.curve(&mut svg, &curve, class);
        }
    }
    let entries: Vec<(Sample, String)> = Filter::ALL
        .into_iter()
        .zip(CLASSES)
        .map(|(filter, class)| (Sample::Line(class), filter.name().to_owned()))
        .collect();
    named(&mut svg, 364.0, &entries);
    svg.finish()
}

/// Of five curves in one picture.
const CLASSES: [&str; 5] = ["one", "two", "three", "mark", "data"];

/// Figure 17: a grating of 4 mm, three periods of it.
pub fn grating() -> String {
    const PERIOD_MM: f64 = 4.0;
    let mut svg = picture(
        600.0,
        "A grating of 4 mm on rubber: deflection, pressure, and strain under it",
    );
    let thrice = |values: &[f64]| -> Vec<(f64, f64)> {
        let repeated: Vec<f64> = [values, values, values].concat();
        places_mm(repeated.len()).zip(repeated).collect()
    };
    let shape: Vec<f64> = ridges(PERIOD_MM, INDENT_MM)
        .into_iter()
        .map(|mm| mm.unwrap_or(0.0))
        .collect();
    let (strain, mean) = figure_17d(PERIOD_MM);
    let panels: [(&str, Vec<f64>, &str); 3] = [
        ("the grating, mm", shape, "data"),
        (
            "pressure on the surface over Young's modulus",
            pressure(PERIOD_MM).cells().to_vec(),
            "two",
        ),
        ("strain 2.7 mm deep", strain, "one"),
    ];
    for (n, (label, values, class)) in panels.iter().enumerate() {
        let top = 46.0 + 180.0 * n as f64;
        let (least, most) = range(values.iter().copied().chain([0.0]));
        let frame = Frame::new(
            (62.0, top, 942.0, top + 120.0),
            (0.0, 3.0 * PERIOD_MM),
            (least.min(0.0), most),
        );
        frame.axes(
            &mut svg,
            (6, 4),
            if n == 2 { "place, mm" } else { "" },
            label,
        );
        frame.curve(&mut svg, &thrice(values), class);
        if n == 2 {
            frame.curve(&mut svg, &[(0.0, mean), (3.0 * PERIOD_MM, mean)], "truth");
        }
    }
    key(&mut svg, 62.0, 586.0, &[(Sample::Line("truth"), "mean")]);
    svg.finish()
}

/// Figures 18 and 19: modulation indices over the period.
pub fn indices() -> String {
    let mut svg = picture(380.0, "Modulation indices of gratings under 2 mm of rubber");
    let all: Vec<(f64, Indices)> = PERIODS_MM
        .iter()
        .map(|mm| (*mm, Indices::of(*mm)))
        .collect();
    let labels = ["index of strain 2.7 mm deep", "index of stress 2.0 mm deep"];
    for (n, (label, (left, right))) in labels.into_iter().zip(COLUMNS).enumerate() {
        let frame = Frame::new((left, 46.0, right, 296.0), (2.2, 5.4), (0.0, 0.6));
        let (top, bottom) = (frame.y.place(NOTICEABLE.1), frame.y.place(NOTICEABLE.0));
        svg.rect(left, top, right - left, bottom - top, "band");
        frame.axes(&mut svg, (8, 6), "period, mm", label);
        let pair = |indices: &Indices| {
            if n == 0 {
                indices.strain
            } else {
                indices.stress
            }
        };
        let with: Vec<(f64, f64)> = all
            .iter()
            .map(|(mm, indices)| (*mm, pair(indices).0))
            .collect();
        let without: Vec<(f64, f64)> = all
            .iter()
            .map(|(mm, indices)| (*mm, pair(indices).1))
            .collect();
        frame.curve(&mut svg, &with, "one");
        frame.curve(&mut svg, &without, "two");
    }
    let frame = Frame::new(
        (COLUMNS[0].0, 46.0, COLUMNS[0].1, 296.0),
        (2.2, 5.4),
        (0.0, 0.6),
    );
    marker(&mut svg, Shape::Diamond, frame.at((4.0, 0.18)), "filltwo");
    let entries = [
        (Sample::Line("one"), "with shear"),
        (Sample::Line("two"), "without shear"),
        (
            Sample::Marker(Shape::Diamond, "filltwo"),
            "paper, with shear",
        ),
        (Sample::Area("band"), "just noticed (paper)"),
    ];
    key(&mut svg, 62.0, 364.0, &entries);
    svg.finish()
}

/// Figure 22: errors of the pins.
pub fn errors() -> String {
    let mut svg = picture(
        360.0,
        "What is felt of errors of pins 2 mm apart under 2 mm of rubber",
    );
    let frame = Frame::new((62.0, 46.0, 942.0, 276.0), (0.04, 0.26), (0.0, 0.2));
    let (top, bottom) = (frame.y.place(NOTICEABLE.1), frame.y.place(NOTICEABLE.0));
    svg.rect(62.0, top, 880.0, bottom - top, "band");
    frame.axes(
        &mut svg,
        (8, 5),
        "cycles of the error per millimetre",
        "index of stress at the finger",
    );
    let errors = [(0.05, "three"), (0.1, "one"), (0.2, "two")];
    for (error, class) in errors {
        // Even numbers: pins are off by as much to both sides.
        let curve: Vec<(f64, f64)> = (1..=5)
            .rev()
            .map(|half| {
                (
                    1.0 / (2.0 * SPACING_MM * f64::from(half)),
                    figure_22(2 * half as usize, error),
                )
            })
            .collect();
        frame.curve(&mut svg, &curve, class);
    }
    marker(&mut svg, Shape::Diamond, frame.at((0.25, 0.06)), "fillone");
    let entries = [
        (Sample::Line("three"), "5 %"),
        (Sample::Line("one"), "10 %"),
        (Sample::Line("two"), "20 %"),
        (Sample::Marker(Shape::Diamond, "fillone"), "paper, 10 %"),
        (Sample::Area("band"), "just noticed (paper)"),
    ];
    key(&mut svg, 62.0, 344.0, &entries);
    svg.finish()
}

/// Table 6: what a finger keeps.
pub fn skin() -> String {
    let mut svg = picture(330.0, "What a finger keeps 1.8 s after a ridge of 3 s");
    let frame = Frame::new((62.0, 46.0, 942.0, 246.0), (0.4, 6.6), (0.0, 0.8));
    frame.grid(&mut svg, 4);
    svg.text(
        22.0,
        37.0,
        Anchor::Start,
        "small",
        "share of the deformation",
    );
    for (n, (subject, paper)) in SUBJECTS.iter().zip(TABLE_6).enumerate() {
        let values = [
            paper,
            subject.retained_by_creep_time(1.8),
            subject.retained(3.0, 1.8),
        ];
        for (place, (value, class)) in values
            .into_iter()
            .zip(["bar", "fillone", "filltwo"])
            .enumerate()
        {
            let (x, y) = frame.at((n as f64 + 0.7 + 0.2 * place as f64, value));
            svg.rect(x, y, 24.0, frame.y.at.0 - y, class);
        }
        svg.text(
            frame.x.place(n as f64 + 1.0),
            263.0,
            Anchor::Middle,
            "small",
            &format!("subject {}", n + 1),
        );
    }
    let entries = [
        (Sample::Area("bar"), "paper, Table 6"),
        (Sample::Area("fillone"), "exp(-1.8 s / creep time)"),
        (Sample::Area("filltwo"), "the Kelvin model"),
    ];
    key(&mut svg, 62.0, 306.0, &entries);
    svg.finish()
}

/// Figure 12 of Okamoto et al.: answers over gratings.
pub fn experiment() -> Result<String> {
    let mut svg = picture(
        360.0,
        "Gratings that people would choose for those under the robot's finger",
    );
    let frame = Frame::new((62.0, 46.0, 942.0, 276.0), (0.7, 2.1), (0.6, 2.4));
    frame.axes(
        &mut svg,
        (7, 6),
        "period under the robot's finger, mm",
        "mean answer, mm",
    );
    frame.curve(&mut svg, &[(0.7, 0.7), (2.1, 2.1)], "truth");
    let mut entries = vec![(Sample::Line("truth"), "the same".to_owned())];
    for ((condition, outcome), class) in super::experiment::outcomes()?
        .into_iter()
        .zip(["one", "two", "three"])
    {
        frame.curve(
            &mut svg,
            &zip(&super::experiment::PERIODS_MM, &outcome.answers_mm),
            class,
        );
        entries.push((Sample::Line(class), condition.name.to_owned()));
    }
    named(&mut svg, 344.0, &entries);
    Ok(svg.finish())
}

fn zip(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

fn named(svg: &mut Svg, y: f64, entries: &[(Sample, String)]) {
    let entries: Vec<(Sample, &str)> = entries
        .iter()
        .map(|(sample, text)| (*sample, text.as_str()))
        .collect();
    key(svg, 62.0, y, &entries);
}
