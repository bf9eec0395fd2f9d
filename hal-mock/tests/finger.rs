//! Compares the physical finger with a direct sum of line loads, and with the paper's observations.

mod common;

use common::{next, write};
use hal_mock::{Ads1258, Finger, Hand, Options, Scene, Sliding, SlidingScene, Stimulator, TABLE_2};
use std::f64::consts::{PI, TAU};

fn exact(finger: Finger) -> Finger {
    Finger {
        spread: 0.0,
        resistance_spread: 0.0,
        ..finger
    }
}

fn still(scene: Sliding) -> SlidingScene {
    let finger = scene.finger.map(exact);
    SlidingScene::new(Sliding { finger, ..scene }).unwrap()
}

/// Creates a physical scene without spread, on a grating of `period_mm`.
fn on_grating(period_mm: f64, finger: Finger) -> SlidingScene {
    let finger = Some(finger);
    still(Sliding {
        period_mm,
        finger,
        ..Sliding::physical()
    })
}

fn phase_rad(scene: &SlidingScene, input: usize) -> f64 {
    scene.channels()[input].sliding.tone[0].phase_rad()
}

/// Phase lag between the units in excess of the lag of the 2.3 mm pitch, from -pi to pi.
fn beyond_pitch_rad(scene: &SlidingScene, input: usize, period_mm: f64) -> f64 {
    let apart = phase_rad(scene, input + 4) - phase_rad(scene, input);
    (apart + TAU * 2.3 / period_mm + PI).rem_euclid(TAU) - PI
}

/// Inputs with their sensor's position in mm and their sign for shear.
const SENSORS: [(u8, f64, f64); 4] = [
    (0, -1.15, 1.0),
    (2, -1.15, -1.0),
    (3, -1.15, 0.0),
    (4, 1.15, 1.0),
];

/// A line load on the elastic half plane: its position and pressure.
struct Line {
    at_mm: f64,
    press: f64,
}

impl Line {
    /// Creates one line of a parabolic load centred at `lean_mm`; ridges carry `fraction` times as
    /// much as without grooves. `None` outside the contact.
    fn new(finger: &Finger, at_mm: f64, lean_mm: f64, fraction: f64) -> Option<Self> {
        let half_mm = finger.contact_mm / 2.0;
        let width_mm = PI * finger.contact_mm / 4.0;
        let off_mm = at_mm - lean_mm;
        let even = 1.5 * finger.force_n / (finger.contact_mm * width_mm)
            * (1.0 - (off_mm / half_mm).powi(2));
        (off_mm.abs() < half_mm).then_some(Self {
            at_mm,
            press: even * fraction,
        })
    }

    /// Normal strain and shear at a sensor, by Flamant's radial stress
    /// -2 (Fz cos + Fx sin) / (pi r) and Hooke's law.
    fn strains(&self, finger: &Finger, sensor_mm: f64, friction: f64) -> (f64, f64) {
        let (x, z) = (sensor_mm - self.at_mm, finger.depth_mm);
        let (r, angle) = (x.hypot(z), x.atan2(z));
        let radial = 2.0 * self.press * (angle.cos() + friction * angle.sin())
            / (PI * r)
            / finger.modulus_mpa;
        (
            radial * (angle.cos().powi(2) - finger.poisson * angle.sin().powi(2)),
            radial * angle.sin() * angle.cos() * 2.0 * (1.0 + finger.poisson),
        )
    }
}

/// Bridge voltage: 5 V, two resistors of 820 ohm, 0.2 per unit of shear and half as much per unit
/// of normal strain.
fn bridge_v(tilt: f64, normal: f64, shear: f64) -> f64 {
    2.5 + 5.0 / 4.0 * 0.2 * (tilt * shear + 0.5 * normal)
}

fn sum(strains: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    strains.fold((0.0, 0.0), |sum, strain| {
        (sum.0 + strain.0, sum.1 + strain.1)
    })
}

/// Sums the normal strain and shear at a sensor over all lines of all ridges.
fn summed(
    scene: &Sliding,
    sensor_mm: f64,
    place_mm: f64,
    friction: f64,
    lean_mm: f64,
) -> (f64, f64) {
    let finger = &scene.finger.unwrap();
    let lines = 400;
    let step_mm = scene.ridge_mm / f64::from(lines);
    // The ridges also carry the load of the grooves.
    let fraction = scene.period_mm / scene.ridge_mm * step_mm;
    sum((-20..=20).flat_map(|ridge| {
        let middle_mm = place_mm + f64::from(ridge) * scene.period_mm;
        (0..lines).filter_map(move |line| {
            let at_mm = middle_mm + (f64::from(line) + 0.5) * step_mm - scene.ridge_mm / 2.0;
            let line = Line::new(finger, at_mm, lean_mm, fraction)?;
            Some(line.strains(finger, sensor_mm, friction))
        })
    }))
}

#[test]
fn the_series_is_the_sum_of_the_line_loads() {
    for (reverse, friction) in [(false, 0.0), (false, 0.5), (true, 0.5)] {
        for (period_mm, ridge_mm, poisson) in [
            (2.6, 0.6, 0.5),
            (3.6, 0.6, 0.5),
            (4.1, 1.5, 0.3),
            (8.2, 0.6, 0.5),
        ] {
            let parameters = Sliding {
                period_mm,
                ridge_mm,
                reverse,
                start_mm: 0.3,
                stimulator: Stimulator::IDEAL,
                finger: Some(Finger {
                    friction,
                    poisson,
                    ..Finger::default()
                }),
                ..Sliding::physical()
            };
            let scene = still(parameters.clone());
            let way = if reverse { -1.0 } else { 1.0 };
            for step in 0..40 {
                let t_s = scene.truth().slide_start_s + 0.3 + 0.0067 * f64::from(step);
                let place_mm = scene.position_mm(t_s);
                for (input, sensor_mm, tilt) in SENSORS {
                    let strains =
                        summed(&parameters, sensor_mm, place_mm, way * friction, way * 0.5);
                    let expected = bridge_v(tilt, strains.0, strains.1);
                    let got = scene.clean_volts(input, t_s);
                    // The tone is 1 to 15 mV.
                    assert!(
                        (got - expected).abs() < 6e-6,
                        "{period_mm} mm, AIN{input}: {got} instead of {expected}"
                    );
                }
            }
        }
    }
}

/// Sums the strains at a sensor over all lines under all ridges of the skin, weighted with the part
/// of each ridge's top that stands on the grating.
fn summed_under_ridges(scene: &Sliding, sensor_mm: f64, place_mm: f64) -> (f64, f64) {
    let finger = &scene.finger.unwrap();
    let width_mm = finger.skin_ridge_mm;
    let near_mm = place_mm.rem_euclid(scene.period_mm);
    let lines = 300;
    let step_mm = width_mm / f64::from(lines);
    sum((-10..=10).flat_map(|ridge| {
        let middle_mm = f64::from(ridge) * 2.0 * width_mm;
        let stands_mm = (-20..=20).map(|other| {
            let apart_mm = (near_mm + f64::from(other) * scene.period_mm - middle_mm).abs();
            (0.5 * (width_mm + scene.ridge_mm) - apart_mm).clamp(0.0, width_mm.min(scene.ridge_mm))
        });
        let on_the_grating = stands_mm.sum::<f64>() / width_mm;
        // The ridges of grating and skin also carry the load of their grooves.
        let fraction = scene.period_mm / scene.ridge_mm * 2.0 * on_the_grating * step_mm;
        (0..lines).filter_map(move |line| {
            let at_mm = middle_mm + (f64::from(line) + 0.5) * step_mm - 0.5 * width_mm;
            let line = Line::new(finger, at_mm, finger.lean_mm, fraction)?;
            Some(line.strains(finger, sensor_mm, finger.friction))
        })
    }))
}

fn ridged(period_mm: f64) -> Sliding {
    Sliding {
        period_mm,
        ridge_mm: 0.5 * period_mm,
        finger: Some(Finger {
            skin_ridge_mm: 0.6,
            ..Finger::default()
        }),
        stimulator: Stimulator::IDEAL,
        ..Sliding::physical()
    }
}

#[test]
fn under_a_ridged_skin_the_series_is_the_sum_of_the_ridges_that_meet() {
    for period_mm in [0.5, 0.8, 1.0, 1.2, 1.4, 2.0, 3.0] {
        let parameters = ridged(period_mm);
        let scene = still(parameters.clone());
        for step in 0..40 {
            let t_s = scene.truth().slide_start_s + 0.3 + 0.0067 * f64::from(step);
            for (input, sensor_mm, tilt) in SENSORS {
                let place_mm = scene.position_mm(t_s);
                let (normal, shear) = summed_under_ridges(&parameters, sensor_mm, place_mm);
                let expected = bridge_v(tilt, normal, shear);
                let got = scene.clean_volts(input, t_s);
                // The load makes some 10 mV. Overtones beyond the 24th are omitted: at 1.2 mm all
                // odd ones reach the sensors.
                let off_max = if period_mm == 1.2 { 1e-4 } else { 4e-5 };
                assert!(
                    (got - expected).abs() < off_max,
                    "{period_mm} mm, AIN{input}: {got} instead of {expected}"
                );
            }
        }
    }
}

/// Mean square of the channels' fundamentals for periods from 0.8 to 3 mm.
fn powers(finger: Finger) -> Vec<(f64, f64)> {
    let power = |period_mm: f64| {
        let finger = Some(finger);
        let scene = SlidingScene::new(Sliding {
            finger,
            ..ridged(period_mm)
        })
        .unwrap();
        let squares = scene
            .channels()
            .iter()
            .map(|channel| channel.amplitude_v().powi(2));
        squares.sum::<f64>() / 16.0
    };
    (16..=60)
        .map(|step| 0.05 * f64::from(step))
        .map(|mm| (mm, power(mm)))
        .collect()
}

/// Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", Figure 11: a
/// skin with ridges of 0.6 mm has a local maximum of power at 1.2 to 1.6 mm, where a groove is as
/// wide as a ridge or a little wider. A smooth skin has none.
#[test]
fn ridges_of_the_skin_make_a_maximum_where_they_fall_into_grooves() {
    let peak_below = |powers: &[(f64, f64)], until_mm: f64| {
        let those = powers.iter().filter(|(mm, _)| *mm < until_mm);
        those.copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    };
    let min_beyond = |powers: &[(f64, f64)], from_mm: f64| {
        let those = powers.iter().filter(|(mm, _)| *mm > from_mm);
        those.copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    };
    // The maximum is at about five quarters of the skin's period.
    for skin_ridge_mm in [0.5, 0.6, 0.7] {
        let powers = powers(Finger {
            skin_ridge_mm,
            ..Finger::default()
        });
        let (peak_mm, peak) = peak_below(&powers, 2.2);
        let (trough_mm, trough) = min_beyond(&powers, peak_mm);
        println!(
            "{skin_ridge_mm} mm: {peak:.2e} V^2 at {peak_mm:.2} mm, {trough:.2e} at {trough_mm:.2} mm"
        );
        assert!(
            (1.19..1.35).contains(&(peak_mm / (2.0 * skin_ridge_mm))),
            "{skin_ridge_mm} mm: {peak_mm}"
        );
        assert!(
            peak > 1.3 * trough && peak > 3.0 * powers[0].1,
            "{skin_ridge_mm} mm: {powers:?}"
        );
    }
    // At smaller depths coarser gratings reach the sensors: the trough above the maximum is
    // shallow, as in the paper.
    let over = |depth_mm: f64| {
        let powers = powers(Finger {
            skin_ridge_mm: 0.6,
            depth_mm,
            ..Finger::default()
        });
        let (peak_mm, peak) = peak_below(&powers, 2.0);
        peak / min_beyond(&powers, peak_mm).1
    };
    let (near, far) = (over(0.8), over(1.3));
    println!("maximum over trough: {near:.2} at 0.8 mm, {far:.2} at 1.3 mm");
    assert!((1.2..1.5).contains(&near) && far > 4.0);

    let smooth = powers(Finger::default());
    assert!(
        smooth.windows(2).all(|pair| pair[0].1 < pair[1].1),
        "{smooth:?}"
    );
}

/// Prints strengths and phases of this model by period (with --nocapture).
#[test]
fn overtones_and_phases_come_out_of_the_geometry() {
    let mut before = 0.0;
    for period_mm in [2.6, 3.1, 3.6, 4.1] {
        let finger = Finger {
            friction: 0.0,
            lean_mm: 0.0,
            ..Finger::default()
        };
        let scene = on_grating(period_mm, finger);
        let tone = |input: usize| &scene.channels()[input].sliding.tone;
        let fundamental_v = tone(0)[0].amplitude_v();
        let ratios: Vec<f64> = (1..5)
            .map(|h| tone(0)[h].amplitude_v() / fundamental_v)
            .collect();
        let lag = (tone(0)[0].phase_rad() - tone(4)[0].phase_rad()).rem_euclid(TAU);
        let expected = (TAU * 2.3 / period_mm).rem_euclid(TAU);
        println!(
            "{period_mm} mm: {:.2} mV, {ratios:.3?}, lag {lag:.3} of {expected:.3} rad",
            1e3 * fundamental_v
        );
        // The cover is a low-pass: coarser gratings have stronger tones and overtones.
        assert!(fundamental_v > before && (3e-3..12e-3).contains(&fundamental_v));
        assert!(
            (0.05..0.4).contains(&ratios[0]) && ratios[1] < 0.4 * ratios[0],
            "{ratios:?}"
        );
        // The contact's ends shift the phase.
        assert!(
            (lag - expected).abs() < 0.26,
            "{period_mm} mm: {lag} instead of {expected}"
        );
        before = fundamental_v;
    }
}

#[test]
fn under_a_long_contact_the_lag_is_that_of_the_pitch() {
    for period_mm in [2.6, 3.6, 4.1, 9.0] {
        let finger = Finger {
            contact_mm: 300.0,
            force_n: 3600.0,
            ..Finger::default()
        };
        let scene = on_grating(period_mm, finger);
        let off = beyond_pitch_rad(&scene, 0, period_mm);
        assert!(off.abs() < 1e-3, "{period_mm} mm: {off}");
        // The cover's low-pass: shear of 3 k z exp(-k z) and, in quadrature, half of 0.5 + 1.5 k z
        // of normal strain; with friction 0.5 half of 3 (1 - k z) and of 1.5 k z - 1, a quarter of
        // a turn on.
        let kz = TAU * 1.3 / period_mm;
        let (quarter, level) = (
            3.0 * kz + 0.25 * (1.5 * kz - 1.0),
            0.5 * (0.5 + 1.5 * kz) + 1.5 * (1.0 - kz),
        );
        let pressure = 1.5 * 3600.0 / (300.0 * PI * 75.0);
        let ridge = PI * 0.6 / period_mm;
        let expected =
            0.25 * 2.0 * ridge.sin() / ridge * pressure / 1.7 * (-kz).exp() * quarter.hypot(level);
        let got = scene.channels()[0].amplitude_v();
        assert!(
            (got / expected - 1.0).abs() < 2e-3,
            "{period_mm} mm: {got} instead of {expected}"
        );
    }
}

/// Under the pressure p(s) cos(k s), a sensor at s sees a wave with the complex wave number k - i
/// p'/p. A cover with the response R(k) turns the imaginary part into a phase of d ln R / dk times
/// p'/p. Under a parabola of half-width a, p'/p differs by 4 b / (a^2 - b^2) between units half a
/// pitch b to either side of its middle. R is (1 + 3 k z) exp(-k z) for normal strain and k z
/// exp(-k z) for shear. This is a first-order result: the direct effect of the ends on the units
/// falls with the length to the power of -4.
#[test]
fn the_pull_of_the_contacts_ends_is_the_closed_form() {
    for (contact_mm, off_max) in [(16.0, 0.09), (30.0, 0.05), (60.0, 0.02)] {
        for period_mm in [2.6, 3.1, 3.6, 4.1] {
            let finger = Finger {
                friction: 0.0,
                lean_mm: 0.0,
                contact_mm,
                ..Finger::default()
            };
            let (k, z, a, b) = (TAU / period_mm, 1.3, 0.5 * contact_mm, 1.15);
            let apart = 4.0 * b / (a * a - b * b);
            // The first piezoresistor responds to shear; without its normal sensitivity, to nothing
            // else.
            for (input, normal_share, expected) in [
                (1, 0.5, apart * (z - 3.0 * z / (1.0 + 3.0 * k * z))),
                (0, 0.0, apart * (z - 1.0 / k)),
            ] {
                let scene = on_grating(
                    period_mm,
                    Finger {
                        normal_share,
                        ..finger
                    },
                );
                let got = beyond_pitch_rad(&scene, input, period_mm);
                assert!(
                    (got / expected - 1.0).abs() < off_max,
                    "{contact_mm}, {period_mm} mm: {got} for {expected}"
                );
            }
        }
    }
}

/// Checks the figures in the crate's documentation.
#[test]
fn the_pull_is_as_strong_as_documented() {
    for (contact_mm, min, max) in [(8.0, 0.24, 0.32), (5.0, 0.25, 1.13)] {
        let (mut weakest, mut strongest) = (f64::MAX, 0f64);
        for period_mm in [2.6, 3.1, 3.6, 4.1] {
            let scene = on_grating(
                period_mm,
                Finger {
                    contact_mm,
                    ..Finger::default()
                },
            );
            for input in 0..4 {
                let pull = beyond_pitch_rad(&scene, input, period_mm);
                (weakest, strongest) = (weakest.min(pull), strongest.max(pull));
            }
        }
        assert!(
            weakest > min && strongest < max,
            "{contact_mm} mm: {weakest} to {strongest}"
        );
        assert!(strongest > max - 0.01, "{contact_mm} mm: {strongest}");
    }
}

#[test]
fn opposite_piezoresistors_and_the_leading_edge_are_as_in_the_paper() {
    for (speed_mm_s, period_mm) in TABLE_2 {
        for reverse in [false, true] {
            let scene = still(Sliding {
                speed_mm_s,
                period_mm,
                reverse,
                ..Sliding::physical()
            });
            let c = scene.channels();
            for unit in [0, 4] {
                let apart = (phase_rad(&scene, unit) - phase_rad(&scene, unit + 2)).cos();
                assert!(apart < -0.6, "{period_mm} mm: {apart}");
            }
            let [leading, trailing] = if reverse { [0, 4] } else { [4, 0] };
            let over = c[leading].amplitude_v() / c[trailing].amplitude_v();
            println!("{period_mm} mm: leading edge {over:.2} times as strong");
            assert!((1.05..1.5).contains(&over), "{period_mm} mm: {over}");
        }
    }
}

#[test]
fn the_hold_creeps_and_the_filter_takes_its_share() {
    let record = |finger: Finger| {
        let parameters = Sliding {
            finger: Some(finger),
            speed_mm_s: 48.0,
            period_mm: 2.6,
            ..Sliding::physical()
        };
        let mut scene = still(parameters);
        let truth = scene.truth();
        let at_touch_v = scene.volts(0, truth.contact_s + 0.3) - 2.5;
        let held_v = scene.volts(0, truth.slide_start_s - 1e-3) - 2.5;
        let resting_v = scene.clean_volts(0, truth.slide_start_s - 1e-3) - 2.5;
        let (mut real, mut imaginary) = (0.0, 0.0);
        for k in 0..2400 {
            let t_s = truth.slide_start_s + 0.2 + f64::from(k) / 2400.0 * 13.0 * 2.6 / 48.0;
            let (sin, cos) = (TAU * truth.frequency_hz * t_s).sin_cos();
            let volts = scene.volts(0, t_s);
            real += volts * cos / 1200.0;
            imaginary += volts * sin / 1200.0;
        }
        let tone = f64::hypot(real, imaginary) / scene.channels()[0].amplitude_v();
        let gone_v = scene.volts(0, truth.end_s) - 2.5;
        (
            at_touch_v / resting_v,
            held_v / resting_v,
            tone,
            gone_v / resting_v,
        )
    };
    let finger = Finger {
        noise_uv: 0.0,
        ..Finger::default()
    };
    let (at_touch, held, tone, gone) = record(finger);
    // 95 % at once and the rest gradually, less the part that the touch's overshoot has already
    // caused.
    assert!(
        (0.953..0.960).contains(&at_touch) && (0.963..0.970).contains(&held),
        "{at_touch} {held}"
    );
    assert!((0.001..0.05).contains(&gone), "{gone}");
    let pole = |hz: f64| 1.0 / (hz / 388.2).hypot(1.0);
    assert!((tone / (0.95 * pole(18.46)) - 1.0).abs() < 1e-3, "{tone}");
    let (.., tone, _) = record(Finger {
        capacitor_uf: 100.0,
        ..finger
    });
    assert!(
        (tone / (0.95 / (18.4615_f64 / 3.882).hypot(1.0)) - 1.0).abs() < 5e-3,
        "{tone}"
    );
    // A human finger creeps more.
    let (_, held, ..) = record(Finger {
        relaxation_s: 1.42,
        creep_s: 2.14,
        ..finger
    });
    assert!((0.75..0.85).contains(&held), "{held}");
}

/// The chip's scan aliases a frequency above half the frame rate to the frame rate minus that
/// frequency; the board's filter attenuates it.
#[test]
fn what_is_too_fast_for_the_scan_aliases() {
    let (true_hz, frame_rate_hz) = (190.0, 15_728_640.0 / 3106.0 / 21.0);
    let scene = still(Sliding {
        speed_mm_s: true_hz * 3.6,
        period_mm: 3.6,
        slide_mm: 1.2 * true_hz * 3.6,
        ..Sliding::physical()
    });
    let (truth, tone_v) = (scene.truth(), scene.channels()[0].amplitude_v());
    let mut chip = Ads1258::new(
        Box::new(scene),
        Options {
            noise: false,
            ..Options::default()
        },
    );
    // The firmware's scan: DRATE 1, DLY 3, AIN0-15 and five internal readings.
    write(&mut chip, 0, 0, &[0x02, 0x31, 0x00, 0x00, 0xFF, 0xFF, 0x3D]);
    chip.set_start(0, true);
    let mut readings = Vec::new();
    loop {
        let (edge_ns, status, code) = next(&mut chip);
        let t_s = edge_ns as f64 * 1e-9;
        if t_s > truth.slide_end_s - 0.05 {
            break;
        }
        // AIN0 is 08h.
        if status & 0x1F == 0x08 && t_s > truth.slide_start_s + 0.15 {
            readings.push((t_s, f64::from(code) * 4.096 / 7_864_320.0));
        }
    }
    let count = readings.len() as f64;
    let mean_v = readings.iter().map(|(_, volts)| volts).sum::<f64>() / count;
    // With a Hann window a line does not leak into others several line widths away.
    let amplitude_v = |hz: f64| {
        let (mut cos_v, mut sin_v) = (0.0, 0.0);
        for (n, (t_s, volts)) in (0..).zip(&readings) {
            let hann = 1.0 - (TAU * (f64::from(n) + 0.5) / count).cos();
            let (sin, cos) = (TAU * hz * t_s).sin_cos();
            cos_v += hann * (volts - mean_v) * cos;
            sin_v += hann * (volts - mean_v) * sin;
        }
        2.0 / count * f64::hypot(cos_v, sin_v)
    };
    // 95 % of a deformation is immediate, and the pole is at 388.2 Hz.
    let expected_v = 0.95 * tone_v / (true_hz / 388.2).hypot(1.0);
    let got_v = amplitude_v(frame_rate_hz - true_hz);
    assert!(
        (got_v / expected_v - 1.0).abs() < 5e-3,
        "{got_v} V instead of {expected_v} V"
    );
    assert!(amplitude_v(frame_rate_hz - true_hz + 15.0) < 0.01 * expected_v);
}

#[test]
fn the_touch_has_a_spike() {
    let mut scene = still(Sliding::physical());
    let truth = scene.truth();
    let [peak, later] =
        [truth.contact_s + 4e-4, truth.contact_s + 0.5].map(|t_s| scene.volts(0, t_s) - 2.5);
    assert!((1.4..1.65).contains(&(peak / later)), "{peak} {later}");
}

#[test]
fn a_hand_drags_both_ways() {
    let hand = Some(Hand::default());
    let scene = still(Sliding {
        hand,
        ..Sliding::physical()
    });
    let start_s = scene.truth().slide_start_s;
    // The same position on the way out and back: only friction differs.
    let [out, back] = [0.2, 0.8].map(|swing| start_s + swing / 1.07);
    assert!((scene.position_mm(out) - scene.position_mm(back)).abs() < 1e-9);
    assert!(scene.speed_mm_s(out) > 100.0 && scene.speed_mm_s(back) < -100.0);
    let difference = scene.clean_volts(0, out) - scene.clean_volts(0, back);
    assert!(difference.abs() > 1e-3, "{difference}");
    assert!((scene.truth().frequency_hz - 197.0 / 3.6).abs() < 1e-9);
}

#[test]
fn runs_differ_and_the_finger_stays() {
    let run = |seed| {
        let stimulator = Stimulator {
            onset_jitter_s: 0.1,
            ripple_percent: 2.0,
            ..Stimulator::default()
        };
        SlidingScene::new(Sliding {
            seed,
            stimulator,
            ..Sliding::physical()
        })
        .unwrap()
    };
    let (first, second) = (run(1), run(2));
    assert_eq!(first.channels(), second.channels());
    assert_ne!(first.truth().slide_start_s, second.truth().slide_start_s);
    let early = |scene: &SlidingScene| (scene.truth().slide_start_s - 1.51).abs();
    assert!(early(&first) <= 0.1 && early(&second) <= 0.1);
    let speed = |scene: &SlidingScene| scene.speed_mm_s(scene.truth().slide_start_s + 0.5);
    assert_ne!(speed(&first), speed(&second));
    assert!((speed(&first) / 30.0 - 1.0).abs() <= 0.02);
}
