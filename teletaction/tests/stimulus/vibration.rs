//! A hand whose positions arrive one by one, as sound: against the surface in f64, and within its
//! limits.

use ridgetone_teletaction::stimulus::{Actuator, AmplitudeLaw, Delay, Texture, Vibration};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 48_000.0;

/// A hand that goes to and fro at 1.07 Hz, at most 120 mm/s.
fn position_mm(t_s: f64) -> f64 {
    120.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t_s).cos())
}

/// Greatest error of the samples of 2 s against the surface under a hand `delay_s` ago, over the
/// amplitude. A position comes each 8 ms.
fn worst(period_mm: f32, wait_s: f64, delay_s: f64) -> f64 {
    let mut vibration =
        Vibration::<256>::new(Actuator::PIEZO, AmplitudeLaw::OKAMOTO, RATE_HZ as f32)
            .expect("a vibration");
    vibration
        .set_texture(&Texture::new(period_mm))
        .expect("a texture");
    vibration
        .set_delay(
            Delay::new(delay_s as f32, 0.0, 1).expect("a delay"),
            wait_s as f32,
        )
        .expect("a delay");
    let amplitude = f64::from(AmplitudeLaw::OKAMOTO.fraction(period_mm, 0.0));
    let (mut reported, mut worst) = (0, 0.0f64);
    for n in 0..96_000 {
        let t_s = f64::from(n) / RATE_HZ;
        while 0.008 * f64::from(reported) <= t_s {
            let at_s = 0.008 * f64::from(reported);
            vibration.down(at_s, position_mm(at_s));
            reported += 1;
        }
        let y = f64::from(vibration.next(t_s));
        if t_s > 0.1 + wait_s + delay_s {
            let x_mm = position_mm(t_s - wait_s - delay_s);
            worst = worst.max((y / amplitude - (TAU * x_mm / f64::from(period_mm)).sin()).abs());
        }
    }
    worst
}

#[test]
fn the_sound_is_the_surface_under_the_hand_the_stated_time_ago() {
    for (period_mm, wait_s, delay_s) in [(1.0, 0.01, 0.0), (1.4, 0.02, 0.0), (2.0, 0.01, 0.12)] {
        let worst = worst(period_mm, wait_s, delay_s);
        // Straight lines between positions 8 ms apart are off by v' t^2 / 8, 6.5 um; the tracker lags
        // as much: 0.02 cycles.
        assert!(
            worst < 0.02 * TAU,
            "{period_mm} mm, {wait_s} s, {delay_s} s: {worst}"
        );
    }
}

#[test]
fn without_a_wait_places_are_missing() {
    assert!(worst(1.0, 0.0, 0.0) > 0.5);
}

#[test]
fn no_step_is_beyond_the_slew_whatever_hand_and_delay_do() {
    // The hand is lifted every 90 ms: with a delay that is longer it rests, and a carrier is silent.
    for (carrier_hz, delay_s) in [(None, 0.12), (Some(250.0), 0.02)] {
        no_step_is_beyond_the_slew(carrier_hz, delay_s);
    }
}

fn no_step_is_beyond_the_slew(carrier_hz: Option<f32>, delay_s: f32) {
    let actuator = Actuator {
        slew_v_s: 50_000.0,
        ..Actuator::PIEZO
    };
    let mut vibration =
        Vibration::<64>::new(actuator, AmplitudeLaw::OKAMOTO, RATE_HZ as f32).expect("a vibration");
    vibration
        .set_delay(Delay::new(delay_s, 0.04, 3).expect("a delay"), 0.01)
        .expect("a delay");
    vibration.set_carrier(carrier_hz).expect("a carrier");
    let (mut last, mut loudest) = (0.0f32, 0.0f32);
    for n in 0..96_000u32 {
        let t_s = f64::from(n) / RATE_HZ;
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
        .map(|n| vibration.next(2.0 + f64::from(n) / RATE_HZ))
        .last();
    assert_eq!((end, vibration.amplitude()), (Some(0.0), 0.0));
}

/// A tone whose amplitude is the surface, which a hand at 28 mm/s passes with 20 Hz; it is silent
/// under a hand that rests.
#[test]
fn a_carrier_has_the_texture_as_its_envelope() {
    let mut vibration =
        Vibration::<256>::new(Actuator::PIEZO, AmplitudeLaw::OKAMOTO, RATE_HZ as f32)
            .expect("a vibration");
    vibration
        .set_texture(&Texture::new(1.4))
        .expect("a texture");
    for refused in [0.0, 149.0, 251.0, f32::NAN] {
        assert!(vibration.set_carrier(Some(refused)).is_err(), "{refused}");
    }
    vibration.set_carrier(Some(200.0)).expect("a carrier");
    let amplitude = f64::from(AmplitudeLaw::OKAMOTO.fraction(1.4, 0.0));
    vibration.down(0.0, 0.0);
    let (mut worst, mut loudest) = (0.0f64, 0.0f64);
    for n in 0..96_000 {
        let t_s = f64::from(n) / RATE_HZ;
        // It moves for a second.
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
