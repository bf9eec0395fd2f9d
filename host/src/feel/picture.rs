//! The picture of `feel`: the spectrum under its thresholds.

use super::measure::Felt;
use crate::chart::{Curve, Look, Panel, Scale, chart};
use crate::digits::significant;
use ridgetone_feel::Receptor;

/// The receptors' range, hertz, from decade to decade, with what is above 0.5 Hz.
const FROM_HZ: f64 = 0.5;
const TO_HZ: f64 = 1000.0;
/// Most decades from top to bottom: what is lower is far below every threshold.
const DECADES_MAX: f64 = 9.0;

/// Draws the mean spectrum of the channels in micrometres, with the four thresholds over their
/// ranges.
pub fn draw(felt: &Felt) -> String {
    let bin_hz = felt.bin_hz();
    let lines = felt.spectrum_um.iter().enumerate().skip(1);
    let points: Vec<(f64, f64)> = lines
        .map(|(k, um)| (k as f64 * bin_hz, *um))
        .filter(|(hz, um)| (FROM_HZ..=TO_HZ).contains(hz) && *um > 0.0)
        .collect();
    // The lowest and the highest threshold are in it.
    let decades = points.iter().map(|(_, um)| um.log10());
    let (least, most) = decades.fold((-1.5, 3.0), |(least, most): (f64, f64), log| {
        (least.min(log), most.max(log))
    });
    let (least, most) = (least.floor().max(most.ceil() - DECADES_MAX), most.ceil());
    let mut curves = vec![Curve {
        name: "spectrum".to_owned(),
        look: Look::Data,
        points,
    }];
    for (number, receptor) in Receptor::ALL.into_iter().enumerate() {
        let fires = match felt.firing.mean().intensity[number] {
            Some(intensity) => {
                let per_hz = significant(f64::from(intensity) / felt.as_window_s, 3);
                format!("intensity {per_hz} a hertz")
            }
            None => "not known".to_owned(),
        };
        let ends = receptor.threshold_ends();
        curves.push(Curve {
            name: format!("{} threshold, {fires}", receptor.name()),
            look: Look::Line(number),
            points: ends
                .as_flattened()
                .iter()
                .map(|(hz, um)| ((*hz).into(), (*um).into()))
                .collect(),
        });
    }
    let scale = |label: &str, range| Scale {
        label: label.into(),
        is_log: true,
        range: Some(range),
        ..Scale::default()
    };
    let panel = Panel {
        title: "Amplitude spectrum and the thresholds of four receptors".into(),
        x: scale("frequency, Hz", (FROM_HZ, TO_HZ)),
        y: scale(
            "um from peak to peak",
            (10f64.powf(least), 10f64.powf(most)),
        ),
        curves,
    };
    chart(&format!("What a finger feels: {}", felt.file), &[panel])
}
