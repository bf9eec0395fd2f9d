//! The conversation: settings are stored and restored, silence and losses end it with a reason.

use super::bench::Bench;
use super::{Fail, Skipped, Warn};
use crate::check::{Inputs, Plan, Report, Verdict, gather};
use crate::client::Client;
use crate::output::Progress;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::Command;
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, PROTOCOL};

const STORES: Plan = Plan {
    length_s: 1.0,
    stores: true,
};

fn settings_check(report: &Report) -> (Verdict, &str) {
    let check = report
        .checks
        .iter()
        .find(|check| check.name == "settings")
        .unwrap();
    (check.verdict, &check.finding)
}

#[test]
fn what_was_stored_and_what_was_in_force_is_restored() {
    let stored = Settings {
        window_s: 0.5,
        hop_s: 0.3,
        ..Settings::DEFAULT
    };
    let sent = Settings {
        window_s: 0.7,
        ..Settings::DEFAULT
    };
    for before in [None, Some(stored)] {
        for in_force in [None, Some(sent)] {
            let mut feed = Bench {
                stored: before,
                in_force,
                ..Bench::default()
            }
            .feed();
            let seen = gather(&mut feed, STORES, &mut Progress::default());
            let report = Report::new(feed.name(), Inputs::Shorted, &seen);
            assert_eq!(settings_check(&report).0, Verdict::Pass, "{report}");
            let mut client = Client::new(&mut feed);
            assert_eq!(
                client.hello().unwrap().settings,
                in_force.or(before).unwrap_or_default()
            );
            // And after another start.
            client.request(Command::Restart).unwrap();
            let hello = client.hello().unwrap();
            let source = if before.is_some() {
                SettingsSource::Stored
            } else {
                SettingsSource::Default
            };
            assert_eq!(
                (hello.settings, hello.source),
                (before.unwrap_or_default(), source)
            );
        }
    }
}

/// A board whose flash forgets: after a restart it greets with the defaults.
#[test]
fn settings_that_are_not_found_again_fail() {
    let forgets = |event: &mut Event| {
        if let Event::Hello(hello) = event {
            (hello.settings, hello.source) = (Settings::DEFAULT, SettingsSource::Default);
        }
    };
    let mut feed = Bench {
        altered: Box::new(forgets),
        ..Bench::default()
    }
    .feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    let report = Report::new(feed.name(), Inputs::Shorted, &seen);
    assert_eq!(
        settings_check(&report),
        (Fail, "after a restart the stored settings are not in force")
    );
    assert_eq!(report.failed(), ["settings"]);
}

/// A board that does not forget: behind the third start it has other settings than at first.
#[test]
fn settings_that_are_not_restored_fail() {
    let mut was_stored = false;
    let altered = move |event: &mut Event| {
        if let Event::Hello(hello) = event {
            was_stored |= hello.source == SettingsSource::Stored;
            if was_stored && hello.source == SettingsSource::Default {
                (hello.settings.hop_s, hello.source) = (0.3, SettingsSource::Stored);
            }
        }
    };
    let mut feed = Bench {
        altered: Box::new(altered),
        ..Bench::default()
    }
    .feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    let report = Report::new(feed.name(), Inputs::Shorted, &seen);
    let (verdict, finding) = settings_check(&report);
    assert!(
        verdict == Fail && finding.starts_with("what was stored before is not restored"),
        "{report}"
    );
}

/// Nothing has changed in the flash, so nothing has to be restored there; the old settings are in
/// force again.
#[test]
fn a_flash_that_refuses_fails_and_leaves_what_was_stored() {
    let stored = Settings {
        window_s: 0.5,
        ..Settings::DEFAULT
    };
    let mut feed = Bench {
        stored: Some(stored),
        is_worn: true,
        ..Bench::default()
    }
    .feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    let report = Report::new(feed.name(), Inputs::Shorted, &seen);
    let (verdict, finding) = settings_check(&report);
    assert!(
        verdict == Fail && finding.starts_with("not stored: "),
        "{report}"
    );
    let hello = Client::new(&mut feed).hello().unwrap();
    assert_eq!(
        (hello.settings, hello.source),
        (stored, SettingsSource::Stored)
    );
}

/// The first greeting behind each restart is lost: the next one counts.
#[test]
fn a_greeting_that_is_lost_is_waited_for() {
    let mut decoder = Decoder::new();
    let on_line = move |_: u64, bytes: &mut Vec<u8>| {
        let packet = bytes.iter().find_map(|byte| decoder.push(*byte));
        if packet.is_some_and(|packet| packet.sequence == 0) {
            bytes.clear();
        }
    };
    let mut feed = Bench {
        on_line: Box::new(on_line),
        ..Bench::default()
    }
    .feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    let report = Report::new(feed.name(), Inputs::Shorted, &seen);
    assert_eq!(settings_check(&report).0, Verdict::Pass, "{report}");
}

#[test]
fn stored_settings_that_cannot_be_read_are_a_warning() {
    for (source, stores) in [
        (SettingsSource::Damaged, false),
        (SettingsSource::StoredBefore, true),
    ] {
        let altered = move |event: &mut Event| {
            if let Event::Hello(hello) = event
                && hello.source == SettingsSource::Default
            {
                hello.source = source;
            }
        };
        let plan = Plan {
            length_s: 1.0,
            stores,
        };
        let mut feed = Bench {
            altered: Box::new(altered),
            ..Bench::default()
        }
        .feed();
        let seen = gather(&mut feed, plan, &mut Progress::default());
        let report = Report::new(feed.name(), Inputs::Shorted, &seen);
        let (verdict, finding) = settings_check(&report);
        assert!(
            verdict == Warn && finding.contains(crate::names::name(source)),
            "{finding}"
        );
    }
}

#[test]
fn another_protocol_and_another_version_are_found() {
    let findings = Bench {
        altered: Box::new(|event| {
            if let Event::Hello(hello) = event {
                hello.protocol += 1;
            }
        }),
        ..Bench::default()
    }
    .findings();
    assert_eq!((findings[0].name, findings[0].verdict), ("firmware", Fail));
    assert!(
        findings[0]
            .finding
            .contains(&format!("speaks protocol {}", PROTOCOL + 1)),
        "{}",
        findings[0].finding
    );
    assert!(
        findings[1..].iter().all(|check| check.verdict == Skipped),
        "{findings:#?}"
    );
    let findings = Bench {
        altered: Box::new(|event| {
            if let Event::Hello(hello) = event {
                hello.version = [0, 0, 9];
            }
        }),
        ..Bench::default()
    }
    .findings();
    assert_eq!((findings[0].name, findings[0].verdict), ("firmware", Warn));
}

/// RX is not connected: the board is heard, and does not answer.
#[test]
fn a_board_that_hears_nothing_fails_the_commands_and_is_judged_by_what_it_sends() {
    let mut feed = Bench {
        received: |_, _| ridgetone::tasks::line::Received::Byte(0),
        ..Bench::default()
    }
    .feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    let report = Report::new(feed.name(), Inputs::Shorted, &seen);
    assert_eq!(report.failed(), ["commands"], "{report}");
    let verdict = |name: &str| {
        report
            .checks
            .iter()
            .find(|check| check.name == name)
            .unwrap()
            .verdict
    };
    assert_eq!(
        (verdict("firmware"), verdict("supply"), verdict("losses")),
        (Verdict::Pass, Verdict::Pass, Skipped)
    );
    assert!(
        report
            .summary
            .ended
            .as_ref()
            .is_some_and(|why| why.contains("RX")),
        "{report}"
    );
}

#[test]
fn a_board_that_restarts_while_it_is_watched_is_noticed() {
    let findings = Bench {
        restarts_at_health: Some(5),
        ..Bench::default()
    }
    .findings();
    let losses = findings
        .iter()
        .find(|check| check.name == "losses")
        .expect("a finding");
    assert!(
        losses.verdict == Fail && losses.finding.contains("1 restarts of the board"),
        "{findings:#?}"
    );
}

/// Rates, noise and mains are judged for the default plan: it is in force meanwhile, and the
/// board's own plan before and after.
#[test]
fn a_board_with_another_plan_is_checked_with_the_default_one_and_has_its_own_again() {
    let fast = Settings {
        harmonics: 2,
        ..Settings::DEFAULT.with_plan(Scan::HAND)
    };
    for (stored, in_force, stores) in [
        (None, Some(fast), false),
        (None, Some(fast), true),
        (Some(fast), None, false),
        (Some(fast), None, true),
    ] {
        let mut feed = Bench {
            stored,
            in_force,
            ..Bench::default()
        }
        .feed();
        let seen = gather(
            &mut feed,
            Plan {
                length_s: 3.0,
                stores,
            },
            &mut Progress::default(),
        );
        let report = Report::new(feed.name(), Inputs::Shorted, &seen);
        assert!(report.failed().is_empty(), "{report}");
        let plan = report
            .checks
            .iter()
            .find(|check| check.name == "plan")
            .expect("a finding");
        assert!(
            plan.finding.contains("plan `hand` is in force again"),
            "{}",
            plan.finding
        );
        let rate = report
            .checks
            .iter()
            .find(|check| check.name == "frame_rate")
            .expect("a finding");
        assert!(
            rate.verdict == Verdict::Pass && rate.finding.starts_with("241.1"),
            "{}",
            rate.finding
        );
        assert_eq!(
            Client::new(&mut feed).hello().unwrap().settings,
            fast,
            "{report}"
        );
    }
}

/// A board that has the default plan has nothing to put back.
#[test]
fn the_default_plan_is_not_reported() {
    let mut feed = Bench::default().feed();
    let seen = gather(&mut feed, STORES, &mut Progress::default());
    assert!(
        seen.lent.is_none()
            && Report::new(feed.name(), Inputs::Shorted, &seen)
                .failed()
                .is_empty()
    );
}

#[test]
fn a_plan_that_is_not_put_back_fails() {
    let mut seen = Bench {
        in_force: Some(Settings::DEFAULT.with_plan(Scan::HAND)),
        ..Bench::default()
    }
    .observations();
    seen.lent.as_mut().expect("another plan").failed = Some("no answer".into());
    let report = Report::new("board".into(), Inputs::Shorted, &seen);
    assert_eq!(report.failed(), ["plan"], "{report}");
}
