//! Never beyond the limits, never a step beyond the slew, whatever comes.

use proptest::prelude::*;
use ridgetone_teletaction::stimulus::{
    Actuator, AmplitudeLaw, Encoder, Harmonic, Stimulus, Texture,
};

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

#[test]
fn a_hand_that_leaves_stops_the_vibration_softly() {
    let mut stimulus = Stimulus::new(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)
        .expect("a stimulus");
    stimulus.set_texture(&Texture::new(2.0)).expect("a texture");
    stimulus.down();
    for n in 0..1000 {
        stimulus.next(4 * n);
    }
    assert!(
        (stimulus.amplitude_v() - 55.0).abs() < 0.3,
        "{}",
        stimulus.amplitude_v()
    );
    stimulus.lift();
    // 20 ms are 100 samples for the greatest amplitude.
    let after: Vec<f32> = (1000..1100).map(|n| stimulus.next(4 * n)).collect();
    assert!(after.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 6.0));
    assert_eq!((stimulus.amplitude_v(), after[99]), (0.0, 75.0));
}

#[test]
fn fast_hands_are_held_back() {
    let amplitude = |actuator: Actuator, counts_a_sample: i32| {
        let mut stimulus =
            Stimulus::new(actuator, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO).expect("a stimulus");
        stimulus
            .set_texture(&Texture {
                power: 6000.0,
                ..Texture::new(1.0)
            })
            .expect("a texture");
        stimulus.down();
        for n in 0..2000 {
            stimulus.next(counts_a_sample * n);
        }
        stimulus.amplitude_v()
    };
    // 100, 400 and 700 Hz: the cut-off is 310 Hz, and nothing is left from 620 Hz on.
    assert_eq!(amplitude(Actuator::PIEZO, 4), 75.0);
    let faded = amplitude(Actuator::PIEZO, 16);
    assert!(
        (faded - 75.0 * (2.0 - 400.0 / 310.0)).abs() < 0.5,
        "{faded}"
    );
    assert_eq!(amplitude(Actuator::PIEZO, 28), 0.0);
}

/// A texture with overtones after one without: the peak of its waves is never beyond the
/// actuator's.
#[test]
fn overtones_find_room_below_the_voltage() {
    let mut stimulus = Stimulus::default();
    stimulus.set_texture(&Texture::new(1.4)).expect("a texture");
    stimulus.down();
    for n in 0..5000 {
        stimulus.next(4 * n);
    }
    let alone_v = stimulus.amplitude_v();
    let overtones = [Harmonic {
        amplitude: 1.0,
        phase_cycles: 0.25,
    }; 3];
    stimulus
        .set_texture(&Texture {
            overtones,
            ..Texture::new(1.4)
        })
        .expect("a texture");
    let bias_v = stimulus.actuator().bias_v();
    assert!(
        alone_v > 0.4 * bias_v && stimulus.amplitude_v() <= 0.2501 * bias_v,
        "{alone_v} {}",
        stimulus.amplitude_v()
    );
}

#[test]
fn what_is_impossible_is_refused_and_the_last_texture_stays() {
    let new = |actuator, encoder, law| Stimulus::new(actuator, encoder, law).err();
    let (a, e, l) = (Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO);
    let actuator = |change: fn(&mut Actuator)| {
        let mut actuator = a;
        change(&mut actuator);
        new(actuator, e, l)
    };
    let encoder = |change: fn(&mut Encoder)| {
        let mut encoder = e;
        change(&mut encoder);
        new(a, encoder, l)
    };
    let law = |change: fn(&mut AmplitudeLaw)| {
        let mut law = l;
        change(&mut law);
        new(a, e, law)
    };
    for (error, setting) in [
        (actuator(|a| a.voltage_v = f32::NAN), "voltage_v"),
        (actuator(|a| a.cutoff_hz = 0.0), "cutoff_hz"),
        (actuator(|a| a.slew_v_s = -1.0), "slew_v_s"),
        (actuator(|a| a.fade_s = 0.0), "fade_s"),
        (encoder(|e| e.count_mm = 0.0), "count_mm"),
        (encoder(|e| e.rate_hz = f32::INFINITY), "rate_hz"),
        (encoder(|e| e.latency_s = 1.0), "latency_s"),
        (law(|l| l.power_max = 0.0), "power_max"),
        (law(|l| l.period_mm = (2.0, 1.0)), "period_mm.1"),
    ] {
        assert_eq!(error.map(|error| error.name), Some(setting));
    }
    let mut stimulus = Stimulus::new(a, e, l).expect("a stimulus");
    stimulus.set_texture(&Texture::new(1.4)).expect("a texture");
    let mut other = stimulus;
    for texture in [
        Texture::new(0.0),
        Texture::new(f32::NAN),
        Texture {
            power: f32::INFINITY,
            ..Texture::new(1.0)
        },
    ] {
        assert!(stimulus.set_texture(&texture).is_err());
    }
    stimulus.down();
    other.down();
    for n in 0..500 {
        assert_eq!(stimulus.next(3 * n), other.next(3 * n));
    }
}
