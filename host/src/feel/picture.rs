//! The picture of `feel`: the spectrum under its thresholds.

use super::measure::Felt;
use crate::digits::significant;
use crate::picture::layout::thinned;
use crate::svg::{Anchor, Svg};
use ridgetone_feel::Receptor;

const STYLE: &str = "text{font:12px system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:#222}\
.title{font-size:17px;font-weight:600}.small{font-size:11px;fill:#555}path{fill:none}.card{fill:#fff;stroke:#bbb}\
.axis{stroke:#555}.grid{stroke:#e2e2e2}.data{stroke:#667;stroke-width:.9;stroke-linejoin:round}\
.r0,.r1,.r2,.r3{stroke-width:2}.r0{stroke:#0064a4}.r1{stroke:#c4480a;stroke-dasharray:7 3}\
.r2{stroke:#00795a;stroke-dasharray:2 3}.r3{stroke:#a01050;stroke-dasharray:9 3 2 3}";

/// The frame, pixels.
const LEFT: f64 = 74.0;
const RIGHT: f64 = 900.0;
const TOP: f64 = 96.0;
const BOTTOM: f64 = 470.0;
/// The receptors' range, hertz, from decade to decade, with what is above 0.5 Hz.
const FROM_HZ: f64 = 0.5;
const TO_HZ: f64 = 1000.0;
/// Most decades from top to bottom: what is lower is far below every threshold.
const DECADES_MAX: f64 = 9.0;

/// Draws the mean spectrum of the channels in micrometres, with the four thresholds over their
/// ranges.
pub fn draw(felt: &Felt) -> String {
    let bin_hz = felt.bin_hz();
    let points: Vec<(f64, f64)> = felt
        .spectrum_um
        .iter()
        .enumerate()
        .skip(1)
        .map(|(k, um)| (k as f64 * bin_hz, *um))
        .collect();
    let visible = points
        .iter()
        .filter(|(hz, um)| (FROM_HZ..=TO_HZ).contains(hz) && *um > 0.0)
        .map(|(_, um)| um.log10());
    // The lowest and the highest threshold are in it.
    let (least, most) = visible.fold((-1.5, 3.0), |(least, most): (f64, f64), log| {
        (least.min(log), most.max(log))
    });
    let (least, most) = (least.floor().max(most.ceil() - DECADES_MAX), most.ceil());
    let x = |hz: f64| LEFT + (RIGHT - LEFT) * (hz / FROM_HZ).log10() / (TO_HZ / FROM_HZ).log10();
    let y =
        |um: f64| BOTTOM + (TOP - BOTTOM) * ((um.log10() - least) / (most - least)).clamp(0.0, 1.0);

    let mut svg = Svg::new(
        940.0,
        520.0,
        &format!("What a finger feels: {}", felt.file),
        STYLE,
    );
    svg.text(
        24.0,
        30.0,
        Anchor::Start,
        "title",
        "Amplitude spectrum and the thresholds of four receptors",
    );
    for power in least as i32..=most as i32 {
        let um = 10f64.powi(power);
        svg.line((LEFT, y(um)), (RIGHT, y(um)), "grid");
        svg.text(
            LEFT - 7.0,
            y(um) + 4.0,
            Anchor::End,
            "small",
            &significant(um, 1),
        );
    }
    svg.text(
        LEFT - 50.0,
        TOP - 10.0,
        Anchor::Start,
        "small",
        "um from peak to peak",
    );
    for hz in [
        0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0,
    ] {
        svg.line((x(hz), BOTTOM), (x(hz), BOTTOM + 4.0), "axis");
        svg.text(
            x(hz),
            BOTTOM + 17.0,
            Anchor::Middle,
            "small",
            &hz.to_string(),
        );
    }
    svg.text(
        0.5 * (LEFT + RIGHT),
        BOTTOM + 36.0,
        Anchor::Middle,
        "small",
        "frequency, Hz",
    );
    svg.line((LEFT, BOTTOM), (RIGHT, BOTTOM), "axis");
    svg.line((LEFT, BOTTOM), (LEFT, TOP), "axis");
    let inside = points
        .iter()
        .filter(|(hz, um)| (FROM_HZ..=TO_HZ).contains(hz) && *um > 0.0);
    svg.path(
        &thinned(&inside.map(|(hz, um)| (x(*hz), y(*um))).collect::<Vec<_>>()),
        "data",
    );
    for (number, receptor) in Receptor::ALL.into_iter().enumerate() {
        let class = format!("r{number}");
        let ends = receptor.threshold_ends();
        let corners: Vec<(f64, f64)> = ends
            .as_flattened()
            .iter()
            .map(|(hz, um)| (x((*hz).into()), y((*um).into())))
            .collect();
        svg.path(&corners, &class);
        let left = 24.0 + 220.0 * number as f64;
        svg.line((left, 56.0), (left + 30.0, 56.0), &class);
        let fires = match felt.firing.mean().intensity[number] {
            Some(intensity) => significant((intensity * bin_hz as f32).into(), 3),
            None => "absent".to_owned(),
        };
        svg.text(
            left + 38.0,
            60.0,
            Anchor::Start,
            "label",
            &format!("{}: {fires} per hertz", receptor.name()),
        );
    }
    svg.finish()
}
