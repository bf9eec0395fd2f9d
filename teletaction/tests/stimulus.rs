//! Compares the stimulus, also as sound, with the true surface in f64, and tests its limits for any
//! input. Hands as in section IV-A, counts of 5 um, 5 kHz.

use proptest::prelude::*;
use ridgetone_teletaction::stimulus::{
    Actuator, AmplitudeLaw, Delay, Encoder, Harmonic, Stimulus, Texture, Vibration,
};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 5000.0;
const SOUND_HZ: f64 = 48_000.0;

fn counts(x_mm: f64) -> i32 {
    (x_mm / 0.005).floor() as i32
}

/// Equations 2 and 3 in f64.
fn amplitude_v(period_mm: f64) -> f64 {
    let x = period_mm;
    75.0 / 6000.0
        * (30770.0 * x.powi(4) - 162_663.0 * x.powi(3) + 309_743.0 * x * x - 248_938.0 * x
            + 72298.0)
}

fn powered(power: f32, period_mm: f32) -> Texture {
    Texture {
        power,
        ..Texture::new(period_mm)
    }
}

fn felt(texture: Texture, latency_s: f32) -> Stimulus {
    let encoder = Encoder {
        latency_s,
        ..Encoder::OKAMOTO
    };
    let mut stimulus =
        Stimulus::new(Actuator::PIEZO, encoder, AmplitudeLaw::OKAMOTO).expect("a stimulus");
    stimulus.set_texture(&texture).expect("a texture");
    stimulus.down();
    stimulus
}

/// The hands: the paper's average hand, two at the speed of its experiments, and one that moves
/// slowly back and forth.
#[test]
fn the_output_is_the_surface() {
    let hands: [fn(f64) -> f64; 4] = [
        |t| 197.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t).cos()),
        |t| 230.0 * t,
        |t| -230.0 * t,
        |t| 20.0 / (TAU * 0.5) * (TAU * 0.5 * t).sin(),
    ];
    for (hand, position) in hands.into_iter().enumerate() {
        let latencies = [1e-4, 6e-4, 2e-3].into_iter();
        let cases = latencies.flat_map(|s| [0.8, 1.0, 1.4, 2.0].map(|period_mm| (period_mm, s)));
        for (period_mm, latency_s) in cases {
            let mut stimulus = felt(Texture::new(period_mm as f32), latency_s as f32);
            // Normal equations for sine and cosine of the true surface.
            let (mut ss, mut sc, mut cc, mut ys, mut yc) = (0.0, 0.0, 0.0, 0.0, 0.0);
            let (amplitude, mut worst) = (amplitude_v(period_mm), 0.0f64);
            for n in 0..20_000 {
                let t = f64::from(n) / RATE_HZ;
                let y = f64::from(stimulus.next(counts(position(t)))) - 75.0;
                // The filter settles and the vibration fades in within 0.1 s.
                if t < 0.1 {
                    continue;
                }
                let (s, c) = (TAU * position(t + latency_s) / period_mm).sin_cos();
                (ss, sc, cc) = (ss + s * s, sc + s * c, cc + c * c);
                (ys, yc) = (ys + y * s, yc + y * c);
                worst = worst.max((y - amplitude * s).abs() / amplitude);
            }
            let det = ss * cc - sc * sc;
            let (a, b) = ((ys * cc - yc * sc) / det, (yc * ss - ys * sc) / det);
            let (found, phase) = (a.hypot(b) / amplitude, b.atan2(a) / TAU);
            let case =
                format!("hand {hand}, {period_mm} mm, {latency_s} s: {found} {phase} {worst}");
            assert!((found - 1.0).abs() < 0.01 && phase.abs() < 0.02, "{case}");
            assert!(worst < 0.02 * TAU, "{case}");
        }
    }
}

#[test]
fn the_law_is_equations_2_and_3() {
    for period_mm in [0.8f32, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0] {
        let fraction = f64::from(AmplitudeLaw::OKAMOTO.fraction(period_mm, 0.0));
        // Sums of large numbers in f32 are accurate to a few thousandths of a volt.
        assert!(
            (75.0 * fraction - amplitude_v(f64::from(period_mm))).abs() < 2e-3,
            "{period_mm}"
        );
    }
    // The local peak in section IV-B, at 1.2 to 1.6 mm.
    let at = |period_mm| AmplitudeLaw::OKAMOTO.power(period_mm);
    assert!(at(1.4) > at(1.1) && at(1.4) > at(1.7));
    assert_eq!(AmplitudeLaw::OKAMOTO.power(5.0), at(2.0));
    assert_eq!(AmplitudeLaw::OKAMOTO.fraction(1.4, 3000.0), 0.5);
    assert_eq!(AmplitudeLaw::OKAMOTO.fraction(1.4, 1e9), 1.0);
}

/// No step of the output may exceed the steepest sine's, through turns, a wrap of the encoder and a
/// change of texture, even if the output is many counts ahead of the hand.
#[test]
fn the_phase_is_continuous() {
    type Case = (fn(f64) -> f64, i32, f32, [f32; 3], i32);
    let cases: [Case; 2] = [
        // Up to 100 mm/s, back and forth across the wrap.
        (
            |t| 100.0 / (TAU * 2.0) * (TAU * 2.0 * t).sin(),
            i32::MAX - 100,
            1e-4,
            [1.0, 1.4, 2.0],
            1500,
        ),
        (|t| 100.0 * t, 0, 2e-3, [1.0, 2.0, 0.8], 300),
    ];
    for (position, from, latency_s, periods_mm, samples) in cases {
        let mut stimulus = felt(powered(3000.0, 1.0), latency_s);
        let mut last = 75.0f32;
        for n in 0..20_000 {
            if n % samples == 0 {
                let period_mm = periods_mm[(n / samples) as usize % 3];
                stimulus
                    .set_texture(&powered(3000.0, period_mm))
                    .expect("a texture");
            }
            let x = position(f64::from(n) / RATE_HZ);
            let y = stimulus.next(counts(x).wrapping_add(from));
            // 37.5 V at the highest frequency, plus a fade of 75 V in 20 ms.
            let hz = 100.0 / periods_mm.iter().fold(f32::MAX, |a, b| a.min(*b));
            let max = 37.5 * TAU as f32 * hz / 5000.0 + 75.0 / 0.02 / 5000.0 + 0.5;
            assert!((y - last).abs() < max, "{latency_s} {n}: {last} {y}");
            last = y;
        }
    }
}

/// Overtones must have the right phase, and the wave's peak must never exceed the actuator's, even
/// after a texture without overtones.
#[test]
fn overtones_are_where_they_belong_and_find_room() {
    let mut texture = powered(6000.0, 2.0);
    texture.overtones[1] = Harmonic {
        amplitude: 0.5,
        phase_cycles: 0.25,
    };
    let mut stimulus = felt(texture, 1e-4);
    // 25 and 75 Hz at 50 mm/s, over whole seconds.
    let y: Vec<f64> = (0..10_000)
        .map(|n| f64::from(stimulus.next(counts(0.01 * f64::from(n)))) - 75.0)
        .collect();
    for (harmonic, sine, cosine) in [(1.0, 50.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 25.0)] {
        let (mut s, mut c) = (0.0, 0.0);
        for (n, y) in y.iter().enumerate().skip(5000) {
            let (sin, cos) = (TAU * harmonic * (0.01 * n as f64 + 0.005) / 2.0).sin_cos();
            (s, c) = (s + y * sin / 2500.0, c + y * cos / 2500.0);
        }
        let error = f64::hypot(s - sine, c - cosine);
        assert!(error < 2.0, "{harmonic}: {s} {c}");
        assert!(
            (s.hypot(c) - f64::hypot(sine, cosine)).abs() < 0.5,
            "{harmonic}: {s} {c}"
        );
    }
    let mut stimulus = felt(Texture::new(1.4), 1e-4);
    for n in 0..5000 {
        stimulus.next(4 * n);
    }
    let alone_v = stimulus.amplitude_v();
    texture.overtones = [Harmonic {
        amplitude: 1.0,
        phase_cycles: 0.25,
    }; 3];
    stimulus.set_texture(&texture).expect("a texture");
    assert!(
        alone_v > 0.4 * 75.0 && stimulus.amplitude_v() <= 0.2501 * 75.0,
        "{alone_v} {}",
        stimulus.amplitude_v()
    );
}

#[derive(Clone, Debug)]
enum Step {
    Texture(Texture),
    Counts(i32),
    Moves(i32, u16),
    Lift,
    Down,
}

fn texture() -> impl Strategy<Value = Texture> {
    let value = || prop_oneof![4 => 0.0f32..5.0, 1 => any::<f32>(), 1 => Just(f32::NAN)];
    (
        value(),
        value(),
        value(),
        prop::array::uniform3((value(), value())),
    )
        .prop_map(|(period_mm, sigma, power, overtones)| {
            let overtones = overtones.map(|(amplitude, phase_cycles)| Harmonic {
                amplitude,
                phase_cycles,
            });
            Texture {
                period_sigma_mm: sigma,
                power: 2000.0 * power,
                overtones,
                ..Texture::new(period_mm)
            }
        })
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => texture().prop_map(Step::Texture),
        2 => (0.1f32..3.0).prop_map(|period_mm| Step::Texture(Texture::new(period_mm))),
        1 => any::<i32>().prop_map(Step::Counts),
        6 => (-200i32..200, 1u16..200).prop_map(|(speed, samples)| Step::Moves(speed, samples)),
        1 => Just(Step::Lift),
        2 => Just(Step::Down),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn limits_hold_whatever_comes(
        steps in prop::collection::vec(step(), 1..40),
        (voltage_v, slew_v_s, cutoff_hz) in (0.1f32..200.0, 10.0f32..1e6, 10.0f32..1000.0),
        latency_s in 0.0f32..0.02,
    ) {
        let actuator = Actuator { voltage_v, slew_v_s, cutoff_hz, ..Actuator::PIEZO };
        let encoder = Encoder { latency_s, ..Encoder::OKAMOTO };
        let mut stimulus = Stimulus::new(actuator, encoder, AmplitudeLaw::OKAMOTO).expect("a stimulus");
        let (mut counts, mut last) = (0i32, 0.5 * voltage_v);
        let mut next = |stimulus: &mut Stimulus, counts| {
            let v = stimulus.next(counts);
            assert!((0.0..=voltage_v).contains(&v), "{v}");
            assert!((v - last).abs() <= slew_v_s / 5000.0 + 1e-5 * voltage_v, "{last} {v}");
            last = v;
        };
        for step in steps {
            match step {
                Step::Texture(texture) => prop_assert_eq!(stimulus.set_texture(&texture).is_ok(), texture.check().is_ok()),
                Step::Counts(to) => { counts = to; next(&mut stimulus, counts) }
                Step::Moves(speed, samples) => for _ in 0..samples {
                    counts = counts.wrapping_add(speed);
                    next(&mut stimulus, counts);
                },
                Step::Lift => stimulus.lift(),
                Step::Down => stimulus.down(),
            }
        }
    }
}

/// 100, 400 and 700 Hz: beyond the cut-off of 310 Hz the tone is weaker, and silent from 620 Hz on.
/// When the hand leaves, the vibration stops within the fade of 20 ms, 100 samples.
#[test]
fn fast_hands_are_held_back_and_one_that_leaves_stops_softly() {
    for (speed, expected_v) in [(4, 75.0), (16, 75.0 * (2.0 - 400.0 / 310.0)), (28, 0.0)] {
        let mut stimulus = felt(powered(6000.0, 1.0), 1e-4);
        for n in 0..2000 {
            stimulus.next(speed * n);
        }
        let amplitude_v = stimulus.amplitude_v();
        assert!((amplitude_v - expected_v).abs() < 0.5, "{amplitude_v}");
        stimulus.lift();
        let after: Vec<f32> = (2000..2100).map(|n| stimulus.next(speed * n)).collect();
        // The steepest step of the sine, plus that of the fade.
        let max = expected_v * TAU as f32 * (25 * speed) as f32 / 5000.0 + 0.75 + 0.5;
        let steps = after.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        assert!(steps.fold(0.0, f32::max) < max, "{speed}");
        assert_eq!((stimulus.amplitude_v(), after[99]), (0.0, 75.0));
    }
}

#[test]
fn what_is_impossible_is_refused_and_the_last_texture_stays() {
    type Change = fn(&mut Actuator, &mut Encoder, &mut AmplitudeLaw);
    let cases: [(Change, &str); 9] = [
        (|a, _, _| a.voltage_v = f32::NAN, "voltage_v"),
        (|a, _, _| a.cutoff_hz = 0.0, "cutoff_hz"),
        (|a, _, _| a.slew_v_s = -1.0, "slew_v_s"),
        (|a, _, _| a.fade_s = 0.0, "fade_s"),
        (|_, e, _| e.count_mm = 0.0, "count_mm"),
        (|_, e, _| e.rate_hz = f32::INFINITY, "rate_hz"),
        (|_, e, _| e.latency_s = 1.0, "latency_s"),
        (|_, _, l| l.power_max = 0.0, "power_max"),
        (|_, _, l| l.period_mm = (2.0, 1.0), "period_mm.1"),
    ];
    for (change, setting) in cases {
        let (mut a, mut e, mut l) = (Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO);
        change(&mut a, &mut e, &mut l);
        assert_eq!(Stimulus::new(a, e, l).expect_err(setting).name, setting);
    }
    let mut stimulus = felt(Texture::new(1.4), 1e-4);
    let mut other = stimulus;
    for texture in [
        Texture::new(0.0),
        Texture::new(f32::NAN),
        powered(f32::INFINITY, 1.0),
    ] {
        assert!(stimulus.set_texture(&texture).is_err());
    }
    for n in 0..500 {
        assert_eq!(stimulus.next(3 * n), other.next(3 * n));
    }
}

/// Position of a hand that moves back and forth at 1.07 Hz, at up to 120 mm/s.
fn position_mm(t_s: f64) -> f64 {
    120.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t_s).cos())
}

fn vibration<const N: usize>(
    actuator: Actuator,
    texture: Texture,
    delay: Delay,
    wait_s: f32,
) -> Vibration<N> {
    let mut vibration =
        Vibration::new(actuator, AmplitudeLaw::OKAMOTO, SOUND_HZ as f32).expect("a vibration");
    vibration.set_texture(&texture).expect("a texture");
    vibration.set_delay(delay, wait_s).expect("a delay");
    vibration
}

/// Compares 2 s of sound with the surface under the hand one wait and delay earlier. A position
/// arrives every 8 ms.
#[test]
fn the_sound_is_the_surface_under_the_hand_the_stated_time_ago() {
    for (period_mm, wait_s, delay_s) in [(1.0, 0.01, 0.0), (1.4, 0.02, 0.0), (2.0, 0.01, 0.12)] {
        let delay = Delay::new(delay_s as f32, 0.0, 1).expect("a delay");
        let texture = Texture::new(period_mm as f32);
        let mut vibration = vibration::<256>(Actuator::PIEZO, texture, delay, wait_s as f32);
        let amplitude = amplitude_v(period_mm) / 75.0;
        let (mut reported, mut worst) = (0, 0.0f64);
        for n in 0..96_000 {
            let t_s = f64::from(n) / SOUND_HZ;
            while 0.008 * f64::from(reported) <= t_s {
                let at_s = 0.008 * f64::from(reported);
                vibration.down(at_s, position_mm(at_s));
                reported += 1;
            }
            let y = f64::from(vibration.next(t_s));
            if t_s > 0.1 + wait_s + delay_s {
                let x_mm = position_mm(t_s - wait_s - delay_s);
                worst = worst.max((y / amplitude - (TAU * x_mm / period_mm).sin()).abs());
            }
        }
        // Linear interpolation between positions 8 ms apart is off by v' t^2 / 8 = 6.5 um, and the
        // tracker lags by as much: 0.02 cycles.
        assert!(worst < 0.02 * TAU, "{period_mm} mm: {worst}");
    }
}

/// The hand is lifted every 90 ms. If the delay is longer than that, the hand counts as resting,
/// which silences a carrier.
#[test]
fn no_step_is_beyond_the_slew_whatever_hand_and_delay_do() {
    for (carrier_hz, delay_s) in [(None, 0.12), (Some(250.0), 0.02)] {
        let actuator = Actuator {
            slew_v_s: 50_000.0,
            ..Actuator::PIEZO
        };
        let delay = Delay::new(delay_s, 0.04, 3).expect("a delay");
        let mut vibration = vibration::<64>(actuator, Texture::new(1.0), delay, 0.01);
        vibration.set_carrier(carrier_hz).expect("a carrier");
        let (mut last, mut loudest) = (0.0f32, 0.0f32);
        for n in 0..96_000u32 {
            let t_s = f64::from(n) / SOUND_HZ;
            if n % 4000 == 0 {
                let period_mm = [0.8, 1.4, f32::NAN, 3.0, -1.0][n as usize / 4000 % 5];
                assert_eq!(
                    vibration.set_texture(&Texture::new(period_mm)).is_ok(),
                    period_mm > 0.0
                );
            }
            match n % 391 {
                0 => vibration.down(t_s, position_mm(t_s) + f64::from(n % 7)),
                1 if n % 11 == 0 => vibration.lift(),
                2 => drop(vibration.moved(f64::NAN, 3.0)),
                3 => drop(vibration.moved(t_s, f64::NAN)),
                4 if n % 11 == 0 => drop(vibration.moved(t_s, 1e12)),
                _ => {}
            }
            let y = vibration.next(t_s);
            assert!(
                y.abs() <= 1.0 && (y - last).abs() <= 50_000.0 / 75.0 / 48_000.0 + 1e-5,
                "{n}: {last} {y}"
            );
            (last, loudest) = (y, loudest.max(y.abs()));
        }
        assert!(loudest > 0.3, "{loudest}");
        vibration.lift();
        let end = (0..48_000)
            .map(|n| vibration.next(2.0 + f64::from(n) / SOUND_HZ))
            .last();
        assert_eq!((end, vibration.amplitude()), (Some(0.0), 0.0));
    }
}

/// The carrier's amplitude must follow the surface, which a hand at 28 mm/s passes at 20 Hz. Under
/// a resting hand it must be silent.
#[test]
fn a_carrier_has_the_texture_as_its_envelope() {
    let none = Delay::new(0.0, 0.0, 0).expect("a delay");
    let mut vibration = vibration::<256>(Actuator::PIEZO, Texture::new(1.4), none, 0.0);
    for refused in [0.0, 149.0, 251.0, f32::NAN] {
        assert!(vibration.set_carrier(Some(refused)).is_err(), "{refused}");
    }
    vibration.set_carrier(Some(200.0)).expect("a carrier");
    let amplitude = f64::from(AmplitudeLaw::OKAMOTO.fraction(1.4, 0.0));
    vibration.down(0.0, 0.0);
    let (mut worst, mut loudest) = (0.0f64, 0.0f64);
    for n in 0..96_000 {
        let t_s = f64::from(n) / SOUND_HZ;
        if n % 48 == 0 && n < 48_000 {
            vibration.moved(t_s + 1e-3, 28.0 * (t_s + 1e-3));
        }
        let y = f64::from(vibration.next(t_s));
        let surface = 0.5 + 0.5 * (TAU * 20.0 * t_s).sin();
        let expected = amplitude * surface * (TAU * 200.0 * t_s).sin();
        if (4800..48_000).contains(&n) {
            (worst, loudest) = (worst.max((y - expected).abs()), loudest.max(y.abs()));
        } else if n > 51_000 {
            assert_eq!(y, 0.0, "{n}");
        }
    }
    assert!(worst < 0.03 * amplitude, "{worst} of {amplitude}");
    assert!(loudest > 0.95 * amplitude, "{loudest} of {amplitude}");
}
