//! A robot's odometry over the emulated board's line: as the library on this PC gets it, bit for
//! bit.

use super::by_kind;
use hal_mock::{Hand, Sliding, SlidingScene};
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::Input;
use ridgetone_host::odometry::{Stream, message};
use ridgetone_host::replay::{self, Motion};
use ridgetone_proto::odometry::FRAME_BYTES;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Abscissa, Event, Health, Packet, Span, Status};
use std::f64::consts::TAU;

const HAND: Hand = Hand {
    peak_mm_s: 60.0,
    swing_hz: 0.8,
    swings: 4.0,
};
const PERIOD_MM: f64 = 2.6;
/// The robot's clock against the board's.
const SKEW: f64 = 200e-6;

/// Messages of a hand that begins at `start_s`, 250 a second, and how many were lost, doubled and
/// damaged.
fn messages(start_s: f64, end_s: f64) -> (Stream, [u32; 4]) {
    let (mut stream, mut did) = (Stream::new(), [0; 4]);
    for number in 0..((end_s - 0.1) * 250.0) as usize {
        let t_s = 0.03 + number as f64 * 0.004;
        let since_s = (t_s - start_s).clamp(0.0, HAND.swings / HAND.swing_hz);
        let mm =
            HAND.peak_mm_s / (TAU * HAND.swing_hz) * (1.0 - (TAU * HAND.swing_hz * since_s).cos());
        let mut frame =
            message(number, 4290.0 + t_s * (1.0 + SKEW), mm, true).encode()[..FRAME_BYTES].to_vec();
        // Not in step with anything.
        let at_us = (t_s * 1e6) as u64 + 300 + (number as u64 * 7919 % 1000);
        match number % 40 {
            7 => {
                did[1] += 1;
                continue;
            }
            17 => {
                did[2] += 1;
                stream.push((at_us + 1500, frame.clone()));
            }
            27 => {
                did[3] += 1;
                // Neither a zero, nor what says that it is a message.
                frame[9] ^= if frame[9] == 0x10 { 0x20 } else { 0x10 };
            }
            _ => {}
        }
        did[0] += 1;
        stream.push((at_us, frame));
    }
    stream.sort_by_key(|(at_us, _)| *at_us);
    (stream, did)
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn windows_by_place_are_those_of_the_pc_bit_for_bit() {
    let scene = Sliding {
        period_mm: PERIOD_MM,
        hand: Some(HAND),
        // Time for the fit of the whole slide.
        release_idle_s: 2.5,
        ..Sliding::default()
    };
    let truth = SlidingScene::new(scene.clone()).expect("a scene").truth();
    let (stream, [arrived, lost, doubled, damaged]) = messages(truth.slide_start_s, truth.end_s);
    let input = Input {
        scene,
        ..Input::default()
    };
    let elf = emulator::image::find().expect("an image");
    let options = Options {
        odometry: &stream,
        ..Options::new(&elf)
    };
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let outcome = emulator::run(
        input.open().expect("an input"),
        options,
        &mut sink,
        &mut |_, _| {},
    )
    .expect("a run");
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0)
    );
    assert_eq!(outcome.heard.len(), stream.len());
    assert!(
        outcome
            .heard
            .iter()
            .zip(&stream)
            .all(|(heard, sent)| heard.1 == sent.1 && heard.0.abs_diff(sent.0) < 1000)
    );

    let mut on_pc = Vec::new();
    let mut sink = |packet: &Packet| {
        on_pc.push(packet.clone());
        Ok(())
    };
    let input = input.open().expect("an input");
    let motion = Some(Motion::Robot(outcome.heard.clone()));
    replay::run(input, Settings::DEFAULT, motion, &mut sink, &mut |_, _| {}).expect("a replay");
    assert_eq!(by_kind(&packets), by_kind(&on_pc));

    let health = packets.iter().rev().find_map(|packet| match packet.event {
        Event::Health(health) => Some(health),
        _ => None,
    });
    let health: Health = health.expect("health");
    let counts = health.odometry;
    println!(
        "{counts:?}; stack {} of {} bytes",
        health.stack_used_bytes, health.stack_bytes
    );
    assert_eq!(counts.received, arrived + doubled - damaged);
    assert_eq!(
        (counts.lost, counts.doubled, counts.windows_by_time),
        (lost + damaged, doubled, 0)
    );
    assert_eq!(
        (
            health.requests_damaged,
            health.overruns,
            health.conversions_lost
        ),
        (damaged, 0, 0)
    );
    assert!(
        health.stack_used_bytes + 1024 <= health.stack_bytes,
        "{health:?}"
    );
    let (mut windows, mut good) = (0, 0);
    for packet in &packets {
        let Event::Estimate(one) = &packet.event else {
            continue;
        };
        assert_eq!(one.abscissa, Abscissa::Place, "{one:?}");
        windows += u32::from(one.span == Span::Window);
        if one.status == Status::Good {
            good += 1;
            assert!(
                (1.0 / (f64::from(one.frequency) * PERIOD_MM) - 1.0).abs() < 0.005,
                "{one:?}"
            );
        }
    }
    assert!(windows > 12 && 2 * good > windows, "{good} of {windows}");
}
