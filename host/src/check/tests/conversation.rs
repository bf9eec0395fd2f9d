//! The conversation: settings are stored and restored, silence and losses end it with a reason.

use super::bench::Bench;
use super::{Fail, Inputs, Observations, Plan, Skipped, Verdict, Warn, find, judge};
use crate::check::{Report, gather};
use crate::client::Client;
use crate::feed::Feed;
use crate::names::name;
use crate::output::Progress;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::Command;
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Hello, PROTOCOL, Packet};

const STORES: Plan = Plan {
    length_s: 1.0,
    stores: true,
    inputs: Inputs::Shorted,
};

fn checked(feed: &mut Feed) -> (Report, Observations) {
    let seen = gather(feed, STORES, &mut Progress::default());
    (Report::new(feed.name(), &seen), seen)
}

/// A board with other greetings than its own.
fn greets(mut alter: impl FnMut(&mut Hello) + Send + 'static) -> Bench {
    let altered = move |packet: &mut Packet| {
        if let Event::Hello(hello) = &mut packet.event {
            alter(hello);
        }
    };
    Bench::with(|bench| bench.altered = Box::new(altered))
}

fn settings_check(bench: Bench) -> (Verdict, String) {
    let (report, _) = checked(&mut bench.feed());
    let check = find(&report.checks, "settings");
    (check.verdict, check.finding.clone())
}

#[test]
fn what_was_stored_and_what_was_in_force_is_restored() {
    let stored = Settings {
        window_s: 0.5,
        stride_s: 0.3,
        ..Settings::DEFAULT
    };
    let sent = Settings {
        window_s: 0.7,
        ..Settings::DEFAULT
    };
    for before in [None, Some(stored)] {
        for in_force in [None, Some(sent)] {
            let bench = Bench::with(|bench| (bench.stored, bench.in_force) = (before, in_force));
            let mut feed = bench.feed();
            let (report, seen) = checked(&mut feed);
            assert!(
                report.failed().is_empty() && seen.lent.is_none(),
                "{report}"
            );
            assert_eq!(
                find(&report.checks, "settings").verdict,
                Verdict::Pass,
                "{report}"
            );
            let mut client = Client::new(&mut feed);
            let settings = client.hello().unwrap().settings;
            assert_eq!(settings, in_force.or(before).unwrap_or_default());
            // After another start, too.
            client.request(Command::Restart).unwrap();
            let hello = client.hello().unwrap();
            assert_eq!(hello.settings, before.unwrap_or_default());
            assert_eq!(hello.source == SettingsSource::Stored, before.is_some());
        }
    }
}

#[test]
fn settings_that_are_not_found_again_fail() {
    let forgetful = greets(|hello| {
        (hello.settings, hello.source) = (Settings::DEFAULT, SettingsSource::Default);
    });
    let (report, _) = checked(&mut forgetful.feed());
    assert_eq!(report.failed(), ["settings"], "{report}");
}

/// A board that does not forget: after the third start it has other settings than at first.
#[test]
fn settings_that_are_not_restored_fail() {
    let mut was_stored = false;
    let (verdict, finding) = settings_check(greets(move |hello| {
        was_stored |= hello.source == SettingsSource::Stored;
        if was_stored && hello.source == SettingsSource::Default {
            (hello.settings.stride_s, hello.source) = (0.3, SettingsSource::Stored);
        }
    }));
    assert!(verdict == Fail && finding.starts_with("what was stored before is not restored"));
}

/// Nothing has changed in the flash, so nothing has to be restored there; the old settings are in
/// force again.
#[test]
fn a_flash_that_refuses_fails_and_leaves_what_was_stored() {
    let stored = Settings {
        window_s: 0.5,
        ..Settings::DEFAULT
    };
    let bench = Bench::with(|bench| (bench.stored, bench.is_worn) = (Some(stored), true));
    let mut feed = bench.feed();
    let (report, _) = checked(&mut feed);
    let check = find(&report.checks, "settings");
    assert!(
        check.verdict == Fail && check.finding.starts_with("not stored: "),
        "{report}"
    );
    let hello = Client::new(&mut feed).hello().unwrap();
    assert_eq!(
        (hello.settings, hello.source),
        (stored, SettingsSource::Stored)
    );
}

/// The first greeting after each restart is lost: the next one counts.
#[test]
fn a_greeting_that_is_lost_is_waited_for() {
    let mut decoder = ridgetone_proto::telemetry::Decoder::new();
    let on_line = move |_: u64, bytes: &mut Vec<u8>| {
        let packet = bytes.iter().find_map(|byte| decoder.push(*byte));
        if packet.is_some_and(|packet| packet.sequence == 0) {
            bytes.clear();
        }
    };
    let bench = Bench::with(|bench| bench.on_line = Box::new(on_line));
    assert_eq!(settings_check(bench).0, Verdict::Pass);
}

#[test]
fn stored_settings_that_cannot_be_read_are_a_warning() {
    for source in [SettingsSource::Damaged, SettingsSource::StoredBefore] {
        let (verdict, finding) = settings_check(greets(move |hello| {
            if hello.source == SettingsSource::Default {
                hello.source = source;
            }
        }));
        assert!(
            verdict == Warn && finding.contains(name(source)),
            "{finding}"
        );
    }
}

#[test]
fn another_protocol_fails_and_leaves_the_rest_unjudged() {
    let checks = judge(&greets(|hello| hello.protocol += 1).observations());
    assert_eq!((checks[0].name, checks[0].verdict), ("firmware", Fail));
    let words = format!("speaks protocol {}", PROTOCOL + 1);
    assert!(checks[0].finding.contains(&words), "{checks:#?}");
    assert!(
        checks[1..].iter().all(|check| check.verdict == Skipped),
        "{checks:#?}"
    );
}

/// RX is not connected: the board is heard, and does not answer.
#[test]
fn a_board_that_hears_nothing_fails_the_commands_and_is_judged_by_what_it_sends() {
    let received = |_, _| ridgetone_finger::tasks::Received::Byte(0);
    let (report, seen) = checked(&mut Bench::with(|bench| bench.received = received).feed());
    assert_eq!(report.failed(), ["commands"], "{report}");
    let verdicts = ["firmware", "supply", "losses"].map(|name| find(&report.checks, name).verdict);
    assert_eq!(verdicts, [Verdict::Pass, Verdict::Pass, Skipped]);
    assert!(seen.ended.is_some_and(|why| why.contains("RX")), "{report}");
}

/// In place of the fifth `health` the board greets as after a start.
#[test]
fn a_board_that_restarts_while_it_is_watched_is_noticed() {
    let (mut greeting, mut healths) = (None, 0);
    let altered = move |packet: &mut Packet| {
        if let Event::Hello(hello) = &packet.event {
            greeting = Some(hello.clone());
        } else if let Event::Health(_) = packet.event {
            healths += 1;
            if let Some(hello) = greeting.clone().filter(|_| healths == 5) {
                (packet.sequence, packet.event) = (0, Event::Hello(hello));
            }
        }
    };
    let checks = judge(&Bench::with(|bench| bench.altered = Box::new(altered)).observations());
    let losses = find(&checks, "losses");
    assert!(losses.verdict == Fail && losses.finding.contains("1 restarts of the board"));
}

/// Rates, noise and mains are judged for the default plan: it is in force meanwhile, and the
/// board's own plan before and after.
#[test]
fn a_board_with_another_plan_is_checked_with_the_default_one_and_has_its_own_again() {
    let fast = Settings {
        harmonics: 2,
        ..Settings::DEFAULT.with_plan(Scan::HAND)
    };
    for (stored, in_force) in [(None, Some(fast)), (Some(fast), None)] {
        for stores in [false, true] {
            let bench = Bench::with(|bench| (bench.stored, bench.in_force) = (stored, in_force));
            let mut feed = bench.feed();
            let plan = Plan {
                length_s: 3.0,
                stores,
                ..STORES
            };
            let report = Report::new(
                feed.name(),
                &gather(&mut feed, plan, &mut Progress::default()),
            );
            assert!(report.failed().is_empty(), "{report}");
            let finding = &find(&report.checks, "plan").finding;
            assert!(
                finding.contains("plan `hand` is in force again"),
                "{finding}"
            );
            let rate = find(&report.checks, "frame_rate");
            assert!(rate.verdict == Verdict::Pass && rate.finding.starts_with("241.1"));
            assert_eq!(
                Client::new(&mut feed).hello().unwrap().settings,
                fast,
                "{report}"
            );
        }
    }
}
