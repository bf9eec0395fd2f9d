//! The static images: four by four taxels before and after the slide, for each grating.

use super::results::Combination;
use crate::plot::picture;
use ridgetone_host::static_image::PLACES;
use ridgetone_host::svg::{Anchor, Svg};

/// Side of a taxel's cell, pixels.
const CELL: f64 = 46.0;
/// From one map to the next, pixels.
const PITCH: f64 = 228.0;

/// One column for each grating at its slowest speed; above before, below after the slide.
pub fn images(combinations: &[Combination]) -> String {
    let shown: Vec<&Combination> = slowest(combinations);
    let mut svg = picture(530.0, "Static images before and after the slide");
    svg.text(
        22.0,
        26.0,
        Anchor::Start,
        "title",
        "Static images, mV above idle",
    );
    let values = shown
        .iter()
        .flat_map(|c| c.runs.first())
        .flat_map(|run| run.images_v.iter().flatten());
    let most = values.fold(0.0_f64, |most, volts| most.max(volts.abs()));
    for (column, combination) in shown.iter().enumerate() {
        let left = 34.0 + PITCH * column as f64;
        let name = combination
            .number()
            .map_or_else(String::new, |c| format!("C{}: ", c + 1));
        svg.text(
            left,
            52.0,
            Anchor::Start,
            "cell",
            &format!("{name}grating of {} mm", combination.period_mm),
        );
        let Some(run) = combination.runs.first() else {
            continue;
        };
        for (row, (image, when)) in run
            .images_v
            .iter()
            .zip(["before the slide", "after the slide"])
            .enumerate()
        {
            let top = 76.0 + 222.0 * row as f64;
            svg.text(left, top - 8.0, Anchor::Start, "small", when);
            map(&mut svg, image, (left, top), most);
        }
    }
    let text = "Each block of four is a MEMS unit, 1 and 2 above 3 and 4; in it piezoresistors 1, 2 above 4, 3.";
    svg.text(
        34.0,
        512.0,
        Anchor::Start,
        "small",
        &format!("{text} The grating moves from right to left."),
    );
    svg.finish()
}

/// The combinations with the least speed of each grating, the finest first.
fn slowest(combinations: &[Combination]) -> Vec<&Combination> {
    let mut sorted: Vec<&Combination> = combinations.iter().collect();
    sorted.sort_by(|a, b| {
        a.period_mm
            .total_cmp(&b.period_mm)
            .then(a.speed_mm_s.total_cmp(&b.speed_mm_s))
    });
    sorted.dedup_by(|a, b| a.period_mm == b.period_mm);
    sorted
}

fn map(svg: &mut Svg, image: &[f64], (left, top): (f64, f64), most: f64) {
    if image.is_empty() {
        svg.text(left, top + 20.0, Anchor::Start, "small", "not found");
    }
    let places = PLACES
        .iter()
        .enumerate()
        .flat_map(|(row, line)| line.iter().zip(0..).map(move |at| (row, at)));
    for (row, (taxel, column)) in places {
        let Some(volts) = image.get(*taxel) else {
            continue;
        };
        // A gap between the units.
        let gap = |n: usize| CELL * n as f64 + if n > 1 { 6.0 } else { 0.0 };
        let (x, y) = (left + gap(column), top + gap(row));
        let share = if most > 0.0 { volts.abs() / most } else { 0.0 };
        let class = if *volts < 0.0 { "minus" } else { "plus" };
        let (side, opacity) = (CELL - 1.0, 0.75 * share);
        svg.push(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side:.1}\" height=\"{side:.1}\" class=\"{class}\" fill-opacity=\"{opacity:.2}\"/>"
        ));
        svg.text(
            x + 0.5 * CELL,
            y + 0.5 * CELL + 4.0,
            Anchor::Middle,
            "cell",
            &format!("{:+.1}", tenths(1e3 * volts)),
        );
    }
}

/// To a tenth, and never a zero with a minus.
fn tenths(mv: f64) -> f64 {
    (10.0 * mv).round() / 10.0 + 0.0
}
