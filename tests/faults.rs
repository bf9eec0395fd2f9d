//! Tests that faults in a touch are reported, and that no estimate that they affected is good.

#[path = "support/touch.rs"]
mod touch;

use ads1258::Status as StatusByte;
use ridgetone_finger::{
    CONVERSION_NS, Detector, Diagnostics, Outputs, Pipeline, Ring, TimedConversion,
};
use ridgetone_proto::fault::{Fault, FaultKind};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Event, Span, Status, Travel, TravelStatus};
use touch::{SCANS, TONE_HZ};

/// Conversions per scan.
const SLOTS: u64 = 21;
/// Scan in the middle of the slide, 1.8 s after the start.
const MIDDLE: u64 = 434;

/// Returns the events of a touch with windows of half a second; `change` may drop or modify
/// conversions by their number.
fn events(mut change: impl FnMut(u64, TimedConversion) -> Option<TimedConversion>) -> Vec<Event> {
    let settings = Settings {
        window_s: 0.5,
        stride_s: 0.1,
        ..Settings::DEFAULT
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    let mut events = Vec::new();
    let all = (0..SCANS).flat_map(|n| touch::scan(n, n, 0)).zip(0..);
    for conversion in all.filter_map(|(conversion, number)| change(number, conversion)) {
        pipeline.push(conversion, &mut |event| events.push(event));
    }
    pipeline.finish(&mut |event| events.push(event));
    events
}

fn faults(events: &[Event]) -> Vec<Fault> {
    let faults = events.iter().filter_map(|event| match event {
        Event::Fault(fault) => Some(*fault),
        _ => None,
    });
    faults.collect()
}

/// Returns the estimates of windows that end within the slide.
fn estimates(events: &[Event]) -> Vec<&Estimate> {
    let fits = events.iter().filter_map(|event| match event {
        Event::Estimate(fit) if fit.span == Span::Window && fit.t_us < 2_750_000 => Some(fit),
        _ => None,
    });
    fits.collect()
}

/// True if the window includes this device time. `None` if the time is after the window or up to 13
/// ms before it: the estimate may then be doubtful, if the fault came before the report.
fn holds(fit: &Estimate, t_us: u64) -> Option<bool> {
    let from_us = fit.t_us - (fit.window_s * 1e6) as u64;
    let is_near = (from_us - 13_000..from_us).contains(&t_us) || t_us > fit.t_us;
    (!is_near).then_some(t_us >= from_us)
}

/// Asserts that the good estimates are within 0.1 % of the truth.
fn assert_good_ones_are_right(events: &[Event]) {
    for fit in estimates(events)
        .iter()
        .filter(|fit| fit.status == Status::Good)
    {
        assert!(
            (f64::from(fit.frequency) / TONE_HZ - 1.0).abs() < 1e-3,
            "{fit:?}"
        );
    }
}

fn number_us(number: u64) -> u64 {
    number * CONVERSION_NS / 1000
}

fn is_in(scans: &std::ops::Range<u64>, number: u64) -> bool {
    scans.contains(&(number / SLOTS))
}

fn has(events: &[Event], kind: FaultKind) -> bool {
    faults(events).iter().any(|fault| fault.kind == kind)
}

fn count_of(events: &[Event], status: Status) -> usize {
    estimates(events)
        .iter()
        .filter(|fit| fit.status == status)
        .count()
}

#[test]
fn nothing_is_reported_of_a_flawless_touch() {
    let events = events(|_, conversion| Some(conversion));
    assert_eq!(faults(&events), []);
    let fits = estimates(&events);
    assert!(fits.len() > 10 && fits.iter().all(|fit| fit.faults.is_none()));
    assert_good_ones_are_right(&events);
}

#[test]
fn losses_are_reported_with_their_times_and_leave_estimates_good() {
    let lost = MIDDLE * SLOTS + 5;
    let events =
        events(|number, conversion| (!(lost..lost + 3).contains(&number)).then_some(conversion));
    let [begin, end] = faults(&events)[..] else {
        panic!("{:?}", faults(&events))
    };
    // Detected in the incomplete scan, and reported with the next frames.
    assert!((begin.kind, begin.count, begin.until_us) == (FaultKind::Lost, 3, None));
    assert!(begin.from_us.abs_diff(number_us(lost)) < 5_000, "{begin:?}");
    let until_us = Some(begin.from_us);
    assert_eq!(end, Fault { until_us, ..begin });
    let fits = estimates(&events);
    let touched = fits
        .iter()
        .filter(|fit| fit.faults.has(FaultKind::Lost))
        .count();
    assert!((5..11).contains(&touched), "{touched}");
    for fit in fits {
        assert_eq!(fit.status, Status::Good);
        let is_lost = fit.faults.has(FaultKind::Lost);
        assert_eq!(
            is_lost,
            holds(fit, begin.from_us).unwrap_or(is_lost),
            "{fit:?}"
        );
    }
    assert_good_ones_are_right(&events);
}

/// The converter pauses: every id arrives, but the tone's phase jumps.
#[test]
fn a_chip_that_stands_still_for_a_moment_makes_its_windows_doubtful() {
    let from = MIDDLE * SLOTS + 5;
    for still_us in [100, 400, 1500, 3000] {
        let events = events(|number, mut conversion| {
            conversion.t_us += if number >= from { still_us } else { 0 };
            Some(conversion)
        });
        assert!(has(&events, FaultKind::Clock) || has(&events, FaultKind::Channel));
        let moment_us = number_us(from);
        for fit in estimates(&events) {
            // A tone with a phase jump may be ambiguous instead of doubtful.
            let is_right = match holds(fit, moment_us) {
                Some(true) => matches!(fit.status, Status::Doubtful | Status::Ambiguous),
                Some(false) => fit.status != Status::Doubtful,
                None => true,
            };
            assert!(is_right, "{still_us} us: {fit:?}");
        }
        assert_good_ones_are_right(&events);
    }
}

/// The board was busy, so an edge's time stamp is late, by up to a conversion.
#[test]
fn an_edge_whose_time_is_noted_late_is_no_fault() {
    for slot in [0, 5, 20] {
        let late = MIDDLE * SLOTS + slot;
        let events = events(|number, mut conversion| {
            conversion.t_us += if number == late { 150 } else { 0 };
            Some(conversion)
        });
        assert_eq!(faults(&events), [], "slot {slot}");
    }
}

/// After the reset the registers are at their defaults: sixteen channels at 23.7 thousand
/// conversions a second.
#[test]
fn a_chip_that_reset_itself_is_never_believed() {
    let from = MIDDLE * SLOTS;
    let events = events(|number, mut conversion| {
        let (since, behind) = (number.saturating_sub(from), number >= from);
        if behind {
            conversion.t_us = (number_us(from) + since * 42) as u32;
            conversion = conversion.with_status(StatusByte(0x88 + (since % 16) as u8));
        }
        Some(conversion)
    });
    assert!(has(&events, FaultKind::Channel));
    let fits = estimates(&events);
    assert!(fits.iter().any(|fit| fit.status != Status::Good));
    for fit in fits {
        assert!(
            fit.status != Status::Good || fit.t_us < number_us(from),
            "{fit:?}"
        );
    }
    assert_good_ones_are_right(&events);
}

#[test]
fn supply_and_reference_out_of_range_are_reported() {
    // Supply: 4.70 V is below the limit of 4.75 V, 4.80 V is above. Reference: 3 % and 1 % below
    // 4.096 V. Both have 786432 codes per volt.
    for (id, code, kind) in [
        (0x1a, 3_696_230, Some(FaultKind::Supply)),
        (0x1a, 3_774_874, None),
        (0x1d, 3_124_588, Some(FaultKind::Reference)),
        (0x1d, 3_189_013, None),
    ] {
        let scans = MIDDLE..MIDDLE + 20;
        let events = events(|number, mut conversion| {
            if is_in(&scans, number) && conversion.status().chid() == id {
                conversion = conversion.with_code(code);
            }
            Some(conversion)
        });
        let reported = faults(&events);
        assert_eq!(
            reported.first().map(|fault| fault.kind),
            kind,
            "{id:#x} {code}"
        );
        assert_eq!(count_of(&events, Status::Doubtful) > 0, kind.is_some());
        if let [begin, end] = reported[..] {
            for (found_us, scan) in [
                (begin.from_us, MIDDLE),
                (end.until_us.unwrap(), MIDDLE + 19),
            ] {
                let off_us = found_us.abs_diff(number_us(scan * SLOTS + 20));
                assert!(off_us < 20_000, "{begin:?} {end:?}");
            }
        }
    }
}

#[test]
fn a_clock_off_by_a_percent_is_reported_and_one_off_by_a_quarter_is_not() {
    for (percent, status) in [
        (1.0, Status::Doubtful),
        (-1.0, Status::Doubtful),
        (3.0, Status::Doubtful),
        (0.25, Status::Good),
        (-0.25, Status::Good),
    ] {
        let events = events(|_, mut conversion| {
            conversion.t_us = (f64::from(conversion.t_us) * (1.0 + percent / 100.0)) as u32;
            Some(conversion)
        });
        let is_off = has(&events, FaultKind::Clock);
        assert_eq!(
            is_off,
            status == Status::Doubtful,
            "{percent} %: {:?}",
            faults(&events)
        );
        for fit in estimates(&events) {
            assert_eq!(fit.status, status, "{percent} %: {fit:?}");
        }
    }
}

#[test]
fn clipped_codes_are_reported_and_leave_the_other_channels_good() {
    let scans = MIDDLE..MIDDLE + 3;
    let events = events(|number, conversion| {
        let is_clipped = is_in(&scans, number) && number % SLOTS == 3;
        Some(if is_clipped {
            conversion.with_code(0x7f_ffff)
        } else {
            conversion
        })
    });
    let reported: Vec<_> = faults(&events)
        .into_iter()
        .map(|fault| (fault.kind, fault.count))
        .collect();
    assert_eq!(
        reported,
        [(FaultKind::Overload, 1), (FaultKind::Overload, 3)]
    );
    // The return of the signal looks like motion until a hold is detected, 22 blocks of four frames
    // later. An estimate whose window ends before that may include a standstill.
    let clipped_us = number_us(MIDDLE * SLOTS + 3);
    let back_us = number_us((MIDDLE + 2) * SLOTS + 3);
    assert!(count_of(&events, Status::Good) > 0 && count_of(&events, Status::Doubtful) > 0);
    for fit in estimates(&events) {
        // An estimate whose window ended just before the fault may be reported after it.
        if !(clipped_us - 13_000..clipped_us).contains(&fit.t_us) {
            let is_unsure = (clipped_us..back_us + 365_000).contains(&fit.t_us);
            let expected = if is_unsure {
                Status::Doubtful
            } else {
                Status::Good
            };
            assert_eq!(
                fit.status, expected,
                "{} us, back at {back_us} us",
                fit.t_us
            );
        }
    }
}

/// An input that is always at a rail (a broken bridge) is reported, listed in the faults of every
/// estimate, and left out; the estimates stay good. A second input that alternates between rail and
/// signal makes estimates doubtful.
#[test]
fn an_input_that_is_always_at_a_rail_leaves_estimates_good() {
    let comes_and_goes = MIDDLE..MIDDLE + 3;
    for also in [false, true] {
        let events = events(|number, conversion| {
            let is_clipped = match number % SLOTS {
                3 => true,
                7 => also && is_in(&comes_and_goes, number),
                _ => false,
            };
            Some(if is_clipped {
                conversion.with_code(0x7f_ffff)
            } else {
                conversion
            })
        });
        let fits = estimates(&events);
        assert!(fits.len() > 4 && fits.iter().all(|fit| fit.faults.has(FaultKind::Overload)));
        let doubtful = count_of(&events, Status::Doubtful);
        assert_eq!(
            count_of(&events, Status::Good) + doubtful,
            fits.len(),
            "{fits:?}"
        );
        assert_eq!(doubtful > 0, also, "{doubtful} of {}", fits.len());
    }
}

/// Causes all faults at once, repeatedly. At most four messages may be sent in an eighth of a
/// second, and every beginning must be reported.
#[test]
fn all_faults_together_make_few_messages() {
    let (diagnostics, mut ring) = (Diagnostics::new(), Box::new(Ring::new()));
    let mut detector = Box::new(Detector::new(Settings::DEFAULT));
    let mut reported = Vec::new();
    for (conversion, number) in (0..SCANS).flat_map(|n| touch::scan(n, n, 0)).zip(0u64..) {
        // Faults begin and end again all the time.
        if number % (SLOTS * 300) < SLOTS * 5 {
            FaultKind::ALL
                .into_iter()
                .for_each(|kind| diagnostics.fault(kind, conversion.t_us));
        }
        let mut emit = |event| {
            if let Event::Fault(fault) = event {
                reported.push((conversion.t_us, fault));
            }
        };
        let outputs = &mut Outputs {
            emit: &mut emit,
            due: &mut |_| {},
        };
        detector.push(conversion, &mut ring, &diagnostics, outputs);
    }
    // Four at the end of one eighth of a second, and four at the beginning of the next.
    let in_an_eighth = |from_us: u32| {
        reported
            .iter()
            .filter(|(t_us, _)| (from_us..from_us + 125_000).contains(t_us))
            .count()
    };
    assert!(
        reported.iter().all(|(t_us, _)| in_an_eighth(*t_us) <= 8),
        "{reported:?}"
    );
    for kind in FaultKind::ALL {
        let of_it = || reported.iter().filter(|(_, fault)| fault.kind == kind);
        let begins = of_it()
            .filter(|(_, fault)| fault.until_us.is_none())
            .count();
        let ends = of_it().count() - begins;
        // Up to three episodes, one every 300 scans. A touch sometimes delays events, which merges
        // two of them.
        assert!(
            (1..=3).contains(&begins) && (ends == begins || ends + 1 == begins),
            "{kind:?}: {begins} {ends}"
        );
    }
}

/// The chip is silent: each half second the board reports health and faults, by its own clock.
#[test]
fn health_and_faults_are_reported_while_no_conversion_comes() {
    let (diagnostics, mut ring) = (Diagnostics::new(), Box::new(Ring::new()));
    let mut detector = Box::new(Detector::new(Settings::DEFAULT));
    for conversion in (0..100).flat_map(|n| touch::scan(n, n, 7)) {
        let outputs = &mut Outputs {
            emit: &mut |_| {},
            due: &mut |_| {},
        };
        detector.push(conversion, &mut ring, &diagnostics, outputs);
    }
    let (mut healths, mut greetings, mut reported) = (Vec::new(), 0, Vec::new());
    for half in 1..=60u32 {
        let now_us = 500_000 * half;
        if half < 40 {
            diagnostics.fault(FaultKind::Silent, now_us);
        }
        detector.look(now_us, &diagnostics, &mut |event| match event {
            Event::Health(health) => healths.push(health),
            Event::Hello(_) => greetings += 1,
            Event::Fault(fault) => reported.push(fault),
            _ => {}
        });
    }
    assert!(
        (29..=30).contains(&healths.len()) && greetings == 2,
        "{} {greetings}",
        healths.len()
    );
    // Device time is zero at the first conversion, 7 us on the board's clock.
    assert!(
        healths
            .windows(2)
            .all(|two| two[1].t_us - two[0].t_us == 1_000_000)
    );
    let silent = healths
        .last()
        .map(|health| health.faults[FaultKind::Silent as usize]);
    assert_eq!(silent, Some(39));
    let [begin, end] = reported[..] else {
        panic!("{reported:?}")
    };
    let episode = (begin.from_us, end.until_us, end.count);
    assert_eq!(episode, (499_993, Some(19_499_993), 39));
    // The count of lost conversions saturates, and must never decrease.
    let mut latest = 0;
    for half in 61..=72 {
        diagnostics.unseen.add(u32::MAX / 4);
        detector.look(500_000 * half, &diagnostics, &mut |event| {
            if let Event::Health(health) = event {
                let lost = health.conversions_lost;
                assert!(lost >= latest, "{latest} and then {lost}");
                latest = lost;
            }
        });
    }
    assert_eq!(latest, u32::MAX);
}

#[test]
fn a_fault_that_changes_a_frequency_makes_a_good_or_unsteady_estimate_doubtful_and_says_nothing_of_travel()
 {
    let good = events(|_, conversion| Some(conversion));
    let fit = (*estimates(&good).last().unwrap()).clone();
    let window = ridgetone_finger::Window {
        end_us: fit.t_us,
        frame_rate_hz: 241.14,
        span: fit.span,
        ..ridgetone_finger::Window::new(Settings::DEFAULT.plan, (fit.window_s * 241.0) as u32)
    };
    let travel = Travel {
        status: TravelStatus::Given,
        ..Travel::NONE
    };
    for kind in FaultKind::ALL {
        for (ago_us, counts) in [(100_000, true), (fit.t_us as u32 - 100, false)] {
            for status in [Status::Good, Status::Unsteady] {
                let diagnostics = Diagnostics::new();
                let mut fit = Estimate {
                    status,
                    travel,
                    ..fit.clone()
                };
                diagnostics.fault(kind, fit.t_us as u32 - ago_us);
                diagnostics.qualify(&mut fit, &window);
                assert_eq!(fit.faults.has(kind), counts, "{kind:?}");
                // A clipped input that recovers late can hide the end of the slide.
                let changes = kind.changes_frequency() || kind == FaultKind::Overload;
                let found = (fit.status == Status::Doubtful, !fit.travel.is_known());
                assert_eq!(found, (counts && changes, counts && changes), "{kind:?}");
            }
        }
    }
    // An overload longer ago than it takes to detect a hold only removes its channel. A more recent
    // one makes the estimate doubtful, even if it came before the window.
    for (ago_us, window_s, status) in [
        (500_000, 1.0, Status::Good),
        (300_000, 1.0, Status::Doubtful),
        (300_000, 0.2, Status::Doubtful),
    ] {
        let (diagnostics, mut fit) = (Diagnostics::new(), fit.clone());
        fit.window_s = window_s;
        diagnostics.fault(FaultKind::Overload, fit.t_us as u32 - ago_us);
        diagnostics.qualify(&mut fit, &window);
        assert!(fit.faults.has(FaultKind::Overload));
        assert_eq!(fit.status, status, "{ago_us} us, {window_s} s");
    }
}
