//! The whole path while the speed varies: SPI bytes in, cycles per millimetre out.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Scene, Sliding, SlidingScene};
use ridgetone::surface::profile::Profile;
use ridgetone_proto::profile::{After, KNOTS_MAX, Knot};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Abscissa, Status};
use std::f64::consts::TAU;
use support::{Outcome, all, outcome, run_along};

const PERIOD_MM: f64 = 3.1;
/// Speed of the slide: mean and swing, mm/s, and seconds of a swing; twice that is the slide.
const MEAN_MM_S: f64 = 20.0;
const SWING_MM_S: f64 = 12.0;
const SWING_S: f64 = 1.5;

fn speed_mm_s(since_s: f64) -> f64 {
    MEAN_MM_S + SWING_MM_S * (TAU * since_s / SWING_S).sin()
}

/// The paper's protocol, its slide played at [`speed_mm_s`].
struct Varying(SlidingScene);

impl Scene for Varying {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let start_s = self.0.truth().slide_start_s;
        // In closed form, which the library's knots only follow.
        let since_s = (t_s - start_s).clamp(0.0, 2.0 * SWING_S);
        let swung_mm = SWING_MM_S * SWING_S / TAU * (1.0 - (TAU * since_s / SWING_S).cos());
        let place_mm = MEAN_MM_S * since_s + swung_mm;
        // The scene slides at the mean speed: at this time of its own it is at that place.
        let outside_s = t_s - start_s - since_s;
        self.0
            .volts(input, start_s + place_mm / MEAN_MM_S + outside_s)
    }

    fn end_s(&self) -> f64 {
        self.0.end_s()
    }
}

fn slide(profile: impl Fn(f64) -> Option<Profile>) -> Outcome {
    let parameters = Sliding {
        speed_mm_s: MEAN_MM_S,
        period_mm: PERIOD_MM,
        slide_mm: 2.0 * SWING_S * MEAN_MM_S,
        ..Sliding::default()
    };
    let scene = SlidingScene::new(parameters).unwrap();
    let start_s = scene.truth().slide_start_s;
    let settings = Settings {
        window_s: 0.7,
        hop_s: 0.1,
        ..Settings::DEFAULT
    };
    outcome(&run_along(Varying(scene), settings, profile(start_s), all))
}

/// The profile of a host: speeds at as many times as a profile holds, which lead to the right
/// places. Chords of a sine are too short by their length squared over twelve; uncorrected, they
/// alone would make errors of 1 %.
fn profile(start_s: f64) -> Option<Profile> {
    let step = TAU * 2.0 / (KNOTS_MAX - 1) as f64;
    let longer = 1.0 / (1.0 - step * step / 12.0);
    let speed_mm_s = |since_s| MEAN_MM_S + longer * (speed_mm_s(since_s) - MEAN_MM_S);
    let knots: Vec<Knot> = (0..KNOTS_MAX)
        .map(|k| {
            let since_s = 2.0 * SWING_S * k as f64 / (KNOTS_MAX - 1) as f64;
            Knot {
                t_us: ((start_s + since_s) * 1e6) as u32,
                speed_mm_s: speed_mm_s(since_s) as f32,
            }
        })
        .collect();
    Some(Profile::new(&knots, After::Hold).unwrap())
}

#[test]
fn with_a_profile_every_window_gives_the_period() {
    let out = slide(profile);
    assert!(out.window_fits.len() > 15, "{}", out.window_fits.len());
    for fit in out.window_fits.iter().chain(&out.slide_fits) {
        assert_eq!(
            (fit.abscissa, fit.status),
            (Abscissa::Place, Status::Good),
            "{fit:?}"
        );
        let off = 1.0 / (fit.frequency as f64 * PERIOD_MM) - 1.0;
        let sigma = (fit.sigma / fit.frequency) as f64;
        // A window is off by half a part in a thousand at most; treating a scan as a moment would
        // cost four.
        assert!(off.abs() < 4.0 * sigma && sigma < 0.0005, "{off} {fit:?}");
    }
    let off = 1.0 / (out.slide_fits[0].frequency as f64 * PERIOD_MM) - 1.0;
    assert!(off.abs() < 0.0001, "{off}");
}

#[test]
fn without_one_there_is_no_common_frequency() {
    let out = slide(|_| None);
    let spread = out
        .window_fits
        .iter()
        .filter(|fit| fit.status.has_tone())
        .map(|fit| fit.frequency);
    let (least, most) = spread.fold((f32::MAX, 0f32), |(l, m), f| (l.min(f), m.max(f)));
    assert!(most > 2.0 * least, "{least} to {most} Hz");
}
