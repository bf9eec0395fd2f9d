//! The whole path while the speed varies: SPI bytes in, cycles per millimetre out.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Scene, Sliding, SlidingScene};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Abscissa, Status};
use std::f64::consts::TAU;
use support::{Outcome, Stream, outcome, places, run_streamed};

const PERIOD_MM: f64 = 3.1;
/// Speed of the slide: mean and swing, mm/s, and seconds of a swing; twice that is the slide.
const MEAN_MM_S: f64 = 20.0;
const SWING_MM_S: f64 = 12.0;
const SWING_S: f64 = 1.5;

/// Place after a time of the slide, the integral of the speed. A robot that is on its way before
/// and after it has the mean speed there.
fn place_mm(since_s: f64) -> f64 {
    let swings = since_s.clamp(0.0, 2.0 * SWING_S) / SWING_S;
    let swung_mm = SWING_MM_S * SWING_S / TAU * (1.0 - (TAU * swings).cos());
    MEAN_MM_S * since_s + swung_mm
}

/// The paper's protocol, its slide played along [`place_mm`].
struct Varying(SlidingScene);

impl Scene for Varying {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let start_s = self.0.truth().slide_start_s;
        let since_s = (t_s - start_s).clamp(0.0, 2.0 * SWING_S);
        // The scene slides at the mean speed: at this time of its own it is at that place.
        let outside_s = t_s - start_s - since_s;
        let own_s = start_s + place_mm(since_s) / MEAN_MM_S;
        self.0.volts(input, own_s + outside_s)
    }

    fn end_s(&self) -> f64 {
        self.0.end_s()
    }
}

/// The slide, with the messages that `robot` makes of its begin, seconds.
fn slide(robot: impl Fn(f64) -> Stream) -> Outcome {
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
        stride_s: 0.1,
        ..Settings::DEFAULT
    };
    outcome(&run_streamed(Varying(scene), settings, robot(start_s)))
}

#[test]
fn by_place_every_window_gives_the_period() {
    let out = slide(|start_s| places(20.0, |t_s| place_mm(t_s - start_s)));
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
fn without_places_there_is_no_common_frequency() {
    let out = slide(|_| Stream::new());
    let spread = out
        .window_fits
        .iter()
        .filter(|fit| fit.status.has_tone())
        .map(|fit| fit.frequency);
    let (least, most) = spread.fold((f32::MAX, 0f32), |(l, m), f| (l.min(f), m.max(f)));
    assert!(most > 2.0 * least, "{least} to {most} Hz");
}
