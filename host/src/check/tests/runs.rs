//! Whole runs against a simulated board: faults of its chip, bus, line and settings are reported,
//! and the board's own settings are restored in every case.

use super::bench::Bench;
use super::{Fail, Inputs, Observations, Plan, Skipped, Verdict, find, judge, wrong};
use crate::check::{Report, gather};
use crate::client::Client;
use crate::feed::Feed;
use crate::input::{Input, Opened};
use crate::output::Progress;
use hal_mock::{Fault, Injection, Scene};
use ridgetone_finger::tasks::Received;
use ridgetone_proto::boot::SettingsSource::{Damaged, Default as Usual, Stored, StoredBefore};
use ridgetone_proto::command::Command;
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, Hello, PROTOCOL, Packet};

/// Change to a healthy board; the checks that then warn or fail, in order; and part of the first
/// one's finding.
type Case = (fn(&mut Bench), &'static str, &'static str);

/// One line per case: the board and its change, the checks, the words.
macro_rules! cases {
    ($($expected:literal $words:literal => |$bench:ident| $change:expr;)*) => {
        vec![$((|$bench: &mut Bench| { $change; }, $expected, $words)),*]
    };
}

fn cases() -> Vec<Case> {
    cases! {
        "adc_id Fail" "ADS1158" => |bench| bench.input.options.id = 0x9b;
        // Temperature and noise are measured against the reference.
        "reference Fail, temperature Fail, noise Warn, faults Fail" "2.500 V" => |bench| bench.input.options.analog.reference_v = 2.5;
        "frame_rate Fail, faults Fail" "+8000 ppm" => |bench| bench.input.options.clock_error_ppm = 8000.0;
        "inputs Fail" "dead, always the same" => |bench| bench.input.options.noise = false;
        // A register changes by itself, so the board sets up the chip again.
        "adc_restarts Fail, losses Fail, faults Fail" "1 of them while it was watched" => |bench| happens(bench, Fault::RegisterFlip { address: 4, mask: 1 });
        "losses Fail, faults Fail" "3 conversions lost" => |bench| happens(bench, Fault::EdgesLost { count: 3 });
        "faults Fail" "bus 1" => |bench| happens(bench, Fault::DoutFlip { bytes_ahead: 2, mask: 1 });
        "faults Warn" "earlier: bus 1" => |bench| bench.on_start = |chip| chip.begin_fault(Fault::DoutFlip { bytes_ahead: 22, mask: 1 });
        "adc_id Fail, adc_registers Fail, adc_restarts Fail, frame_rate Fail, drdy_jitter Fail, inputs Fail, noise Fail, mains Fail, faults Fail" "DOUT is always high" =>
            |bench| bench.on_start = |chip| chip.begin_fault(Fault::BusCut { high: true });
        "adc_id Fail, adc_registers Fail, adc_restarts Fail, frame_rate Fail, drdy_jitter Fail, inputs Fail, noise Fail, mains Fail, faults Fail" "DOUT is always low" =>
            |bench| bench.on_start = |chip| chip.begin_fault(Fault::BusCut { high: false });
        // Flips a bit of every thousandth byte; the next case loses every thousandth byte.
        "commands Warn" "arrived damaged" => |bench| bench.received = |number, byte| Received::Byte(byte ^ (u8::from(number % 1000 == 500) << 2));
        "commands Fail" "bytes overrun" => |bench| bench.received = |number, byte| match number % 1000 {
            500 => Received::Lost(1),
            _ => Received::Byte(byte),
        };
        // Loses packet 1000 on the line, and damages packet 1001.
        "losses Fail" "2 packets lost, 1 packets damaged" => |bench| bench.on_line = Box::new(|number, bytes| match number {
            1000 => bytes.clear(),
            1001 => bytes[3] ^= 8,
            _ => {}
        });
        // The board sends the greeting of a start instead of the fifth `health`.
        "losses Fail" "1 restarts of the board" => |bench| {
            let (mut greeting, mut healths) = (None, 0);
            bench.altered = Box::new(move |packet| match &packet.event {
                Event::Hello(hello) => greeting = Some(hello.clone()),
                Event::Health(_) => {
                    healths += 1;
                    if let Some(hello) = greeting.clone().filter(|_| healths == 5) {
                        (packet.sequence, packet.event) = (0, Event::Hello(hello));
                    }
                }
                _ => {}
            });
        };
        "settings Fail" "stored settings are not in force" => |bench| stores(bench, |hello| {
            (hello.settings, hello.source) = (Settings::DEFAULT, Usual);
        });
        // The board does not forget: it still reports stored settings after they were erased.
        "settings Fail" "what was stored before is not restored" => |bench| {
            let mut was_stored = false;
            stores(bench, move |hello| {
                was_stored |= hello.source == Stored;
                if was_stored && hello.source == Usual {
                    (hello.settings.stride_s, hello.source) = (0.3, Stored);
                }
            });
        };
        "settings Warn" "damaged" => |bench| stores(bench, |hello| {
            hello.source = if hello.source == Usual { Damaged } else { hello.source };
        });
        "settings Warn" "stored_before" => |bench| stores(bench, |hello| {
            hello.source = if hello.source == Usual { StoredBefore } else { hello.source };
        });
        // The first greeting after each restart is lost: the next one counts.
        "" "" => |bench| {
            stores(bench, |_| ());
            let mut decoder = Decoder::new();
            bench.on_line = Box::new(move |_, bytes| {
                let packet = bytes.iter().find_map(|byte| decoder.push(*byte));
                if packet.is_some_and(|packet| packet.sequence == 0) {
                    bytes.clear();
                }
            });
        };
    }
}

/// Injects a single fault into the chip, two seconds into the watch.
fn happens(bench: &mut Bench, fault: Fault) {
    let injection = Injection {
        at_s: 4.0,
        lasts_s: 0.0,
        fault,
    };
    bench.input.options.injections.push(injection);
}

/// Makes the check store settings, on a board whose greetings are altered.
fn stores(bench: &mut Bench, mut alter: impl FnMut(&mut Hello) + Send + 'static) {
    (bench.plan.stores, bench.plan.length_s) = (true, 3.0);
    bench.altered = Box::new(move |packet: &mut Packet| {
        if let Event::Hello(hello) = &mut packet.event {
            alter(hello);
        }
    });
}

fn checked(feed: &mut Feed, plan: Plan) -> (Report, Observations) {
    let seen = gather(feed, plan, &mut Progress::default());
    (Report::new(feed.name(), &seen), seen)
}

#[test]
fn faults_of_the_board_are_found_and_no_others() {
    for (change, expected, words) in cases() {
        let checks = judge(&Bench::with(change).observations());
        let wrong = wrong(&checks);
        let list = wrong
            .iter()
            .map(|(name, verdict)| format!("{name} {verdict:?}"));
        assert_eq!(
            list.collect::<Vec<_>>().join(", "),
            expected,
            "{words}: {checks:#?}"
        );
        let finding = wrong
            .first()
            .map_or("", |(name, _)| &find(&checks, name).finding);
        assert!(finding.contains(words), "{words}: {finding}");
    }
}

/// Rates, noise and mains are judged with the default plan in force. A flash that refuses to be
/// written has not changed, so it need not be restored.
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
    let fast = Settings {
        harmonics: 2,
        ..Settings::DEFAULT.with_plan(Scan::HAND)
    };
    for (before, in_force, stores, is_worn) in [
        (None, None, true, false),
        (None, Some(sent), true, false),
        (Some(stored), None, true, false),
        (Some(stored), Some(sent), true, false),
        (Some(stored), None, true, true),
        (None, Some(fast), true, false),
        (None, Some(fast), false, false),
        (Some(fast), None, true, false),
        (Some(fast), None, false, false),
    ] {
        let mut feed = Bench::with(|bench| {
            (bench.stored, bench.in_force, bench.is_worn) = (before, in_force, is_worn);
        })
        .feed();
        let plan = Plan {
            length_s: 3.0,
            stores,
            inputs: Inputs::Shorted,
        };
        let (report, seen) = checked(&mut feed, plan);
        let check = find(&report.checks, "settings");
        assert!(
            !is_worn || check.finding.starts_with("not stored: "),
            "{report}"
        );
        let verdict = if is_worn { Fail } else { Verdict::Pass };
        assert_eq!(
            check.verdict,
            if stores { verdict } else { Skipped },
            "{report}"
        );
        assert_eq!(report.failed().len(), usize::from(is_worn), "{report}");
        let own = in_force.or(before).unwrap_or_default();
        assert_eq!(seen.lent.is_some(), own == fast, "{report}");
        if own == fast {
            let finding = &find(&report.checks, "plan").finding;
            assert!(
                finding.contains("plan `hand` is in force again"),
                "{finding}"
            );
            let rate = find(&report.checks, "frame_rate");
            assert!(rate.verdict == Verdict::Pass && rate.finding.starts_with("241.1"));
        }
        let mut client = Client::new(&mut feed);
        assert_eq!(client.hello().unwrap().settings, own);
        // The stored settings are in force after a restart.
        client.request(Command::Restart).unwrap();
        let hello = client.hello().unwrap();
        assert_eq!(hello.settings, before.unwrap_or_default());
        assert_eq!(hello.source == Stored, before.is_some());
    }
}

#[test]
fn another_protocol_fails_and_leaves_the_rest_unjudged() {
    let checks =
        judge(&Bench::with(|bench| stores(bench, |hello| hello.protocol += 1)).observations());
    assert_eq!(wrong(&checks), [("firmware", Fail)]);
    let words = format!("speaks protocol {}", PROTOCOL + 1);
    assert!(checks[0].finding.contains(&words), "{checks:#?}");
    assert!(
        checks[1..].iter().all(|check| check.verdict == Skipped),
        "{checks:#?}"
    );
}

/// RX is not connected: the board sends telemetry, but does not answer.
#[test]
fn a_board_that_hears_nothing_fails_the_commands_and_is_judged_by_what_it_sends() {
    let bench = Bench::with(|bench| bench.received = |_, _| Received::Byte(0));
    let plan = bench.plan;
    let (report, seen) = checked(&mut bench.feed(), plan);
    assert_eq!(report.failed(), ["commands"], "{report}");
    let verdicts = ["firmware", "supply", "losses"].map(|name| find(&report.checks, name).verdict);
    assert_eq!(verdicts, [Verdict::Pass, Verdict::Pass, Skipped]);
    assert!(seen.ended.is_some_and(|why| why.contains("RX")), "{report}");
}

/// A scene of one touch, with 0 V before and after it.
struct Touch(Box<dyn Scene>, f64);

impl Scene for Touch {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        // Outside the touch, return 0 V: the finger's own noise would be judged too.
        if (0.5..self.1).contains(&t_s) {
            self.0.volts(input, t_s)
        } else {
            0.0
        }
    }

    fn end_s(&self) -> f64 {
        f64::INFINITY
    }
}

/// During a slide, everything except mains and noise can be judged; between touches these can be
/// judged too.
#[test]
fn touches_are_not_mistaken_for_pick_up() {
    let once = || Input::default().open().expect("a scene");
    let mut input = once();
    let touch = std::mem::replace(&mut input.scene, Opened::untouched().scene);
    input.scene = Box::new(Touch(touch, input.end_s));
    input.end_s = f64::INFINITY;
    for (input, length_s, mains) in [
        (once().repeated(), 5.0, Skipped),
        (input, 10.0, Verdict::Pass),
    ] {
        let plan = Plan {
            length_s,
            stores: false,
            inputs: Inputs::InUse,
        };
        let bench = Bench::with(|bench| (bench.input, bench.plan) = (input, plan));
        let checks = judge(&bench.observations());
        assert_eq!(
            (wrong(&checks), find(&checks, "mains").verdict),
            (vec![], mains)
        );
    }
}
