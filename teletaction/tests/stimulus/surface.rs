//! The output against the true surface, in f64: hands of section IV-A, counts of 5 um, 5 kHz.

use ridgetone_teletaction::stimulus::{
    Actuator, AmplitudeLaw, Encoder, Harmonic, Stimulus, Texture,
};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 5000.0;
const COUNT_MM: f64 = 0.005;

fn counts(x_mm: f64) -> i32 {
    (x_mm / COUNT_MM).floor() as i32
}

/// Equations 2 and 3 in f64.
fn amplitude_v(period_mm: f64) -> f64 {
    let x = period_mm;
    75.0 / 6000.0
        * (30770.0 * x.powi(4) - 162_663.0 * x.powi(3) + 309_743.0 * x * x - 248_938.0 * x
            + 72298.0)
}

type Hand = (&'static str, fn(f64) -> f64);

/// Position of the hand, millimetres: the paper's mean hand, one that is as fast as its experiments,
/// and one that goes to and fro slowly.
fn hands() -> [Hand; 4] {
    [
        ("197 mm/s at 1.07 Hz", |t| {
            197.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t).cos())
        }),
        ("230 mm/s", |t| 230.0 * t),
        ("-230 mm/s", |t| -230.0 * t),
        ("20 mm/s at 0.5 Hz", |t| {
            20.0 / (TAU * 0.5) * (TAU * 0.5 * t).sin()
        }),
    ]
}

/// Amplitude over the true one, phase against the true one in cycles, and the greatest error over
/// the amplitude.
fn against_the_surface(
    period_mm: f64,
    latency_s: f64,
    position: fn(f64) -> f64,
) -> (f64, f64, f64) {
    let encoder = Encoder {
        latency_s: latency_s as f32,
        ..Encoder::OKAMOTO
    };
    let mut stimulus =
        Stimulus::new(Actuator::PIEZO, encoder, AmplitudeLaw::OKAMOTO).expect("a stimulus");
    stimulus
        .set_texture(&Texture::new(period_mm as f32))
        .expect("a texture");
    stimulus.down();
    // Equations of a sine and a cosine of the true surface.
    let (mut ss, mut sc, mut cc, mut ys, mut yc, mut worst) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0f64);
    let amplitude = amplitude_v(period_mm);
    for n in 0..20_000 {
        let t = f64::from(n) / RATE_HZ;
        let y = f64::from(stimulus.next(counts(position(t)))) - 75.0;
        // The filter settles and the vibration comes within 0.1 s.
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
    (a.hypot(b) / amplitude, b.atan2(a) / TAU, worst)
}

#[test]
fn the_output_is_the_surface() {
    for (name, position) in hands() {
        for period_mm in [0.8, 1.0, 1.4, 2.0] {
            for latency_s in [1e-4, 6e-4, 2e-3] {
                let (amplitude, phase, worst) = against_the_surface(period_mm, latency_s, position);
                let case =
                    format!("{name}, {period_mm} mm, {latency_s} s: {amplitude} {phase} {worst}");
                println!("{case}");
                assert!((amplitude - 1.0).abs() < 0.01, "{case}");
                assert!(phase.abs() < 0.02, "{case}");
                // No sample is 0.02 cycles off.
                assert!(worst < 0.02 * TAU, "{case}");
            }
        }
    }
}

/// Without prediction the same hand would be far off: what is predicted counts.
#[test]
fn latency_without_prediction_is_felt() {
    let encoder = Encoder {
        latency_s: 0.0,
        ..Encoder::OKAMOTO
    };
    let mut stimulus =
        Stimulus::new(Actuator::PIEZO, encoder, AmplitudeLaw::OKAMOTO).expect("a stimulus");
    stimulus.set_texture(&Texture::new(1.0)).expect("a texture");
    stimulus.down();
    let mut worst = 0.0f64;
    for n in 0..5000 {
        let t = f64::from(n) / RATE_HZ;
        let y = f64::from(stimulus.next(counts(230.0 * t))) - 75.0;
        if t > 0.1 {
            worst = worst.max(
                (y - amplitude_v(1.0) * (TAU * 230.0 * (t + 6e-4)).sin()).abs() / amplitude_v(1.0),
            );
        }
    }
    assert!(worst > 0.5, "{worst}");
}

#[test]
fn the_law_is_equations_2_and_3() {
    for period_mm in [0.8f32, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0] {
        let fraction = f64::from(AmplitudeLaw::OKAMOTO.fraction(period_mm, 0.0));
        // Sums of large numbers in f32: a thousandth of a volt.
        assert!(
            (75.0 * fraction - amplitude_v(f64::from(period_mm))).abs() < 2e-3,
            "{period_mm}"
        );
    }
    // The local peak of section IV-B, at 1.2 to 1.6 mm.
    let at = |period_mm| AmplitudeLaw::OKAMOTO.power(period_mm);
    assert!(at(1.4) > at(1.1) && at(1.4) > at(1.7));
    assert_eq!(AmplitudeLaw::OKAMOTO.power(5.0), at(2.0));
    assert_eq!(AmplitudeLaw::OKAMOTO.fraction(1.4, 3000.0), 0.5);
    assert_eq!(AmplitudeLaw::OKAMOTO.fraction(1.4, 1e9), 1.0);
}

/// Through turns, through a wrap of the encoder, and through a change of texture the output has no
/// step: none beyond what the steepest sine of this hand has.
#[test]
fn the_phase_is_continuous() {
    let mut stimulus = Stimulus::new(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)
        .expect("a stimulus");
    stimulus.down();
    let mut last = 75.0f32;
    for n in 0..20_000 {
        let t = f64::from(n) / RATE_HZ;
        // At most 100 mm/s, to and fro over the wrap.
        let x = 100.0 / (TAU * 2.0) * (TAU * 2.0 * t).sin();
        if n % 1500 == 0 {
            let period_mm = [1.0, 1.4, 2.0][(n as usize / 1500) % 3];
            stimulus
                .set_texture(&Texture {
                    power: 3000.0,
                    ..Texture::new(period_mm)
                })
                .expect("a texture");
        }
        let y = stimulus.next(counts(x).wrapping_add(i32::MAX - 100));
        // 37.5 V at 100 Hz, and the fade of 75 V in 20 ms.
        let most = 37.5 * TAU as f32 * 100.0 / 5000.0 + 75.0 / 0.02 / 5000.0 + 0.5;
        assert!((y - last).abs() < most, "{n}: {last} {y}");
        last = y;
    }
}

/// Under a long latency the output is many counts ahead of the hand: a change of texture begins
/// where the output is.
#[test]
fn a_change_of_texture_under_latency_is_no_step() {
    let encoder = Encoder {
        latency_s: 2e-3,
        ..Encoder::OKAMOTO
    };
    let mut stimulus =
        Stimulus::new(Actuator::PIEZO, encoder, AmplitudeLaw::OKAMOTO).expect("a stimulus");
    stimulus.down();
    let mut last = 75.0f32;
    for n in 0..5000 {
        if n % 300 == 0 {
            let period_mm = [1.0, 2.0, 0.8][(n as usize / 300) % 3];
            stimulus
                .set_texture(&Texture {
                    power: 3000.0,
                    ..Texture::new(period_mm)
                })
                .expect("a texture");
        }
        let y = stimulus.next(counts(100.0 * f64::from(n) / RATE_HZ));
        // 37.5 V at 125 Hz, and the fade of 75 V in 20 ms.
        let most = 37.5 * TAU as f32 * 125.0 / 5000.0 + 75.0 / 0.02 / 5000.0 + 0.5;
        assert!((y - last).abs() < most, "{n}: {last} {y}");
        last = y;
    }
}

#[test]
fn overtones_are_where_they_belong() {
    let mut texture = Texture {
        power: 6000.0,
        ..Texture::new(2.0)
    };
    texture.overtones[1] = Harmonic {
        amplitude: 0.5,
        phase_cycles: 0.25,
    };
    let mut stimulus = Stimulus::new(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)
        .expect("a stimulus");
    stimulus.set_texture(&texture).expect("a texture");
    stimulus.down();
    // 50 mm/s: 25 and 75 Hz, over whole seconds.
    let y: Vec<f64> = (0..10_000)
        .map(|n| f64::from(stimulus.next(counts(0.01 * f64::from(n)))) - 75.0)
        .collect();
    let part = |harmonic: f64| {
        let (mut s, mut c) = (0.0, 0.0);
        for (n, y) in y.iter().enumerate().skip(5000) {
            let (sin, cos) = (TAU * harmonic * (0.01 * n as f64 + 0.005) / 2.0).sin_cos();
            (s, c) = (s + y * sin / 2500.0, c + y * cos / 2500.0);
        }
        (s, c)
    };
    let (fundamental, second, third) = (part(1.0), part(2.0), part(3.0));
    assert!(
        (fundamental.0 - 50.0).abs() < 0.5 && fundamental.1.abs() < 2.0,
        "{fundamental:?}"
    );
    assert!(second.0.hypot(second.1) < 0.5, "{second:?}");
    assert!(
        (third.1 - 25.0).abs() < 0.5 && third.0.abs() < 2.0,
        "{third:?}"
    );
}
