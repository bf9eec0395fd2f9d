//! Event `feel`: vibrations whose spectrum has a closed form, at slow and at fast scans, and
//! through the whole path.

use ads1258::reading::volts;
use ridgetone_feel::Receptor;
use ridgetone_finger::Window;
use ridgetone_finger::internals::{FEEL_MEMORY, feel, image_ratio};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Feeling, Settings, TAXELS};
use ridgetone_proto::telemetry::{Feel, Hold, Image, Measured, NO_LEVEL, Pressed};
use ridgetone_tone::Table;
use std::f64::consts::TAU;

/// A hundredth of a volt is a micrometre from peak to peak.
const VOLTS_PER_UM: f32 = 0.01;

fn settings(plan: Plan) -> Settings {
    let feel = Feeling {
        volts_per_um: VOLTS_PER_UM,
        sigma_fraction: 0.1,
        force_ratio: 0.0,
    };
    Settings {
        feel,
        ..Settings::DEFAULT.with_plan(plan)
    }
}

/// A vibration of `um` micrometres in the taxels of a mask.
#[derive(Clone, Copy)]
struct Vibration {
    plan: Plan,
    frames: usize,
    hz: f64,
    um: f64,
    taxels: u16,
}

/// The event of a vibration with all its frames.
fn feel_of(vibration: Vibration) -> Option<Feel> {
    feel_with_gaps(vibration, |_| false, None)
}

/// The event of a vibration that lacks the frames of `is_missing`.
fn feel_with_gaps(
    vibration: Vibration,
    is_missing: impl Fn(usize) -> bool,
    force_ratio: Option<Measured>,
) -> Option<Feel> {
    let Vibration {
        plan,
        frames,
        hz,
        um,
        taxels,
    } = vibration;
    let rate_hz = f64::from(plan.frame_rate_hz());
    let amplitude = um * f64::from(VOLTS_PER_UM) / f64::from(volts(1, Settings::DEFAULT.vref_v));
    let value =
        |frame: usize| (500.0 + amplitude * (TAU * hz * frame as f64 / rate_hz + 0.4).cos()) as f32;
    let values: Vec<[f32; TAXELS]> = (0..frames)
        .map(|i| {
            if is_missing(i) {
                [0.0; TAXELS]
            } else {
                [value(i); TAXELS]
            }
        })
        .collect();
    let valid: Vec<u16> = (0..frames)
        .map(|i| if is_missing(i) { 0 } else { taxels })
        .collect();
    let window = Window {
        end_us: 7_000_000,
        frame_rate_hz: rate_hz as f32,
        force_ratio,
        ..Window::new(plan, frames as u32)
    };
    let mut source = Table {
        values: &values,
        valid: &valid,
    };
    feel(
        &window,
        &mut source,
        &mut [0.0; FEEL_MEMORY],
        &settings(plan),
    )
    .expect("a table loses no frames")
}

/// By equations 8 and 9: decades above the threshold, in the line's bin and in those beside it,
/// which Hamming's window gives 0.23 / 0.54 of the amplitude. They are three bins in the paper's
/// window of 3 s too, whose bins are a third of a hertz apart.
fn closed_form(receptor: Receptor, hz: f64, um: f64, bin_hz: f64) -> f64 {
    let bin = |place: f64, share: f64| {
        let threshold = receptor
            .threshold_um((hz + place * bin_hz) as f32)
            .map(f64::from)?;
        Some((um * share / threshold).log10().max(0.0))
    };
    [(-1.0, 0.23 / 0.54), (0.0, 1.0), (1.0, 0.23 / 0.54)]
        .into_iter()
        .filter_map(|(at, share)| bin(at, share))
        .sum::<f64>()
        / 3.0
}

#[test]
fn a_vibration_of_known_amplitude_fires_by_the_closed_form() {
    // Points of the transform, frames in a value.
    for (plan, points, stride) in [
        (Plan::PAPER, 128, 1),
        (Plan::HAND, 512, 1),
        (Plan::TEXTURE, 1024, 1),
        (Plan::VIBRATION, 1024, 3),
        (Plan::SINGLE, 1024, 7),
    ] {
        let rate_hz = f64::from(plan.frame_rate_hz());
        // Longer slides have windows as long.
        let frames = points * stride + 777;
        let bin_hz = rate_hz / (stride * points) as f64;
        for (cycles, um) in [(20.0, 300.0), (55.0, 90.0)] {
            let hz = cycles * bin_hz;
            let found = feel_of(Vibration {
                plan,
                frames,
                hz,
                um,
                taxels: 0x00f3,
            })
            .expect("an event");
            // Taxels that are not converted are not looked at.
            assert_eq!(
                (found.taxels, found.t_us),
                (0x00f3 & plan.inputs, 7_000_000)
            );
            assert!((f64::from(found.rate_hz) * stride as f64 / rate_hz - 1.0).abs() < 1e-6);
            assert!((f64::from(found.window_s) * bin_hz - 1.0).abs() < 1e-6);
            for (receptor, per_hz) in Receptor::ALL.into_iter().zip(found.per_hz) {
                let is_too_fast =
                    2.0 * f64::from(receptor.corners_hz()[2]) >= rate_hz / stride as f64;
                assert_eq!(per_hz.is_none(), is_too_fast, "{receptor:?} at {rate_hz}");
                let Some(per_hz) = per_hz else { continue };
                let expected = closed_form(receptor, hz, um, bin_hz);
                assert!(
                    (f64::from(per_hz.value) - expected).abs() < 2e-3 * expected + 1e-3,
                    "{receptor:?} at {rate_hz}, {hz} Hz: {} {expected}",
                    per_hz.value
                );
                // A tenth of the conversion in every bin that fires.
                assert!(expected == 0.0 || per_hz.sigma > 0.0);
            }
            let loudest = (0..found.levels_db.len())
                .max_by_key(|band| found.levels_db[*band])
                .unwrap();
            assert!((ridgetone_feel::band_hz(loudest) / hz as f32).log2().abs() < 0.5 / 3.0 + 1e-3);
            assert!((f64::from(found.levels_db[loudest]) - 20.0 * um.log10()).abs() <= 0.51);
        }
    }
}

#[test]
fn what_is_not_there_is_absent_and_never_zero() {
    let vibration = Vibration {
        plan: Plan::PAPER,
        frames: 200,
        hz: 30.0,
        um: 50.0,
        taxels: u16::MAX,
    };
    let short = Vibration {
        frames: 127,
        ..vibration
    };
    assert_eq!(feel_of(short), None, "a slide shorter than the transform");
    let untouched = Vibration {
        taxels: 0,
        ..vibration
    };
    assert_eq!(feel_of(untouched), None, "no taxel");
    let dead = Vibration {
        um: 0.0,
        ..vibration
    };
    assert_eq!(feel_of(dead), None, "dead taxels");
    let found = feel_of(vibration).unwrap();
    assert_eq!(
        found.per_hz.map(|found| found.is_some()),
        [true, false, true, false],
        "FA II and SA II need 1600 and 800 Hz"
    );
    assert!(found.soft.is_some() && found.rough.is_none() && found.force_ratio.is_none());
    assert_eq!(
        found.levels_db[0], NO_LEVEL,
        "no line below 1.9 Hz in half a second"
    );
}

#[test]
fn missing_frames_are_bridged_and_forces_make_a_score() {
    let ratio = Measured {
        value: 1.4,
        sigma: 0.1,
    };
    let vibration = Vibration {
        plan: Plan::TEXTURE,
        frames: 1024,
        hz: 40.0,
        um: 80.0,
        taxels: u16::MAX,
    };
    let whole = feel_with_gaps(vibration, |_| false, Some(ratio)).unwrap();
    let holed = feel_with_gaps(vibration, |i| i < 3 || i % 50 == 7, Some(ratio)).unwrap();
    for (whole, holed) in whole.per_hz.into_iter().zip(holed.per_hz).take(1) {
        let (whole, holed) = (whole.unwrap().value, holed.unwrap().value);
        assert!((holed / whole - 1.0).abs() < 0.2, "{whole} {holed}");
    }
    let rough = whole.rough.expect("forces are known");
    // Equation 12 has 11.633 a unit of M.
    assert!(rough.sigma >= 1.1633 && whole.force_ratio == Some(ratio));
}

#[test]
fn forces_come_from_the_image() {
    let taxels = [0.5f32, 0.2, 0.1, 0.4].into_iter().enumerate();
    let pressed = |(k, level_v): (usize, f32)| Pressed {
        taxel: 8 + k as u8,
        level_v,
        sigma_v: 0.001,
    };
    let mut image = Image {
        start_us: 0,
        end_us: 1,
        frames: 100,
        hold: Hold::BeforeSlide,
        taxels: taxels.map(pressed).collect(),
    };
    // Along 0.4, across -0.2, pressure 1.2 (equation 10).
    let found = image_ratio(&image).expect("a unit");
    assert!((found.value - 0.4f32.hypot(0.2) / 1.2).abs() < 1e-6 && found.sigma > 0.0);
    image.taxels.pop();
    assert_eq!(image_ratio(&image), None, "no unit is whole");
}
