//! The stylus's image: a simulated hand moves the encoder, and what the converter puts out is
//! compared with the surface in f64.

#[path = "stylus/bench.rs"]
mod bench;
#[path = "stylus/safety.rs"]
mod safety;

use bench::{DEFAULT, IRQ_TIM6, Stylus, against, amplitude_v, request, states};
use ridgetone_stimulus::{Actuator, Harmonic, Texture};
use ridgetone_stylus::gate::State;
use ridgetone_stylus::message::{Command, Outcome};
use ridgetone_stylus::parameters::Parameters;
use std::f64::consts::TAU;

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn it_waits_at_0_v_until_it_is_enabled_and_rises_softly() {
    let mut stylus = Stylus::ready();
    stylus.move_hand(|t_s| 100.0 * t_s);
    // A texture alone is not enough.
    stylus.command(Command::Texture(Texture::new(1.4)));
    stylus.run_alive_s(0.3);
    assert!(
        stylus
            .emulator
            .outputs()
            .iter()
            .all(|output| output.code == Some(0))
    );
    assert_eq!(states(&stylus), []);
    // The command to vibrate alone is not enough either: the output goes to its rest.
    let mut enabled = Stylus::ready();
    enabled.move_hand(|t_s| 100.0 * t_s);
    let from = enabled.emulator.outputs().len();
    enabled.command(Command::Enable);
    enabled.run_alive_s(0.2);
    assert_eq!(states(&enabled), [State::NoTexture]);
    let codes: Vec<u16> = enabled.emulator.outputs()[from..]
        .iter()
        .filter_map(|output| output.code)
        .collect();
    assert!(
        codes[0] == 0
            && codes
                .windows(2)
                .all(|pair| (0..=10).contains(&(pair[1] - pair[0]))),
        "softly"
    );
    let risen = codes.iter().position(|code| *code == 2048);
    // 20 ms, and the request's way.
    assert!(
        risen.is_some_and(|at| (205..230).contains(&at)) && codes.last() == Some(&2048),
        "{risen:?}"
    );
    enabled.assert_limits(&Actuator::PIEZO);
}

type Hand = (&'static str, fn(f64) -> f64);

/// Places, millimetres by seconds: the paper's mean hand (section IV-A), its fastest, to both
/// sides, and a slow one.
const HANDS: [Hand; 4] = [
    ("197 mm/s at 1.07 Hz", |t| {
        197.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t).cos())
    }),
    ("230 mm/s", |t| 230.0 * t),
    ("-230 mm/s", |t| -230.0 * t),
    ("20 mm/s at 0.5 Hz", |t| {
        20.0 / (TAU * 0.5) * (TAU * 0.5 * t).sin()
    }),
];

/// y = A sin(2 pi x / period) + B at the middle of the time that each code is put out, by equations
/// 2 and 3.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_output_is_the_surface() {
    for (name, place) in HANDS {
        for period_mm in [0.8, 1.0, 1.4, 2.0] {
            let mut stylus = Stylus::ready();
            stylus.command(Command::Texture(Texture::new(period_mm as f32)));
            stylus.command(Command::Enable);
            let from_s = stylus.now_s();
            stylus.move_hand(place);
            stylus.run_alive_s(1.2);
            stylus.assert_limits(&Actuator::PIEZO);
            let true_v = amplitude_v(period_mm);
            // The filter settles and the vibration comes within 0.1 s.
            let volts = stylus.volts_from(from_s + 0.1);
            let [amplitude, phase, worst] =
                against(&volts, |t_s| place(t_s - from_s), period_mm, true_v);
            let case = format!(
                "{name}, {period_mm} mm: amplitude {amplitude:.5}, phase {phase:+.5} cycles, worst {worst:.4}"
            );
            println!("{case}");
            assert!((amplitude - 1.0).abs() < 0.01, "{case}");
            assert!(phase.abs() < 0.02, "{case}");
            // No sample is 0.02 cycles off; a code is 37 mV.
            assert!(worst < 0.02 * TAU + 0.037 / true_v, "{case}");
        }
    }
}

/// Another texture in the middle of the motion: no step beyond the steepest sine of this hand, its
/// fade and a code.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn textures_change_in_the_motion_without_a_step() {
    let mut stylus = Stylus::ready();
    stylus.command(Command::Texture(Texture {
        power: 6000.0,
        ..Texture::new(1.0)
    }));
    stylus.command(Command::Enable);
    let from_s = stylus.now_s();
    stylus.move_hand(|t_s| 150.0 * t_s);
    for n in 0..20 {
        stylus.run_s(0.05 + 0.0007 * f64::from(n));
        let period_mm = [2.0, 1.0, 1.4, 0.8][n as usize % 4];
        let texture = Texture {
            power: 6000.0,
            ..Texture::new(period_mm)
        };
        assert_eq!(stylus.command(Command::Texture(texture)), Outcome::Done);
    }
    stylus.assert_limits(&Actuator::PIEZO);
    let volts = stylus.volts_from(from_s);
    // 75 V at 187.5 Hz, 75 V in 20 ms, and two codes.
    let most = 75.0 * TAU * 187.5 / 10_000.0 + 75.0 / 200.0 + 2.0 * 150.0 / 4095.0;
    let step = volts
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1).abs())
        .fold(0.0, f64::max);
    println!("greatest step {step:.2} V of {most:.2} V");
    assert!(step < most && step > 0.5 * most, "{step} {most}");
    // After the last change the amplitude is that of its period, at any phase.
    let last_s = stylus.now_s();
    stylus.run_s(0.3);
    let place = |t_s: f64| 150.0 * (t_s - from_s);
    let [amplitude, ..] = against(&stylus.volts_from(last_s + 0.05), place, 0.8, 75.0);
    assert!((amplitude - 1.0).abs() < 0.01, "{amplitude}");
}

/// A tenth of the time between two samples for the interrupt, with all harmonics and a resonance,
/// while bytes arrive one behind the other; and not one sample late, in 8 s of this.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn every_sample_is_in_time() {
    let mut stylus = Stylus::ready();
    let actuator = Actuator {
        resonance: (200.0, 3.0),
        ..Actuator::PIEZO
    };
    assert_eq!(
        stylus.command(Command::Configure(Parameters {
            actuator,
            ..DEFAULT
        })),
        Outcome::Done
    );
    let overtone = |phase_cycles| Harmonic {
        amplitude: 0.3,
        phase_cycles,
    };
    let texture = Texture {
        overtones: [0.1, -0.7, 0.4].map(overtone),
        power: 6000.0,
        ..Texture::new(2.0)
    };
    stylus.command(Command::Texture(texture));
    stylus.command(Command::Enable);
    stylus.move_hand(|t_s| 40.0 * (TAU * 0.7 * t_s).sin());
    stylus.emulator.forget_served();
    let reads = stylus.emulator.encoder_reads_ns().len();
    let outputs = stylus.emulator.outputs().len();
    for n in 0..40 {
        let texture = Texture {
            period_mm: 1.0 + 0.02 * n as f32,
            ..texture
        };
        let many: Vec<u8> = (0..200)
            .flat_map(|number| request(5000 + 200 * n + number, Command::Texture(texture)))
            .collect();
        stylus.emulator.send(&many);
        stylus.run_s(0.2);
    }
    assert_eq!(states(&stylus).last(), Some(&State::Vibrating));
    let (served, line) = (stylus.emulator.served(IRQ_TIM6), stylus.emulator.served(39));
    println!("the interrupt of a sample: {served:?}");
    println!("the line's: {line:?}");
    // 100 us at 168 MHz.
    assert!(
        served.times > 79_000 && served.longest_run_cycles <= 1680,
        "{served:?}"
    );
    let outputs = &stylus.emulator.outputs()[outputs..];
    assert!(
        outputs
            .windows(2)
            .all(|pair| (pair[1].at_ns - pair[0].at_ns).abs_diff(100_000) <= 1),
        "to the cycle"
    );
    // From the reading of the encoder to the next trigger.
    let reads_ns = &stylus.emulator.encoder_reads_ns()[reads..];
    let next = |ns: u64| {
        outputs
            .iter()
            .map(|output| output.at_ns)
            .find(|at| *at > ns)
    };
    let spans: Vec<u64> = reads_ns
        .iter()
        .step_by(97)
        .filter_map(|ns| Some(next(*ns)? - ns))
        .collect();
    println!(
        "from reading to output: {:?} to {:?} ns",
        spans.iter().min(),
        spans.iter().max()
    );
    let health = stylus.health();
    println!("{health:?}");
    assert_eq!((health.deadlines_missed, health.bytes_overrun), (0, 0));
    assert!(
        health.stack_used_bytes > 0 && health.stack_bytes - health.stack_used_bytes > 4096,
        "{health:?}"
    );
    stylus.assert_limits(&actuator);
}
