//! Every scan plan in the emulator: stored before the start, or sent by a request.

use super::requests::talk;
use hal_mock::Sliding;
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::{Input, Opened};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Health, Packet, Span, Status};

/// The plan's tone: 200 or 400 Hz for 0.3 s; with the paper's plan 8.33 Hz.
fn scene(plan: &Plan) -> Sliding {
    match *plan {
        Plan::PAPER => Sliding::default(),
        Plan::HAND => Sliding {
            speed_mm_s: 200.0,
            period_mm: 1.0,
            ..Sliding::default()
        },
        _ => Sliding {
            speed_mm_s: 200.0,
            period_mm: 0.5,
            ..Sliding::default()
        },
    }
}

fn last_health(packets: &[Packet]) -> Health {
    let health = packets.iter().rev().find_map(|packet| match packet.event {
        Event::Health(health) => Some(health),
        _ => None,
    });
    health.expect("health")
}

/// Runs the image with a plan, which loses nothing and skips no stride; gives its telemetry.
fn run(name: &str, plan: Plan, input: Opened) -> Vec<Packet> {
    let elf = emulator::image::find().expect("an image");
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let options = Options {
        settings: Settings::DEFAULT.with_plan(plan),
        ..Options::new(&elf)
    };
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0),
        "{name}"
    );
    let health = last_health(&packets);
    assert_eq!(
        (health.conversions_lost, health.chip_restarts),
        (0, 0),
        "{name}: {health:?}"
    );
    // A whole slide that is due ends the fit of a window.
    let slides = packets
        .iter()
        .filter(|packet| matches!(packet.event, Event::Slide(slide) if slide.end_us.is_some()))
        .count();
    assert!(health.overruns as usize <= slides, "{name}: {health:?}");
    packets
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn each_plan_finds_its_tone_in_the_emulator() {
    for (name, plan) in Plan::usual(Converters::ADS1258) {
        let scene = scene(&plan);
        let frequency_hz = scene.speed_mm_s / scene.period_mm;
        let input = Input {
            scene,
            ..Input::default()
        }
        .open_in(&plan)
        .expect("an input");
        let packets = run(name, plan, input);
        let slide = packets.iter().find_map(|packet| match &packet.event {
            Event::Estimate(one) if one.span == Span::Slide => Some(one.clone()),
            _ => None,
        });
        let slide = slide.unwrap_or_else(|| panic!("{name}: no estimate of a slide"));
        let off = (f64::from(slide.frequency) - frequency_hz).abs() / f64::from(slide.sigma);
        assert!(
            slide.status == Status::Good && off < 6.0,
            "{name}: {slide:?}"
        );
        assert_eq!(slide.channels.len(), plan.channels(), "{name}");
        let health = last_health(&packets);
        assert!(
            (health.frame_rate_hz / plan.frame_rate_hz() - 1.0).abs() < 1e-3,
            "{name}: {health:?}"
        );
        assert!((health.supply_v - 5.0).abs() < 0.01, "{name}: {health:?}");
    }
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_plan_that_is_sent_is_in_force_after_a_greeting_and_says_what_it_gives() {
    let plan = Plan::HAND;
    let settings = Settings::DEFAULT.with_plan(plan);
    let run = talk(
        &[],
        vec![Command::Set {
            settings,
            keep: false,
        }],
    );
    assert_eq!(
        run.answers
            .iter()
            .map(|(_, outcome)| outcome)
            .collect::<Vec<_>>(),
        [&Outcome::Done]
    );
    let gives = run.packets.iter().find_map(|packet| match &packet.event {
        Event::Reply(reply) => reply.gives,
        _ => None,
    });
    assert_eq!(gives, Some(plan.gives()));
    let greeted = run.packets.iter().any(|packet| {
        matches!(&packet.event, Event::Hello(hello) if hello.settings == settings && hello.frame_rate_hz == plan.frame_rate_hz())
    });
    assert!(greeted);
    let health = last_health(&run.packets);
    assert_eq!(
        (health.conversions_lost, health.chip_restarts),
        (0, 0),
        "{health:?}"
    );
    // The fit of the whole slide may take the place of a window.
    assert!(health.overruns <= 1, "{health:?}");
    assert!(
        (health.frame_rate_hz / plan.frame_rate_hz() - 1.0).abs() < 1e-3,
        "{health:?}"
    );
}
