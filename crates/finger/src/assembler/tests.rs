//! Tests scans with and without losses, flags and clipped codes.

use super::*;
use crate::converter::Ads1258Plan;
use ads1258::{Conversion, Status};
extern crate std;
use std::vec::Vec;

/// Channel ids of the scan, in the datasheet's order.
const IDS: [u8; 21] = [
    8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 26, 27, 28, 29,
];

fn conversion(count: u32, flags: u8) -> TimedConversion {
    let slot = count as usize % 21;
    let t_us = (count as u64 * 3106 * 1_000_000 / 15_728_640) as u32;
    let code = if slot < 16 {
        count as i32
    } else {
        [3, 3_932_160, 1_677_722, 7_864_320, 3_221_225][slot - 16]
    };
    TimedConversion::new(
        t_us,
        Conversion {
            status: Status(flags | IDS[slot]),
            code,
        },
    )
}

fn run(counts: impl Iterator<Item = u32>, start_us: u32) -> (Assembler, Vec<Frame>) {
    let mut assembler = Assembler::new(4.096, &Plan::PAPER);
    let mut frames = Vec::new();
    for count in counts {
        let mut timed = conversion(count, 0x80);
        timed.t_us = timed.t_us.wrapping_add(start_us);
        assembler.push(&timed, |frame| frames.push(*frame));
    }
    (assembler, frames)
}

#[test]
fn whole_scans_become_frames_and_readings() {
    let (assembler, frames) = run(0..63, u32::MAX - 3000);
    assert_eq!(frames.len(), 3);
    for (n, frame) in frames.iter().enumerate() {
        let found = (frame.number, frame.present, frame.good);
        assert_eq!(found, (n as u32, 0xffff, 0xffff));
        assert_eq!(frame.codes[5], n as i32 * 21 + 5);
        // Frame period by the datasheet's formula: 21 x 3106 / 15.72864 MHz.
        let off_us = frame.t_us as f64 - n as f64 * 4146.957;
        assert!(off_us.abs() < 2.0, "{off_us}");
    }
    assert_eq!((assembler.lost, assembler.doubtful), (0, 0));
    let r = assembler.readings();
    assert_eq!((r.supply_v, r.gain), (5.0, 1.0));
    assert!((r.reference_v - 4.096).abs() < 1e-5);
    // 1677722 codes of 4.096 V / 7864320 are 873.8 mV: (873813 - 168000) / 394 + 25 degrees.
    let temperature_c = r.temperature_c;
    assert!((temperature_c - 1816.4).abs() < 1.0, "{temperature_c}");
}

#[test]
fn a_loss_leaves_its_taxels_out_and_the_next_scan_is_whole() {
    for (gone, present, lost) in [
        (28..29, [0xffff, !(1 << 7), 0xffff, 0xffff, 0xffff], 1),
        (30..31, [0xffff, !(1 << 9), 0xffff, 0xffff, 0xffff], 1),
        // Across the boundary of two scans.
        (18..24, [0xffff, !0b111, 0xffff, 0xffff, 0xffff], 6),
    ] {
        let (assembler, frames) = run((0..105).filter(|count| !gone.contains(count)), 0);
        let found: Vec<_> = frames.iter().map(|frame| frame.present).collect();
        assert_eq!(found, present, "{gone:?}");
        for (frame, n) in frames.iter().zip(0..) {
            assert_eq!(frame.number, n, "{gone:?}");
            assert!(
                frame.present & 8 == 0 || frame.codes[3] == n as i32 * 21 + 3,
                "{gone:?}"
            );
        }
        assert_eq!((assembler.lost, assembler.buffered), (lost, 0), "{gone:?}");
    }
}

#[test]
fn whole_scans_lost_are_counted_by_time() {
    for gap in [21, 42, 210, 21 * 241, 5, 30] {
        let all = 5000 + 21 * 300;
        let (assembler, frames) = run((0..all).filter(|c| !(500..500 + gap).contains(c)), 0);
        let found = (assembler.lost, frames.last().unwrap().number);
        assert_eq!(found, (gap, all / 21 - 1));
    }
}

/// Tests that, whatever the board's clock, device time begins with the first conversion and nothing
/// counts as lost before it.
#[test]
fn a_first_scan_with_a_flaw_loses_nothing() {
    for flaw in [0x80, 0xc0] {
        let mut assembler = Assembler::new(4.096, &Plan::PAPER);
        let mut frames = Vec::new();
        for count in 0..63 {
            let mut timed = conversion(count, if count == 3 { flaw } else { 0x80 });
            timed.t_us += 20_100;
            assembler.push(&timed, |frame| frames.push(*frame));
        }
        let numbers: Vec<_> = frames
            .iter()
            .map(|frame| (frame.number, frame.t_us / 1000))
            .collect();
        assert_eq!(numbers, [(0, 0), (1, 4), (2, 8)]);
        let flaws = &assembler.flaws;
        assert_eq!((assembler.lost, flaws.lost, flaws.channel), (0, 0, 0));
    }
}

#[test]
fn flags_and_unknown_ids_are_reported() {
    let mut assembler = Assembler::new(4.096, &Plan::PAPER);
    let mut frames = Vec::new();
    for count in 0..21 {
        let flags = match count {
            3 => 0xc0,
            4 => 0xa0,
            5 => 0x00,
            _ => 0x80,
        };
        assembler.push(&conversion(count, flags), |frame| frames.push(*frame));
    }
    let stranger = Conversion {
        status: Status(0x80 | 0x19),
        code: 1,
    };
    assembler.push(&TimedConversion::new(4200, stranger), |frame| {
        frames.push(*frame)
    });
    assembler.finish(&mut |frame: &Frame| frames.push(*frame));
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].good, !0b11_1000);
    assert_eq!(frames[0].present, !0b10_0000);
    assert_eq!(assembler.doubtful, 4);
    assert_eq!(assembler.lost, 1);
}

#[test]
fn the_ends_of_the_scale_are_not_good() {
    let mut assembler = Assembler::new(4.096, &Plan::PAPER);
    let mut good = 0;
    for count in 0..21 {
        let code = [0x7f_ffff, -0x80_0000, 0x7f_fffe, -0x7f_ffff][count.min(3) as usize];
        let timed = conversion(count, 0x80).with_code(code);
        assembler.push(&timed, |frame| good = frame.good);
    }
    assert_eq!(good, !0b11);
}

/// Returns the number of lost conversions and the last frame's number, in a scan of one slot like
/// that of `single`. `late` has the count of each conversion and its delay in conversions.
fn of_one_slot(plan: &Plan, code: i32, late: &[(u32, f64)]) -> (u32, u32) {
    let conversion_us = plan.conversion_ns() as f64 / 1000.0;
    let mut assembler = Assembler::new(4.096, plan);
    let mut last = 0;
    for (count, late) in late {
        let t_us = ((*count as f64 + late) * conversion_us) as u32;
        let status = Status(0x80 | assembler.order.first());
        assembler.push(
            &TimedConversion::new(t_us, Conversion { status, code }),
            |frame| last = frame.number,
        );
    }
    (assembler.lost, last)
}

fn on_time(counts: core::ops::Range<u32>) -> impl Iterator<Item = (u32, f64)> {
    counts.map(|count| (count, 0.0))
}

/// Tests a case from the fault campaign: in a storm, conversions are read late by half a conversion
/// and more, each a little later, until one is lost, so no two are as far apart as two conversions.
#[test]
fn a_conversion_lost_while_service_comes_later_and_later_is_counted() {
    let creeping = [(50, 0.47), (51, 0.53), (52, 0.57), (53, 0.62), (55, 0.02)];
    let late = |counts: core::ops::Range<u32>, late: f64| counts.map(move |count| (count, late));
    let lost_while_creeping = on_time(0..44).chain(late(44..50, 0.45)).chain(creeping);
    // The same delays without a loss.
    let creeping_alone = on_time(0..50).chain(creeping[..4].iter().copied());
    // All conversions are read late by the same time for 43 ms, and one is lost.
    let late_for_long = on_time(0..44).chain(late(44..1044, 0.62));
    let times: [(Vec<_>, _); 3] = [
        (lost_while_creeping.chain(on_time(56..3000)).collect(), 1),
        (creeping_alone.chain(on_time(54..3000)).collect(), 0),
        (late_for_long.chain(on_time(1045..3000)).collect(), 1),
    ];
    for (times, lost) in times {
        assert_eq!(of_one_slot(&Plan::SINGLE, 7, &times), (lost, 2999));
    }
}

/// Tests that the delay of a conversion that leaves the fast path counts only once.
#[test]
fn flaws_do_not_make_conversions_later() {
    let times: Vec<_> = on_time(0..44)
        .chain([(44, 0.3), (45, 0.6)])
        .chain(on_time(46..300))
        .collect();
    assert_eq!(of_one_slot(&Plan::SINGLE, 0x7f_ffff, &times), (0, 299));
}

#[test]
fn gaps_of_one_slot_are_counted_by_time_though_clocks_differ() {
    // Include the slowest scan of one slot.
    let mut slowest = Ads1258Plan::of(&Plan::SINGLE);
    (slowest.data_rate, slowest.delay, slowest.chop) = (0, 7, true);
    for plan in [Plan::SINGLE, slowest.plan()] {
        for gap in [1, 2, 7, 8, 9, 500, 2000] {
            let times: Vec<_> = on_time(0..6000)
                .filter(|(count, _)| !(500..500 + gap).contains(count))
                .collect();
            assert_eq!(of_one_slot(&plan, 7, &times), (gap, 5999), "{gap}");
        }
        // A clock error of a percent is a fault but no loss; nor is one late conversion in eight,
        // even if the crystals differ by 100 ppm.
        for (rate, late) in [(0.99, 0.0), (1.01, 0.0), (0.9999, 0.6), (1.0001, 0.6)] {
            let late = |count: u32| {
                f64::from(count) * (rate - 1.0)
                    + late * f64::from(u8::from(count.is_multiple_of(8)))
            };
            let times: Vec<_> = (0..6000).map(|count| (count, late(count))).collect();
            assert_eq!(of_one_slot(&plan, 7, &times), (0, 5999), "{rate}");
        }
    }
}
