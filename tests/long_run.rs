//! Tests thirty virtual days: exact times and counts, estimates as accurate at the end as at the
//! start, and constant memory.
//!
//! The normal test plays only a touch around each of the 604 wraps of the board's microseconds, and
//! one scan every twenty minutes in between. The ignored test plays all 13 thousand million
//! conversions: `cargo test --test long_run -- --ignored --nocapture`.

#[path = "support/memory.rs"]
mod memory;
#[path = "support/touch.rs"]
mod touch;

use ads1258::Status as StatusByte;
use memory::resident_bytes;
use ridgetone_finger::internals::Assembler;
use ridgetone_finger::tasks::{Outbox, Posted};
use ridgetone_finger::{CONVERSION_NS, Pipeline, SLOTS, TimedConversion};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{
    Decoder, Estimate, Event, Health, Release, Span, Status, WIRE_MAX, encode,
};
use touch::{SCANS, TONE_HZ, scan};

const SCAN_NS: u64 = SLOTS as u64 * CONVERSION_NS;
const DAY_S: u64 = 86_400;
/// Period of the wrapping 32-bit microsecond counter, 71.6 minutes.
const WRAP_US: u64 = 1 << 32;

/// Device time of a scan's first slot in whole microseconds, as counted by the board.
fn scan_us(number: u64) -> u64 {
    number * SCAN_NS / 1000
}

/// Number of the latest scan that has begun by `t_us`.
fn scan_at(t_us: u64) -> u64 {
    t_us * 1000 / SCAN_NS
}

fn times_us(event: &Event) -> Vec<u64> {
    match event {
        Event::Contact(contact) => vec![contact.t_us],
        Event::Slide(slide) => [Some(slide.start_us), slide.end_us]
            .into_iter()
            .flatten()
            .collect(),
        Event::Estimate(fit) => vec![fit.t_us],
        Event::Release(release) => vec![release.t_us],
        Event::Image(image) => vec![image.start_us, image.end_us],
        _ => Vec::new(),
    }
}

/// Scans of a touch whose last hold is a second longer, followed by 0.9 s without contact, so that
/// its end is reported before the next touch.
fn touched() -> impl Iterator<Item = u64> + Clone {
    let hold = (0..4).flat_map(|_| HOLD);
    let rest = (0..3).flat_map(|_| 0..70);
    (0..HOLD.end).chain(hold).chain(HOLD.end..SCANS).chain(rest)
}

/// Scans of the hold after the slide, from 2.82 to 3.07 s.
const HOLD: std::ops::Range<u64> = 680..740;
const LENGTH: u64 = SCANS + 4 * (HOLD.end - HOLD.start) + 3 * 70;

/// Asserts that an estimate is right and agrees with `plain`.
fn assert_same(fit: &Estimate, plain: &Estimate) {
    assert_eq!(
        (fit.status, fit.span, fit.harmonics),
        (Status::Good, plain.span, plain.harmonics),
        "{fit:?}"
    );
    assert!(
        (f64::from(fit.frequency) - TONE_HZ).abs() < 5.0 * f64::from(fit.sigma),
        "{fit:?}"
    );
    // Blocks start elsewhere in the ring and are summed in a different order, which changes the f32
    // rounding.
    let min = (0.1 * plain.sigma).max(2e-6 * plain.frequency);
    assert!(
        (fit.frequency - plain.frequency).abs() < min,
        "{fit:?}, and at first {plain:?}"
    );
}

/// Asserts that the frame rate agrees with the scans to one part in a million.
#[track_caller]
fn assert_rate(health: &Health) {
    let off = f64::from(health.frame_rate_hz) * SCAN_NS as f64 / 1e9 - 1.0;
    assert!(off.abs() < 1e-6, "{health:?}");
}

#[test]
fn a_touch_around_every_wrap_of_thirty_days_is_like_the_first() {
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    let mut play = |part: &mut dyn Iterator<Item = TimedConversion>| {
        let mut events = Vec::new();
        for conversion in part {
            pipeline.push(conversion, &mut |event| events.push(event));
        }
        events
    };
    // The skipped scans must be the only faults reported.
    let is_no_fault = |event: &Event| match event {
        Event::Fault(fault) => {
            let is_expected = [FaultKind::Lost, FaultKind::Silent].contains(&fault.kind);
            assert!(is_expected, "{fault:?}");
            false
        }
        Event::Health(_) | Event::Hello(_) => false,
        _ => true,
    };
    let mut plain: Vec<Event> = play(
        &mut touched()
            .zip(0..)
            .flat_map(|(n, number)| scan(n, number, 0)),
    );
    plain.retain(is_no_fault);
    let windows = plain
        .iter()
        .filter(|event| matches!(event, Event::Estimate(_)))
        .count();
    assert!(windows > 5, "{windows}");

    let (mut next, mut given, mut healths) = (LENGTH, LENGTH, 0);
    for wrap in 1..=30 * DAY_S * 1_000_000 / WRAP_US {
        // The wrap falls at a different point of the touch each time.
        let begin = scan_at(wrap * WRAP_US) - wrap * 137 % LENGTH;
        let rest = (next..begin)
            .step_by(scan_at(20 * 60_000_000) as usize)
            .skip(1);
        let touch = touched()
            .zip(begin..)
            .flat_map(|(n, number)| scan(n, number, 0));
        given += LENGTH + rest.clone().count() as u64;
        next = begin + LENGTH;
        let mut events = play(&mut rest.flat_map(|number| scan(0, number, 0)).chain(touch));
        for event in &events {
            let Event::Health(health) = event else {
                continue;
            };
            healths += 1;
            let done = scan_at(health.t_us);
            // The report is sent with the scan's last conversion.
            let exact_us = (done * SCAN_NS + (SCAN_NS - CONVERSION_NS)) / 1000;
            assert_eq!(health.t_us, exact_us, "{health:?}");
            // Exact until the counter saturates at 32 bits.
            let lost = (next - given) * u64::from(SLOTS);
            let lost_before = u64::from(health.conversions_lost);
            assert!(
                lost_before <= lost && (done < begin || lost_before == lost.min(u32::MAX.into())),
                "{health:?}"
            );
            assert_eq!((health.conversions_doubtful, health.overruns), (0, 0));
            assert_rate(health);
        }
        events.retain(is_no_fault);
        assert_eq!(
            events.len(),
            plain.len(),
            "wrap {wrap}: {:?}",
            events.iter().map(times_us).collect::<Vec<_>>()
        );
        for (event, plain) in events.iter().zip(&plain) {
            assert_eq!(
                std::mem::discriminant(event),
                std::mem::discriminant(plain),
                "wrap {wrap}"
            );
            for (t_us, plain_us) in times_us(event).into_iter().zip(times_us(plain)) {
                // Times must be the exact times of scans. Which scan it is may depend on where
                // blocks of four began.
                let number = (t_us * 1000).div_ceil(SCAN_NS);
                assert_eq!(t_us, scan_us(number), "wrap {wrap}: {event:?}");
                let expected = begin + (plain_us * 1000).div_ceil(SCAN_NS);
                // A pressure map consists of whole blocks, and the noise estimate decides which
                // block is first.
                let max = if matches!(event, Event::Image(_)) {
                    8
                } else {
                    4
                };
                assert!(
                    number.abs_diff(expected) < max,
                    "wrap {wrap}: {event:?}, and at first {plain:?}"
                );
            }
            if let (Event::Estimate(fit), Event::Estimate(plain)) = (event, plain) {
                assert_same(fit, plain);
            }
        }
    }
    assert!(healths > 1000, "{healths}");
}

struct Played {
    touches: u64,
    first: Vec<Estimate>,
    last: Vec<Estimate>,
    health: Health,
    /// Resident memory before the second touch and at the end, bytes.
    resident: Option<(u64, u64)>,
}

/// Plays all conversions of one touch after another for `length_s`.
fn play(length_s: u64) -> Played {
    let touch: Vec<TimedConversion> = touched().flat_map(|n| scan(n, n, 0)).collect();
    let touches = scan_at(length_s * 1_000_000) / LENGTH;
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    let (mut t_ns, mut first, mut last) = (0u64, Vec::new(), Vec::<Estimate>::new());
    let (mut health, mut resident) = (None, None);
    // Contact, start and end of the slide, and release, in scans from the start of the touch.
    let mut expected: Option<[u64; 4]> = None;
    let mut heard = Vec::with_capacity(8);
    for number in 0..touches {
        if number == 1 {
            resident = resident_bytes();
        }
        let begin = number * LENGTH;
        heard.clear();
        last.clear();
        let mut emit = |event| match event {
            Event::Contact(contact) => heard.push(contact.t_us),
            Event::Slide(slide) => heard.push(slide.end_us.unwrap_or(slide.start_us)),
            Event::Release(release) => heard.push(release.t_us),
            Event::Health(report) => {
                // All scans were played, and 30 days have fewer than 2^32 scans.
                let exact_us = (u64::from(report.frames) * SCAN_NS - CONVERSION_NS) / 1000;
                assert_eq!(report.t_us, exact_us, "{report:?}");
                assert_eq!(
                    (report.conversions_lost, report.conversions_doubtful),
                    (0, 0),
                    "{report:?}"
                );
                health = Some(report);
            }
            Event::Estimate(fit) => {
                assert_same(&fit, first.get(last.len()).unwrap_or(&fit));
                last.push(fit);
            }
            _ => {}
        };
        for conversion in &touch {
            let timed = TimedConversion::new((t_ns / 1000) as u32, conversion.conversion());
            t_ns += CONVERSION_NS;
            pipeline.push(timed, &mut emit);
        }
        if number == 0 {
            first.clone_from(&last);
        }
        assert_eq!(last.len(), first.len(), "touch {number}");
        let Ok(heard) = <[u64; 4]>::try_from(heard.as_slice()) else {
            panic!(
                "touch {number}, from {} us on: {heard:?} is not contact, start, end, release",
                scan_us(begin)
            );
        };
        let scans = heard.map(|t_us| {
            let number = (t_us * 1000).div_ceil(SCAN_NS);
            assert_eq!(t_us, scan_us(number), "touch {number}");
            number - begin
        });
        assert_eq!(scans, *expected.get_or_insert(scans), "touch {number}");
    }
    Played {
        touches,
        first,
        last,
        health: health.expect("health"),
        resident: resident.zip(resident_bytes()),
    }
}

fn assert_steady(played: &Played) {
    let Played {
        touches,
        first,
        last,
        health,
        resident,
    } = played;
    println!("{touches} touches; last health {health:?}; resident bytes {resident:?}");
    assert!(
        first.len() > 5
            && first.len() == last.len()
            && last.iter().any(|fit| fit.span == Span::Slide)
    );
    let (begun, ended) = (u64::from(health.frames), touches * LENGTH);
    assert!(
        (0..=2 * FRAME_RATE_HZ as u64).contains(&(ended - begun)),
        "the last health is a second old at most"
    );
    assert_rate(health);
}

#[test]
fn touch_after_touch_for_three_hours_is_the_same() {
    assert_steady(&play(3 * 3600));
}

#[test]
#[ignore = "every conversion of 30 days: six minutes and more, on Linux"]
fn touch_after_touch_for_thirty_days_is_the_same() {
    let played = play(30 * DAY_S);
    assert_steady(&played);
    // `--ignored` selects this test alone, so no other test uses memory meanwhile.
    let (from, to) = played.resident.expect("Linux reports memory");
    assert!(
        to.saturating_sub(from) < 1 << 20,
        "memory grows from {from} to {to} bytes"
    );
}

/// Sends one message per second for 30 days, with bursts that exceed the line's capacity and with
/// lost frames. The PC's count of missing messages must be exact across all 39 wraps of the
/// numbers.
#[test]
fn every_message_is_sent_dropped_or_lost_and_counted() {
    let (mut outbox, mut decoder) = (Outbox::default(), Decoder::new());
    let (mut posted, mut dropped, mut lost, mut received) = (0u64, 0u64, 0u64, 0u64);
    let mut wire = [0; WIRE_MAX];
    while posted < 30 * DAY_S {
        // Mostly one message, sometimes too many.
        let burst = if posted % 1013 < 5 { 20 } else { 1 };
        for _ in 0..burst {
            dropped += u64::from(
                outbox.post(Event::Release(Release {
                    t_us: posted,
                    reported_after_us: 0,
                })) != Posted::Queued,
            );
            posted += 1;
        }
        while let Some(packet) = outbox.take() {
            if posted % 499 == 3 {
                lost += 1;
                continue;
            }
            let used = encode(&packet, &mut wire).unwrap();
            let bytes = wire[..used].iter();
            let given = bytes.filter_map(|byte| decoder.push(*byte)).last();
            assert_eq!(given.as_ref(), Some(&packet));
            received += 1;
        }
    }
    assert!(
        dropped > 10_000 && lost > 1000 && posted > 39 << 16,
        "{posted} {dropped} {lost}"
    );
    assert_eq!(posted, received + dropped + lost);
    // Losses after the last received message are not known yet.
    let unseen = posted - received - u64::from(decoder.missing);
    assert!(unseen < 20, "{unseen}");
    assert_eq!((decoder.damaged, decoder.stepped_back), (0, 0));
}

#[test]
fn counters_stay_at_the_most_that_they_hold() {
    let mut assembler = Assembler::new(4.096, &Plan::PAPER);
    (assembler.lost, assembler.doubtful) = (u32::MAX - 3, u32::MAX - 3);
    // The first conversion is counted with the missing ones before it, so the counter is set after
    // that.
    let mut scans = (0..40).flat_map(|n| scan(n, n, 0).map(move |conversion| (n, conversion)));
    for (n, mut conversion) in scans.by_ref() {
        if n == 1 {
            assembler.lost = u32::MAX - 3;
        }
        // Every third scan is lost, and in every fourth the supply is too low.
        if n % 4 == 1 {
            conversion = conversion.with_status(StatusByte(conversion.status().0 | 0x20));
        }
        if n % 3 != 2 {
            assembler.push(&conversion, |_| {});
        }
    }
    assert_eq!((assembler.lost, assembler.doubtful), (u32::MAX, u32::MAX));
}

/// A finger is idle for a year. The frame numbers wrap after 206 days, but the rate must stay
/// right.
#[test]
fn the_rate_is_right_before_and_after_the_frames_numbers_wrap() {
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    let (mut healths, mut latest_us) = (0, 0);
    let mut emit = |event| {
        if let Event::Health(health) = event {
            assert_rate(&health);
            (healths, latest_us) = (healths + 1, health.t_us);
        }
    };
    let hour = scan_at(3_600_000_000);
    for number in (0..200).chain((1..365 * 24).map(|n| n * hour)) {
        scan(0, number, 0).for_each(|conversion| pipeline.push(conversion, &mut emit));
    }
    assert!(
        healths > 500 && latest_us > 364 * DAY_S * 1_000_000,
        "{healths} healths up to {latest_us} us"
    );
}
