//! Tests requests to the emulated board over its serial line.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::Input;
use ridgetone_host::requests::{Requests, TRIES};
use ridgetone_proto::boot::{ResetCause, SettingsSource};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, SettingsError};
use ridgetone_proto::telemetry::{Event, Packet, Span};
use std::time::Duration;

/// Result of a run: the packets, and each answer with the number of packets up to it.
pub struct Talked {
    pub packets: Vec<Packet>,
    pub answers: Vec<(usize, Outcome)>,
    pub outcome: emulator::Outcome,
}

impl Talked {
    fn events_behind(&self, answer: usize) -> &[Packet] {
        &self.packets[self.answers[answer].0..]
    }
}

/// Runs the default scene. After the greeting, sends these bytes and then these commands.
pub fn talk(bytes: &[u8], commands: Vec<Command>) -> Talked {
    let elf = emulator::image::find().expect("an image");
    let mut requests = Requests::new(700);
    let (mut packets, mut answers) = (Vec::new(), Vec::new());
    let (mut first, count) = (Some((bytes.to_vec(), commands.clone())), commands.len());
    let mut talk = |now: Duration, packet: Option<(&Packet, f64)>| {
        let mut sent = Vec::new();
        if let Some((packet, _)) = packet {
            packets.push(packet.clone());
            if let Some((bytes, commands)) = first.take() {
                sent = bytes;
                commands
                    .into_iter()
                    .for_each(|command| requests.push(command));
            }
            answers.extend(
                requests
                    .answered(&packet.event)
                    .map(|(_, outcome)| (packets.len(), outcome)),
            );
        }
        sent.extend(requests.due(now)?);
        Ok(sent)
    };
    let input = Input::default().open().expect("an input");
    let outcome =
        emulator::run_packets(input, Options::new(&elf), &mut talk, &mut |_, _| {}).expect("a run");
    assert_eq!(answers.len(), count, "every request is answered once");
    let replies = packets
        .iter()
        .filter(|packet| matches!(packet.event, Event::Reply(_)))
        .count();
    assert!(replies >= count);
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0)
    );
    Talked {
        packets,
        answers,
        outcome,
    }
}

fn windows_s(packets: &[Packet]) -> Vec<f32> {
    let window = |packet: &Packet| match &packet.event {
        Event::Estimate(fit) if fit.span == Span::Window => Some(fit.window_s),
        _ => None,
    };
    packets.iter().filter_map(window).collect()
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn settings_that_were_sent_are_in_force_and_others_are_refused() {
    let settings = Settings {
        window_s: 0.4,
        stride_s: 0.1,
        ..Settings::DEFAULT
    };
    let bad = Settings {
        window_s: 5.0,
        ..Settings::DEFAULT
    };
    let run = talk(
        &[],
        vec![
            Command::Set {
                settings,
                keep: true,
            },
            Command::Set {
                settings: bad,
                keep: true,
            },
            Command::Raw { frames: 10 },
        ],
    );
    let field = "window_s".try_into().expect("a name");
    let refused = Outcome::Setting(SettingsError {
        field,
        value: 5.0,
        min: 0.1,
        max: 3.9,
    });
    let outcomes: Vec<_> = run
        .answers
        .iter()
        .map(|(_, outcome)| outcome.clone())
        .collect();
    assert_eq!(outcomes, [Outcome::Done, refused, Outcome::Done]);
    // The greeting must be repeated with the current settings.
    let hello = run.packets.iter().filter_map(|packet| match &packet.event {
        Event::Hello(hello) => Some((hello.settings, hello.source)),
        _ => None,
    });
    let hello: Vec<_> = hello.collect();
    assert_eq!(
        hello[..2],
        [
            (Settings::DEFAULT, SettingsSource::Default),
            (settings, SettingsSource::Sent)
        ]
    );
    let windows_s = windows_s(&run.packets);
    assert!(
        windows_s.len() > 10 && windows_s.iter().all(|s| (s - 0.4).abs() < 0.005),
        "{windows_s:?}"
    );
    let raw: Vec<_> = run
        .packets
        .iter()
        .filter_map(|packet| match &packet.event {
            Event::Raw(raw) => Some(raw),
            _ => None,
        })
        .collect();
    assert_eq!(raw.len(), 10);
    assert!(
        raw.windows(2)
            .all(|pair| pair[1].number == pair[0].number + 1)
    );
    assert!(
        raw.iter()
            .all(|raw| raw.present == u16::MAX && raw.codes.iter().all(|code| *code != 0))
    );
}

/// A requested restart must apply the stored settings and no others.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn settings_that_are_kept_survive_a_restart() {
    let kept = Settings {
        window_s: 0.4,
        stride_s: 0.1,
        ..Settings::DEFAULT
    };
    let passing = Settings {
        window_s: 0.6,
        ..kept
    };
    let run = talk(
        &[],
        vec![
            Command::Set {
                settings: kept,
                keep: true,
            },
            Command::Set {
                settings: passing,
                keep: false,
            },
            Command::Restart,
        ],
    );
    assert!(
        run.answers
            .iter()
            .all(|(_, outcome)| *outcome == Outcome::Done)
    );
    let greetings: Vec<_> = run
        .packets
        .iter()
        .filter_map(|packet| match &packet.event {
            Event::Hello(hello) if packet.sequence == 0 => {
                Some((hello.boot.cause, hello.settings, hello.source))
            }
            _ => None,
        })
        .collect();
    let expected = [
        (
            ResetCause::Power,
            Settings::DEFAULT,
            SettingsSource::Default,
        ),
        (ResetCause::Software, kept, SettingsSource::Stored),
    ];
    assert_eq!(greetings, expected);
    let windows_s = windows_s(run.events_behind(2));
    assert!(
        windows_s.len() > 5 && windows_s.iter().all(|s| (s - 0.4).abs() < 0.005),
        "{windows_s:?}"
    );
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_board_that_was_stopped_sends_nothing_of_a_touch_until_it_is_started() {
    let run = talk(&[], vec![Command::Stop]);
    let behind = run.events_behind(0);
    assert!(
        behind
            .iter()
            .all(|packet| matches!(packet.event, Event::Health(_) | Event::Converter(_))),
        "{behind:?}"
    );
    assert!(behind.len() >= 3, "{behind:?}");
    let run = talk(&[], vec![Command::Stop, Command::Start]);
    let behind = run.events_behind(1);
    assert!(
        behind
            .iter()
            .any(|packet| matches!(packet.event, Event::Contact(_))),
        "{behind:?}"
    );
    assert!(windows_s(behind).len() >= 3, "{behind:?}");
}

/// Ten kilobytes of noise precede the request, about as many as the emulated line carries during
/// the scene.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn noise_on_the_line_is_counted_and_changes_nothing() {
    let mut noise = vec![0; 10_000];
    ChaCha8Rng::seed_from_u64(1).fill_bytes(&mut noise);
    let run = talk(&noise, vec![Command::Greet]);
    let mut damaged = run.packets.iter().filter_map(|packet| match &packet.event {
        Event::Health(health) => Some(health.requests_damaged),
        _ => None,
    });
    let damaged = damaged.next_back().expect("health");
    // Bytes between two zeros count as a frame. The zero in front of the request ends the last
    // frame.
    let frames = noise
        .split(|byte| *byte == 0)
        .filter(|frame| !frame.is_empty())
        .count();
    // While the noise is being sent, the request is repeated. If two requests arrive at once, the
    // second is dropped.
    assert!(
        (frames..=frames + TRIES as usize).contains(&(damaged as usize)),
        "{damaged} damaged of {frames}"
    );
    assert_eq!(
        run.answers.last().map(|(_, outcome)| outcome),
        Some(&Outcome::Done)
    );
    let in_force = run.packets.iter().all(|packet| match &packet.event {
        Event::Hello(hello) => hello.settings == Settings::DEFAULT,
        _ => true,
    });
    assert!(in_force && windows_s(&run.packets).len() >= 3);
    assert!(run.outcome.counts.received > 10);
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
    let health = run
        .packets
        .iter()
        .rev()
        .find_map(|packet| match packet.event {
            Event::Health(health) => Some(health),
            _ => None,
        });
    let health = health.expect("health");
    assert_eq!(
        (health.conversions_lost, health.chip_restarts),
        (0, 0),
        "{health:?}"
    );
    // The fit of the whole slide may displace one window.
    assert!(health.overruns <= 1, "{health:?}");
    assert!(
        (health.frame_rate_hz / plan.frame_rate_hz() - 1.0).abs() < 1e-3,
        "{health:?}"
    );
}
