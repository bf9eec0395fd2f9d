//! The pictures of figures: errors by combination and by window (Figure 7), repeatability.

use super::paper::{REPEATABILITY, TABLE_3};
use super::results::{Combination, Windows};
use crate::axis::Axis;
use crate::plot::{Frame, Sample, Shape, key, log_axis, marker, picture};
use ridgetone_host::svg::{Anchor, Svg};

/// Errors of all combinations: the paper's, ours against the nominal frequency, and against the
/// true one.
pub fn errors(combinations: &[Combination]) -> String {
    let mut svg = picture(
        400.0,
        "Errors by combination: the stimulator's and the methods' own",
    );
    svg.text(
        22.0,
        26.0,
        Anchor::Start,
        "title",
        "RMS error over 55 mm, % of the frequency",
    );
    let y = Axis {
        powers: (-3.0, 1.0),
        at: (310.0, 50.0),
    };
    log_axis(&mut svg, &y, (62.0, 942.0));
    let step = 880.0 / combinations.len() as f64;
    for (n, combination) in combinations.iter().enumerate() {
        let (x, nominal_hz) = (62.0 + step * (n as f64 + 0.5), combination.nominal_hz());
        let name = format!("{} mm/s", combination.speed_mm_s);
        svg.text(x, 328.0, Anchor::Middle, "small", &name);
        svg.text(
            x,
            344.0,
            Anchor::Middle,
            "small",
            &format!("{} mm", combination.period_mm),
        );
        let percent = |hz: Option<f64>| {
            hz.map(|hz| 100.0 * hz / nominal_hz)
                .filter(|percent| *percent > 0.0)
        };
        let paper = combination
            .number()
            .map(|c| TABLE_3[0].least_squares.percent[c]);
        let two = combination.rms_hz(|run| run.pairs[0].least_squares_hz);
        let own_two = combination.own_rms_hz(|run| run.pairs[0].least_squares_hz);
        let own_all = combination.own_rms_hz(|run| run.all_fit_hz.map(|fit| fit.0));
        let marks = [
            (paper, Shape::Square, "truth fillnone", -18.0),
            (percent(two), Shape::Square, "one fillone", -6.0),
            (percent(own_two), Shape::Triangle, "two", 6.0),
            (percent(own_all), Shape::Diamond, "three", 18.0),
        ];
        for (percent, shape, class, off) in marks {
            if let Some(percent) = percent {
                marker(
                    &mut svg,
                    shape,
                    (x + off, y.place(percent.clamp(1e-3, 10.0))),
                    &format!("solid {class}"),
                );
            }
        }
    }
    let entries = [
        (
            Sample::Marker(Shape::Square, "solid truth"),
            "paper, least squares",
        ),
        (
            Sample::Marker(Shape::Square, "solid one fillone"),
            "here, its method",
        ),
        (
            Sample::Marker(Shape::Triangle, "solid two"),
            "its method, against the true speed",
        ),
        (
            Sample::Marker(Shape::Diamond, "solid three"),
            "all 16, against the true speed",
        ),
    ];
    key(&mut svg, 62.0, 382.0, &entries);
    svg.finish()
}

/// Height of a panel of Figure 7 with all around it, pixels.
const PANEL: f64 = 196.0;

/// Figure 7: error against the length of the window, one panel for each combination.
pub fn windows(combinations: &[Combination]) -> String {
    let rows = combinations.len().div_ceil(2);
    let height = PANEL * rows as f64 + 60.0;
    let mut svg = picture(height, "Error against the length of the window");
    for (n, combination) in combinations.iter().enumerate() {
        let (left, top) = ([62.0, 538.0][n % 2], 46.0 + PANEL * (n / 2) as f64);
        panel(&mut svg, combination, (left, top));
    }
    let entries = [
        (
            Sample::Marked("two", Shape::Triangle, "solid two"),
            "FFT, 2 channels",
        ),
        (
            Sample::Marked("one", Shape::Square, "solid one fillone"),
            "least squares, 2 channels",
        ),
        (
            Sample::Marked("three", Shape::Diamond, "solid three"),
            "fit of 16 channels, against the true speed",
        ),
        (Sample::Line("truth"), "paper, 55 mm"),
    ];
    key(&mut svg, 62.0, height - 18.0, &entries);
    svg.finish()
}

fn panel(svg: &mut Svg, combination: &Combination, (left, top): (f64, f64)) {
    let (right, bottom) = (left + 404.0, top + 118.0);
    let y = Axis {
        powers: (-2.0, 2.0),
        at: (bottom, top),
    };
    let Combination {
        speed_mm_s,
        period_mm,
        ..
    } = combination;
    let name = combination
        .number()
        .map_or_else(String::new, |c| format!("C{}: ", c + 1));
    let title = format!(
        "{name}{speed_mm_s} mm/s, {period_mm} mm, {:.2} Hz",
        combination.nominal_hz()
    );
    svg.text(left - 40.0, top - 14.0, Anchor::Start, "title", &title);
    svg.text(right, top - 14.0, Anchor::End, "small", "RMS error, %");
    log_axis(svg, &y, (left, right));
    let frame = Frame::new((left, top, right, bottom), (0.2, 1.0), (0.0, 1.0));
    for (value, label) in frame.x.ticks(8) {
        let x = frame.x.place(value);
        svg.line((x, bottom), (x, bottom + 4.0), "axis");
        svg.text(x, bottom + 17.0, Anchor::Middle, "small", &label);
    }
    svg.text(
        0.5 * (left + right),
        bottom + 33.0,
        Anchor::Middle,
        "small",
        "window, s",
    );
    if let Some(c) = combination.number() {
        let height = y.place(TABLE_3[0].least_squares.percent[c]);
        svg.line((left, height), (right, height), "truth");
    }
    let percent = |hz: f64| 100.0 * hz / combination.nominal_hz();
    let place = |window: &Windows, hz: f64| {
        (
            frame.x.place(window.window_s),
            y.place(percent(hz).clamp(0.01, 100.0)),
        )
    };
    let mut line = |of: &dyn Fn(&Windows) -> Option<f64>, line: &str, shape: Shape, class: &str| {
        let each = combination
            .windows
            .iter()
            .filter_map(|window| Some(place(window, of(window)?)));
        let points: Vec<(f64, f64)> = each.collect();
        svg.path(&points, line);
        points
            .iter()
            .for_each(|point| marker(svg, shape, *point, class));
    };
    line(
        &|window| Some(window.fft_hz),
        "two",
        Shape::Triangle,
        "solid two",
    );
    line(
        &|window| window.own_all_hz,
        "three",
        Shape::Diamond,
        "solid three",
    );
    line(
        &|window| Some(window.least_squares_hz),
        "one",
        Shape::Square,
        "solid one fillone",
    );
}

/// Repeatability of both channels in every combination, beside the paper's ranges.
pub fn repeatability(combinations: &[Combination]) -> String {
    let mut svg = picture(340.0, "Repeatability");
    svg.text(
        22.0,
        26.0,
        Anchor::Start,
        "title",
        "Correlation of the runs of a combination (equation 11)",
    );
    for (n, ((least, most), (left, right))) in REPEATABILITY
        .into_iter()
        .zip([(62.0, 466.0), (538.0, 942.0)])
        .enumerate()
    {
        let frame = Frame::new(
            (left, 62.0, right, 250.0),
            (0.0, combinations.len() as f64),
            (0.75, 1.0),
        );
        let (_, top) = frame.at((0.0, most));
        let (_, bottom) = frame.at((0.0, least));
        svg.rect(left, top, right - left, bottom - top, "band");
        frame.grid(&mut svg, 5);
        svg.line((left, 250.0), (right, 250.0), "axis");
        svg.text(
            left - 40.0,
            53.0,
            Anchor::Start,
            "small",
            &format!("MEMS {}, piezoresistor 1", n + 1),
        );
        for (c, combination) in combinations.iter().enumerate() {
            let x = frame.x.place(c as f64 + 0.5);
            let name = combination.name();
            svg.text(x, 267.0, Anchor::Middle, "small", &name);
            if let Some(both) = combination.repeatability {
                let y = frame.y.place(both[n].clamp(0.75, 1.0));
                marker(&mut svg, Shape::Square, (x, y), "solid one fillone");
            }
        }
        svg.text(
            0.5 * (left + right),
            285.0,
            Anchor::Middle,
            "small",
            "combination",
        );
    }
    let entries = [
        (Sample::Marker(Shape::Square, "solid one fillone"), "here"),
        (Sample::Area("band"), "the paper's range"),
    ];
    key(&mut svg, 62.0, 322.0, &entries);
    svg.finish()
}
