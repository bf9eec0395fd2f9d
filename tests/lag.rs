//! Tests spatial period, speed and direction of a plane wave that is sampled slot by slot, and
//! their uncertainties.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod reference;

use reference::{Noise, codes};
use ridgetone_finger::Window;
use ridgetone_finger::internals::{Fitted, Tracker, by_phases, fit, lag};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Array, FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Direction, Travel, TravelStatus};
use ridgetone_tone::{Fitter, Status, Table};
use std::f64::consts::TAU;

/// Slots of a scan (datasheet SBAS297G, auto-scan: 16 inputs and the five internal readings).
const SLOTS: f64 = 21.0;
/// Array whose channels respond to the wave only at their position.
const ARRAY: Array = Array {
    pitch_mm: 2.3,
    edge_phase_rad: 0.0,
    edge_phase_sigma_rad: 0.0,
    ..Array::DEFAULT
};

/// A wave that passes under the channels; amplitude and noise in codes.
#[derive(Clone, Copy)]
struct Wave {
    speed_mm_s: f64,
    period_mm: f64,
    backward: bool,
    frames: usize,
    amplitude: f64,
    /// Ratio of the second harmonic's amplitude to the fundamental's.
    overtone: f64,
    noise: f64,
    seed: u64,
    /// True if one channel is dead and one has thirty times the noise.
    damaged: bool,
}

const WAVE: Wave = Wave {
    speed_mm_s: 30.0,
    period_mm: 3.1,
    backward: false,
    frames: 241,
    amplitude: 1000.0,
    overtone: 0.3,
    noise: 70.7, // 20 dB below the tone
    seed: 1,
    damaged: false,
};

impl Wave {
    fn values(&self) -> Vec<[f32; 16]> {
        let mut noise = Noise::new(self.seed);
        let start_mm = self.period_mm * 0.618_034 * self.seed as f64;
        let way = if self.backward { -1.0 } else { 1.0 };
        codes(self.frames, |c, frame| {
            let t_s = (frame + c as f64 / SLOTS) / f64::from(FRAME_RATE_HZ);
            let ridge_mm = start_mm + way * self.speed_mm_s * t_s;
            let position_mm = if c / 4 % 2 == 1 { 2.3 } else { 0.0 };
            let theta = TAU * (ridge_mm - position_mm) / self.period_mm;
            // Channels differ in strength, sign and phase.
            let (gain, own) = [(1.0, 0.0), (0.4, 0.9), (-0.9, 0.2), (0.3, -1.3)][c % 4];
            let wave = (theta + own).cos() + self.overtone * (2.0 * theta + own).cos();
            let noise = self.noise * noise.next();
            match c {
                5 if self.damaged => 0.0,
                0 if self.damaged => gain * self.amplitude * wave + 30.0 * noise,
                _ => gain * self.amplitude * wave + noise,
            }
        })
    }

    fn fitted(&self, tracker: &mut Tracker) -> Fitted {
        let values = self.values();
        let mut table = Table {
            values: &values,
            valid: &vec![u16::MAX; values.len()],
        };
        let window = Window {
            frame_rate_hz: FRAME_RATE_HZ,
            ..Window::new(Plan::PAPER, self.frames as u32)
        };
        let fitter = &mut Box::new(Fitter::new());
        let fit = fit(fitter, tracker, &window, &mut table, &Settings::DEFAULT);
        fit.expect("all frames are there")
    }
}

fn travel(fitted: &Fitted, array: &Array) -> Travel {
    let fit = &fitted.fit;
    by_phases(
        lag(fitted, array),
        array,
        (
            fit.frequency * fitted.frame_rate_hz,
            fit.sigma * fitted.frame_rate_hz,
        ),
    )
}

type Change<T> = fn(&mut T);

#[test]
fn uncertainties_are_the_spread_of_a_thousand_windows() {
    let mut tracker = Tracker::new();
    let waves: [(&str, Change<Wave>); 6] = [
        ("20 dB", |_| ()),
        ("6 dB, backward", |wave| {
            (wave.noise, wave.backward) = (354.0, true)
        }),
        ("0.4 s", |wave| {
            (wave.frames, wave.speed_mm_s, wave.period_mm) = (97, 48.0, 2.6)
        }),
        ("C1", |wave| (wave.speed_mm_s, wave.period_mm) = (15.0, 3.6)),
        ("one and a half cycles", |wave| {
            (wave.frames, wave.speed_mm_s) = (75, 15.0)
        }),
        ("a dead and a noisy channel", |wave| wave.damaged = true),
    ];
    for (name, change) in waves {
        let mut wave = WAVE;
        change(&mut wave);
        let (runs, mut covered, mut squares, mut others) = (1000, [0; 2], [0.0; 2], 0);
        for seed in 1..=runs {
            let wave = Wave { seed, ..wave };
            let fitted = wave.fitted(&mut tracker);
            let travel = travel(&fitted, &ARRAY);
            // Tests for competing tones reject a few right fits.
            if fitted.fit.status != Status::Good {
                others += 1;
                continue;
            }
            let way = [Direction::Forward, Direction::Backward][usize::from(wave.backward)];
            let found = (travel.status, travel.direction);
            assert_eq!(
                found,
                (TravelStatus::Unique, way),
                "{name}, seed {seed}: {travel:?}"
            );
            for (which, (found, sigma, truth)) in [
                (
                    travel.spatial_period_mm,
                    travel.spatial_period_sigma_mm,
                    wave.period_mm,
                ),
                (travel.speed_mm_s, travel.speed_sigma_mm_s, wave.speed_mm_s),
            ]
            .into_iter()
            .enumerate()
            {
                let off = (f64::from(found) - truth) / f64::from(sigma);
                covered[which] += (off.abs() < 1.96) as u32;
                squares[which] += off * off;
            }
        }
        // At most 1 %, plus three standard deviations.
        assert!(others <= 20, "{name}: {others} of 1000 are not good");
        let good = f64::from(runs as u32 - others);
        for which in 0..2 {
            let spread = (squares[which] / good).sqrt();
            // The noise of a short window is estimated from few bins, so some sigmas are too small:
            // the spread slightly exceeds one, and the 95 % intervals cover the truth in 92 to 98 %
            // of the runs.
            let coverage = f64::from(covered[which]) / good;
            assert!((0.93..1.12).contains(&spread), "{name}: spread {spread}");
            assert!(
                (0.92..=0.98).contains(&coverage),
                "{name}: coverage {coverage}"
            );
        }
    }
}

/// A dead and a noisy channel cost only the information that they carried.
#[test]
fn dead_and_noisy_channels_do_not_hurt() {
    let mut tracker = Tracker::new();
    let mut sigma = |damaged| {
        let wave = Wave { damaged, ..WAVE };
        f64::from(travel(&wave.fitted(&mut tracker), &ARRAY).spatial_period_sigma_mm)
    };
    let (whole, damaged) = (sigma(false), sigma(true));
    // The weight of a strength is its square: 1, 0.16, 0.81 or 0.09, each in two channels per
    // column. If one of the two fails in one column, 2 * 1 / (2 + 1) = 2/3 of the weight remains.
    let expected = (2.06f64 / (0.81 + 0.09 + 2.0 / 3.0 * 1.16)).sqrt();
    let ratio = damaged / whole;
    assert!(
        (ratio / expected - 1.0).abs() < 0.1,
        "{ratio} instead of {expected}"
    );
}

/// The closed form is the standard deviation of the difference of two phases, of variance 2 sigma^2
/// / (N A^2) each (Rife and Boorstyn 1974, for a known tone with unknown offset and slope), times
/// period^2 / (2 pi pitch).
#[test]
fn the_uncertainty_is_that_of_the_closed_form() {
    let travel = travel(&WAVE.fitted(&mut Tracker::new()), &ARRAY);
    let strengths: f64 = [1.0, 0.16, 0.81, 0.09].iter().sum::<f64>() * 2.0;
    let variance = 2.0
        * (2.0 * WAVE.noise * WAVE.noise / (241.0 * WAVE.amplitude * WAVE.amplitude))
        / strengths;
    let sigma_mm = WAVE.period_mm * WAVE.period_mm / (TAU * 2.3) * variance.sqrt();
    let off = f64::from(travel.spatial_period_sigma_mm) / sigma_mm - 1.0;
    assert!(off.abs() < 0.05, "{travel:?} instead of {sigma_mm}");
}

/// Two channels are read four slots apart, which at 92 Hz is 7 % of a turn. Ignoring this skew
/// causes an error above 5 %, with opposite signs in the two directions.
#[test]
fn a_fast_grating_comes_out_wrong_without_the_skew_of_the_slots() {
    let mut tracker = Tracker::new();
    for backward in [false, true] {
        for period_mm in [2.6, 3.1, 3.6] {
            let wave = Wave {
                speed_mm_s: 92.0 * period_mm,
                period_mm,
                backward,
                overtone: 0.0,
                ..WAVE
            };
            let fitted = wave.fitted(&mut tracker);
            let right = travel(&fitted, &ARRAY);
            let off = |travel: &Travel| f64::from(travel.spatial_period_mm) / period_mm - 1.0;
            assert_eq!(right.status, TravelStatus::Unique);
            assert!(off(&right).abs() < 5e-3, "{right:?} instead of {period_mm}");
            let speed_off = f64::from(right.speed_mm_s) / wave.speed_mm_s - 1.0;
            assert!(speed_off.abs() < 5e-3, "{right:?}");
            let per_slot = 0.0;
            let unskewed = travel(&Fitted { per_slot, ..fitted }, &ARRAY);
            let is_wrong = unskewed.status != TravelStatus::Unique || off(&unskewed).abs() > 0.05;
            assert!(is_wrong, "{unskewed:?}");
        }
    }
}

/// No lag must be reported with only one column, without a tone in one of the columns, or if no
/// taxels respond alike in both.
#[test]
fn without_two_columns_there_is_nothing() {
    let mut fitted = WAVE.fitted(&mut Tracker::new());
    let status = |fitted: &Fitted, array: &Array| travel(fitted, array).status;
    let with_front = |front| Array { front, ..ARRAY };
    let alike = [0; 4];
    for array in [
        with_front(0),
        with_front(u16::MAX),
        Array { alike, ..ARRAY },
    ] {
        assert_eq!(status(&fitted, &array), TravelStatus::Nothing);
    }
    fitted.fit.usable = 0x0f0f;
    assert_eq!(status(&fitted, &ARRAY), TravelStatus::Nothing);
    // One channel in each column is enough, whatever its phase.
    fitted.fit.usable = 0x0011;
    assert_eq!(status(&fitted, &ARRAY), TravelStatus::Unique);
    let sure = lag(&fitted, &ARRAY).expect("a lag").sigma;
    for _ in 0..100 {
        for taxel in [0, 4] {
            fitted.fit.channels[taxel].phase_rad += 0.37;
        }
        let sigma = lag(&fitted, &ARRAY).expect("a lag").sigma;
        assert!((sigma / sure - 1.0).abs() < 1e-3, "{sigma} {sure}");
    }
}

/// If channels disagree by more than their noise, the uncertainty is computed from their scatter.
#[test]
fn channels_that_disagree_are_less_certain() {
    let mut fitted = WAVE.fitted(&mut Tracker::new());
    let sure = lag(&fitted, &ARRAY).expect("a lag").sigma;
    for taxel in [0, 2, 13] {
        fitted.fit.channels[taxel].phase_rad += 0.2;
    }
    let unsure = lag(&fitted, &ARRAY).expect("a lag").sigma;
    assert!(unsure > 3.0 * sure, "{unsure} {sure}");
}
