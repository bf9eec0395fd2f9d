//! What a stylus does when its hand leaves, its line is silent or damaged, a request is impossible,
//! or its samples are late.

use crate::bench::{DEFAULT, IRQ_TIM6, Stylus, against, amplitude_v, request, states};
use ridgetone_emulator::ProcessorFault;
use ridgetone_proto::boot::ResetCause;
use ridgetone_proto::command::{Command as FingerCommand, Request as FingerRequest};
use ridgetone_proto::framing;
use ridgetone_stimulus::{Actuator, Harmonic, Texture};
use ridgetone_stylus::gate::State;
use ridgetone_stylus::message::{Command, Event, Outcome};
use ridgetone_stylus::parameters::Parameters;
use std::f64::consts::TAU;

fn damaged(stylus: &Stylus) -> u32 {
    let of = |event: &Event| {
        if let Event::Damaged(damaged) = event {
            Some(damaged.requests)
        } else {
            None
        }
    };
    stylus.events.iter().filter_map(of).sum()
}

/// One that vibrates: a texture of this period under a hand at 100 mm/s.
fn vibrating(period_mm: f32) -> Stylus {
    let mut stylus = Stylus::ready();
    assert_eq!(
        stylus.command(Command::Texture(Texture::new(period_mm))),
        Outcome::Done
    );
    assert_eq!(stylus.command(Command::Enable), Outcome::Done);
    stylus.move_hand(|t_s| 100.0 * t_s);
    stylus.run_alive_s(0.3);
    stylus
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_hand_that_leaves_and_a_line_that_is_silent_stop_it_softly() {
    // The hand stops at 30 mm.
    let mut stylus = vibrating(2.0);
    let from_s = stylus.now_s();
    stylus.move_hand(|t_s| 100.0 * t_s.min(0.2));
    stylus.run_alive_s(1.2);
    assert_eq!(
        states(&stylus),
        [State::HandStill, State::Vibrating, State::HandStill]
    );
    let rests = |volts: &[(f64, f64)]| volts.iter().all(|(_, v)| (v - 75.0).abs() < 0.04);
    // 0.2 s of motion, 0.5 s until it counts as still, and 20 ms.
    assert!(rests(&stylus.volts_from(from_s + 0.725)) && !rests(&stylus.volts_from(from_s + 0.6)));
    // 10 codes a sample of 20 ms for the whole, and one of rounding.
    let fading = stylus.volts_from(from_s + 0.3);
    assert!(
        fading
            .windows(2)
            .all(|pair| (pair[1].1 - pair[0].1).abs() < 12.0 * 150.0 / 4095.0)
    );
    // It goes on when the hand does.
    stylus.move_hand(|t_s| -100.0 * t_s);
    stylus.run_alive_s(0.2);
    assert_eq!(states(&stylus).last(), Some(&State::Vibrating));
    stylus.assert_limits(&Actuator::PIEZO);

    // The line falls silent while the hand moves on.
    let quiet_s = stylus.now_s();
    stylus.run_s(1.0);
    assert_eq!(states(&stylus).last(), Some(&State::LineSilent));
    // The last request came up to 0.1 s before.
    assert!(
        rests(&stylus.volts_from(quiet_s + 0.525)) && !rests(&stylus.volts_from(quiet_s + 0.35))
    );
    // It does not go on by itself.
    stylus.run_alive_s(0.2);
    assert_eq!(states(&stylus).last(), Some(&State::LineSilent));
    stylus.command(Command::Enable);
    stylus.run_s(0.1);
    assert_eq!(states(&stylus).last(), Some(&State::Vibrating));
    // The command to stop ends the vibration too.
    stylus.command(Command::Disable);
    let off_s = stylus.now_s();
    stylus.run_s(0.1);
    assert!(
        states(&stylus).last() == Some(&State::Disabled)
            && rests(&stylus.volts_from(off_s + 0.025))
    );
    stylus.assert_limits(&Actuator::PIEZO);
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn what_is_impossible_or_damaged_is_refused_by_name() {
    let mut stylus = vibrating(1.4);
    let from_s = stylus.now_s();
    let refused = |outcome: Outcome| match outcome {
        Outcome::Refused(error) => error.field.to_string(),
        outcome => panic!("{outcome:?}"),
    };
    let texture = Texture::new(1.0);
    let wrong = Harmonic {
        amplitude: f32::NAN,
        phase_cycles: 0.0,
    };
    for (texture, name) in [
        (Texture::new(f32::NAN), "period_mm"),
        (Texture::new(0.0), "period_mm"),
        (Texture::new(-1.0), "period_mm"),
        (Texture::new(1e30), "period_mm"),
        (
            Texture {
                power: f32::INFINITY,
                ..texture
            },
            "power",
        ),
        (
            Texture {
                period_sigma_mm: -0.1,
                ..texture
            },
            "period_sigma_mm",
        ),
        (
            Texture {
                overtones: [wrong; 3],
                ..texture
            },
            "amplitude",
        ),
    ] {
        assert_eq!(refused(stylus.command(Command::Texture(texture))), name);
    }
    let actuator = Actuator {
        voltage_v: f32::NAN,
        ..Actuator::PIEZO
    };
    assert_eq!(
        refused(stylus.command(Command::Configure(Parameters {
            actuator,
            ..DEFAULT
        }))),
        "voltage_v"
    );
    assert_eq!(
        stylus.command(Command::Configure(DEFAULT)),
        Outcome::NotAtRest
    );
    // A repeated number is a repeated request.
    assert_eq!(stylus.repeat(1000, Command::Alive), Outcome::Done);
    assert_eq!(stylus.repeat(1000, Command::Disable), Outcome::Done);
    assert_eq!(damaged(&stylus), 0);

    // Each byte of a request with one bit flipped, a finger's request, and noise.
    let whole = request(7, Command::Texture(Texture::new(2.0)));
    for at in 1..whole.len() - 1 {
        let mut bytes = whole.clone();
        // A byte that becomes zero would end the frame there: two damaged ones.
        bytes[at] ^= if bytes[at] == 0x10 { 0x20 } else { 0x10 };
        let before = damaged(&stylus);
        stylus.emulator.send(&bytes);
        stylus.run_s(0.012);
        assert_eq!(damaged(&stylus) - before, 1, "byte {at}");
        stylus.command(Command::Alive);
    }
    let mut wire = [0; 64];
    let finger = FingerRequest {
        number: 8,
        command: FingerCommand::Greet,
    };
    let used = framing::encode(&finger, &mut wire).expect("it fits");
    let noise: Vec<u8> = (0..5000u32)
        .map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    for bytes in [&wire[..used], &noise] {
        let before = damaged(&stylus);
        stylus.emulator.send(bytes);
        stylus.run_s(0.1);
        // A zero ends the noise.
        stylus.emulator.send(&[0]);
        assert!(damaged(&stylus) > before);
        stylus.command(Command::Alive);
    }
    // The texture in force is the one before all of it.
    let volts = stylus.volts_from(from_s);
    let true_v = amplitude_v(1.4);
    let [amplitude, _, _] = against(&volts, |t_s| 100.0 * (t_s - from_s), 1.4, true_v);
    assert!((amplitude - 1.0).abs() < 0.01, "{amplitude}");
    let health = stylus.health();
    assert_eq!(
        (health.requests_damaged, health.bytes_overrun),
        (damaged(&stylus), 0)
    );
    stylus.assert_limits(&Actuator::PIEZO);
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn missed_deadlines_are_counted_and_the_output_holds() {
    let mut stylus = vibrating(1.4);
    assert_eq!(stylus.health().deadlines_missed, 0);
    stylus.command(Command::Enable);
    stylus.run_s(0.1);
    stylus.emulator.inject(ProcessorFault::Mask(IRQ_TIM6));
    let masked = stylus.emulator.outputs().len();
    stylus.run_s(0.001);
    stylus.emulator.inject(ProcessorFault::Unmask(IRQ_TIM6));
    let held = &stylus.emulator.outputs()[masked + 1..];
    assert!(
        held.len() >= 8 && held.iter().all(|output| output.code == held[0].code),
        "{held:?}"
    );
    let missed = stylus.health().deadlines_missed;
    // Ten triggers, of which the last may have had its run.
    assert!((9..=10).contains(&missed), "{missed}");
    stylus.assert_limits(&Actuator::PIEZO);
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn limits_hold_whatever_comes() {
    let mut stylus = Stylus::ready();
    // 2000 V/s are 0.2 V a sample: 5 codes.
    let actuator = Actuator {
        slew_v_s: 2000.0,
        ..Actuator::PIEZO
    };
    let parameters = Parameters {
        actuator,
        still_s: 0.05,
        silence_s: 0.2,
        ..DEFAULT
    };
    assert_eq!(
        stylus.command(Command::Configure(parameters)),
        Outcome::Done
    );
    // A hand that jumps, turns and shakes, faster than any.
    stylus.move_hand(|t_s| match (20.0 * t_s) as u32 % 5 {
        0 => 300.0 * t_s,
        1 => 50.0 * (TAU * 40.0 * t_s).sin(),
        2 => -2000.0 * t_s,
        3 => f64::from((t_s * 1e4) as u32 % 7) * 9.0,
        _ => 0.0,
    });
    let mut seed = 1u32;
    for number in 2000..2400 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let value = [0.06, 0.3, 1.0, 2.5, 90.0, f32::NAN, -1.0][(seed >> 20) as usize % 7];
        let overtones = [Harmonic {
            amplitude: (seed >> 24) as f32 / 200.0,
            phase_cycles: 0.5,
        }; 3];
        let texture = Texture {
            power: 10.0 * (seed >> 22) as f32,
            overtones,
            ..Texture::new(value)
        };
        let command = match (seed >> 10) % 8 {
            0 => Command::Disable,
            1 | 2 => Command::Enable,
            3 => Command::Configure(parameters),
            _ => Command::Texture(texture),
        };
        let mut bytes = request(number, command);
        if (seed >> 14).is_multiple_of(5) {
            let at = (seed >> 16) as usize % bytes.len();
            bytes[at] ^= 1 << (seed >> 29);
        }
        stylus.emulator.send(&bytes);
        stylus.run_s(0.004 + f64::from(seed >> 18) * 1e-6);
    }
    stylus.assert_limits(&actuator);
    let moved = stylus
        .emulator
        .outputs()
        .iter()
        .filter_map(|output| output.code)
        .any(|code| code.abs_diff(2048) > 400);
    assert!(moved && stylus.emulator.resets().is_empty());
    assert_eq!(stylus.health().deadlines_missed, 0);
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn it_goes_down_softly_before_it_restarts_and_a_dead_sampler_is_reset() {
    let mut stylus = vibrating(1.4);
    assert_eq!(stylus.command(Command::Restart), Outcome::Done);
    assert_eq!(stylus.command(Command::Enable), Outcome::Restarting);
    stylus.run_s(0.2);
    assert_eq!(stylus.emulator.resets().len(), 1);
    let outputs = stylus.emulator.outputs();
    let off = outputs
        .iter()
        .rposition(|output| output.code.is_none())
        .expect("the pin is let go");
    assert_eq!(outputs[off - 1].code, Some(0), "from 0 V");
    stylus.run_s(0.3);
    assert_eq!(
        stylus
            .emulator
            .outputs()
            .last()
            .and_then(|output| output.code),
        Some(0),
        "and stays there"
    );
    stylus.assert_limits(&Actuator::PIEZO);

    let mut dead = Stylus::ready();
    dead.emulator.inject(ProcessorFault::Mask(IRQ_TIM6));
    dead.run_s(9.5);
    assert_eq!(dead.emulator.resets().len(), 1);
    let watchdog = |event: &Event| matches!(event, Event::Hello(hello) if hello.boot.cause == ResetCause::Watchdog);
    assert!(dead.events.iter().any(watchdog), "{:?}", dead.events.last());
}
