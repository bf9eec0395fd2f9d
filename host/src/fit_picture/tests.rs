//! Tests the words and shapes in pictures of synthetic recordings.

use super::*;
use crate::table_fit;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Returns noise from -0.5 to 0.5 for the reading with this number (SplitMix64).
fn noise(number: usize) -> f64 {
    let mut bits = (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ bits >> 31) >> 11) as f64 * 2f64.powi(-53) - 0.5
}

/// Returns a number from the picture's headline.
fn found(svg: &str, name: &str) -> f64 {
    let (_, after) = svg.split_once(&format!(">{name}: ")).unwrap();
    let (number, _) = after.split_once(' ').unwrap();
    number.parse().unwrap()
}

/// Makes a tone of 8 Hz at 250 rows per second in each channel.
fn tone(channels: usize, limit: f64) -> Samples {
    let value = move |row: usize, channel: usize| {
        let t_s = row as f64 / 250.0;
        let noise = noise(16 * row + channel);
        let wave = (TAU * 8.0 * t_s + channel as f64).sin();
        (wave + 0.2 * (2.0 * TAU * 8.0 * t_s).cos() + 0.05 * noise).clamp(-limit, limit)
    };
    let names = (0..channels).map(|channel| format!("force <{channel}>"));
    Samples::array("tone", names.collect(), 1000, Arc::new(value), None)
}

fn drawn(samples: &Samples) -> String {
    let selection = Selection {
        rate_hz: Some(250.0),
        ..Selection::default()
    };
    let mut rows = samples.open().unwrap();
    let fit = table_fit::fit(&mut *rows, &selection, &mut |_| {}).unwrap();
    draw(samples, &selection, &fit).unwrap()
}

#[test]
fn every_number_of_channels_has_its_strips_and_no_place_that_is_no_number() {
    for channels in [1, 2, 5, 16] {
        let svg = drawn(&tone(channels, 10.0));
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{channels}");
        assert_eq!(svg.matches(">force &lt;").count(), channels);
        assert_eq!(svg.matches("class=\"fit\"").count(), channels + 1);
        assert!((found(&svg, "tone") - 8.0).abs() < 0.002);
        assert!(svg.contains("noise next to them"));
        assert!(!svg.contains("clipped"));
    }
}

#[test]
fn clipped_channels_have_a_word() {
    let svg = drawn(&tone(3, 0.6));
    assert!(svg.contains("All channels are clipped"), "{svg}");
    assert!(drawn(&tone(1, 0.6)).contains("The channel is clipped"));
}

#[test]
fn a_recording_without_a_tone_is_a_picture_too() {
    let white = |row: usize, _: usize| noise(row);
    let samples = Samples::array("noise", vec!["a".into()], 500, Arc::new(white), None);
    for samples in [
        samples,
        Samples::array("still", vec!["a".into()], 50, Arc::new(|_, _| 1.0), None),
    ] {
        let svg = drawn(&samples);
        assert!(svg.contains(": no tone") && !svg.contains("NaN") && !svg.contains("inf"));
    }
}
