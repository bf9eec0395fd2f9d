//! Tests the order, timing, codes and flags of conversions.
mod common;
use common::{chip, next, read, started, write};
use hal_mock::{Ads1258, Constant, Fault, Options, Scene};

/// The project's default scan: DRATE 1, DLY 3, AIN0-15 and five internal readings.
fn scan_setup(chip: &mut Ads1258) {
    write(chip, 0, 0, &[0x02, 0x31, 0x00, 0x00, 0xFF, 0xFF, 0x3D]);
}

/// Nominal nanoseconds of cycles at 15.72864 MHz, computed in a different way from the chip's.
fn ns(cycles: u64) -> u64 {
    // 1e9 / 15728640 = 78125 / 1228.8 = 390625 / 6144
    (u128::from(cycles) * 390_625 / 6144) as u64
}

#[test]
fn the_scan_has_21_slots_in_ascending_chid_and_wraps() {
    let mut chip = chip(|_| ());
    scan_setup(&mut chip);
    chip.set_start(0, true);
    for _ in 0..3 {
        for chid in (0x08..=0x18).chain(0x1A..=0x1D) {
            assert_eq!(next(&mut chip).1, 0x80 | chid);
        }
    }
}

#[test]
fn drdy_falls_every_3106_cycles_and_never_drifts() {
    let mut chip = chip(|_| ());
    scan_setup(&mut chip);
    let zero_ns = 123_457;
    chip.set_start(zero_ns, true);
    for k in 0..50_000 {
        let edge_ns = chip.next_drdy_fall_ns().unwrap();
        assert_eq!(edge_ns, zero_ns + ns(2628 + 3106 * k));
        chip.advance_to(edge_ns);
        assert_eq!(chip.latest_drdy_fall_ns(), Some(edge_ns));
    }
    assert_eq!(chip.counters().conversions, 50_000);
    assert_eq!(chip.conversion_period_ns(), ns(3106));
}

#[test]
fn a_clock_100_ppm_fast_scans_100_ppm_faster() {
    let mut chip = chip(|o| o.clock_error_ppm = 100.0);
    scan_setup(&mut chip);
    chip.set_start(0, true);
    let first_ns = next(&mut chip).0;
    let last_ns = (0..21_000).map(|_| next(&mut chip).0).last().unwrap();
    let fast = 1000.0 / ((last_ns - first_ns) as f64 * 1e-9) / (15_728_640.0 / 3106.0 / 21.0);
    assert!((fast - 1.0001).abs() < 1e-9, "{fast}");
}

#[test]
fn differential_pairs_come_first_and_offset_follows_the_inputs() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 3, &[0x84, 0x02, 0x00, 0x01]);
    chip.set_start(0, true);
    let mv_100 = (0.1_f64 / 4.096 * 7864320.0).round() as i32;
    for expected in [
        (0x82, -mv_100),
        (0x87, -mv_100),
        (0x89, mv_100),
        (0x98, 0),
        (0x82, -mv_100),
    ] {
        let (_, status, code) = next(&mut chip);
        assert_eq!((status, code), expected);
    }
}

#[test]
fn a_fixed_channel_is_fast_and_has_no_chid() {
    let mut chip = chip(|o| o.fixed_channel_chid = Some(0x1F));
    write(&mut chip, 0, 0, &[0x22, 0x03, 0x3A]); // AIN3 - AIN10
    chip.set_start(0, true);
    let (first_ns, status, code) = next(&mut chip);
    assert_eq!((first_ns, status), (ns(708), 0x9F));
    assert_eq!(code, -(0.7_f64 / 4.096 * 7864320.0).round() as i32);
    assert_eq!(next(&mut chip).0, ns(708 + 128));
}

#[test]
fn internal_readings_have_the_datasheets_scalings() {
    let mut chip = chip(|o| {
        o.analog.avdd_v = 4.9;
        o.analog.reference_v = 4.1;
        o.analog.temperature_c = 31.0;
        o.analog.gain = 1.001;
        o.analog.offset_v = 50e-6;
    });
    write(&mut chip, 0, 4, &[0x00, 0x00, 0x3D]);
    chip.set_start(0, true);
    let codes: Vec<f64> = (0..5).map(|_| f64::from(next(&mut chip).2)).collect();
    let [offset, vcc, temp, gain, reference] = codes[..] else {
        panic!()
    };
    assert!((offset - 50e-6 / 4.1 * 7864320.0).abs() <= 0.5);
    assert!((vcc / 786432.0 - 4.9).abs() < 1e-6);
    let uv = temp * 4.1e6 / 7864320.0;
    assert!(((uv - 168000.0) / 394.0 + 25.0 - 31.0).abs() < 0.002);
    assert!((gain / 7864320.0 - 1.001).abs() < 2e-5);
    assert!((reference / 786432.0 - 4.1).abs() < 1e-6);
    chip.analog_mut().temperature_c = -10.0;
    for _ in 0..2 {
        next(&mut chip);
    }
    let uv = f64::from(next(&mut chip).2) * 4.1e6 / 7864320.0;
    assert!(((uv - 168000.0) / 394.0 + 25.0 + 10.0).abs() < 0.002);
}

#[test]
fn codes_clip_and_ovf_sets_beyond_1_06_vref() {
    let of_reference = [
        1.0,
        1.0599,
        1.0601,
        1.2,
        -1.0,
        -1.0601,
        -1.2,
        1.0 / 7864320.0,
    ];
    let volts = std::array::from_fn(|n| 4.096 * of_reference.get(n).unwrap_or(&0.0));
    let options = Options {
        noise: false,
        ..Options::default()
    };
    let mut chip = Ads1258::new(Box::new(Constant { volts, end_s: 1.0 }), options);
    chip.set_start(0, true);
    let got: Vec<_> = (0..8)
        .map(|_| next(&mut chip))
        .map(|(_, status, code)| (status & 0x40 != 0, code))
        .collect();
    let near = |code: i32, fraction: f64| (f64::from(code) / 7864320.0 - fraction).abs() < 1e-6;
    assert_eq!(got[0], (false, 0x780000));
    assert!(!got[1].0 && near(got[1].1, 1.0599));
    assert!(got[2].0 && near(got[2].1, 1.0601));
    assert_eq!(got[3], (true, 0x7F_FFFF));
    assert_eq!(got[4], (false, -0x780000));
    assert!(got[5].0 && near(got[5].1, -1.0601));
    assert_eq!(got[6], (true, -0x80_0000));
    assert_eq!(got[7], (false, 1));
}

#[test]
fn bypass_with_nothing_connected_reads_full_scale() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 0, &[0x12]);
    chip.set_start(0, true);
    assert_eq!(next(&mut chip).2, 0x7F_FFFF);
}

#[test]
fn a_low_supply_sets_its_flag_and_spoils_the_data() {
    let mut chip = chip(|o| o.analog.avdd_v = 4.2);
    chip.set_start(0, true);
    let (_, status, code) = next(&mut chip);
    assert_eq!((status, code & 0xFF_FFFF), (0xA8, 0xA5A5A5));
}

#[test]
fn chopping_spoils_or_skips_the_readings_it_excludes() {
    for (choice, expected) in [
        (false, vec![0x98, 0x9A, 0x9B, 0x9C, 0x9D]),
        (true, vec![0x98; 5]),
    ] {
        let mut chip = chip(|o| o.chop_skips_internal = choice);
        write(&mut chip, 0, 0, &[0x06, 0x03, 0, 0, 0, 0, 0x3D]);
        chip.set_start(0, true);
        let scan: Vec<_> = (0..5).map(|_| next(&mut chip)).collect();
        assert_eq!(scan.iter().map(|s| s.1).collect::<Vec<_>>(), expected);
        let mut spoilt = scan.iter().filter(|s| s.1 > 0x98);
        assert!(spoilt.all(|s| s.2 as u32 & 0xFF_FFFF == 0xA5A5A5));
        // Two passes of 128 N + 546 cycles; 34 more before the first result.
        assert_eq!((scan[0].0, scan[1].0), (ns(2 * 674 + 34), ns(4 * 674 + 34)));
    }
}

#[test]
fn unread_data_are_lost_and_drdy_pulses_for_one_cycle() {
    let mut chip = started();
    let first = ns(708);
    let second = ns(708 + 674);
    assert!(chip.drdy_high(first - 1));
    assert!(!chip.drdy_high(first));
    let pulse = ns(708 + 673);
    assert!(!chip.drdy_high(pulse - 1));
    assert!(chip.drdy_high(pulse));
    assert!(chip.drdy_high(second - 1));
    assert!(!chip.drdy_high(second));
    assert_eq!(read(&mut chip, second).0, 0x89, "AIN0's result is gone");
    assert!(
        chip.drdy_high(second),
        "rises with the first SCLK of a read"
    );
    let c = chip.counters();
    assert_eq!((c.conversions, c.read, c.lost), (2, 1, 1));
}

#[test]
fn start_low_finishes_the_conversion_and_start_high_goes_on_with_the_next_channel() {
    let mut chip = started();
    next(&mut chip);
    chip.set_start(ns(800), false);
    assert_eq!(next(&mut chip).1, 0x89);
    assert_eq!(chip.next_drdy_fall_ns(), None);
    chip.set_start(1_000_000, true);
    assert_eq!(chip.next_drdy_fall_ns(), Some(1_000_000 + ns(708)));
    assert_eq!(next(&mut chip).1, 0x8A);
}

#[test]
fn selecting_channels_puts_the_scan_back_to_its_top() {
    let mut chip = started();
    next(&mut chip);
    chip.set_start(ns(800), false);
    next(&mut chip);
    write(&mut chip, 1_000_000, 6, &[0x01]);
    chip.set_start(1_000_000, true);
    assert_eq!(next(&mut chip).1, 0x88);
}

#[test]
fn nothing_selected_means_nothing_comes() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 4, &[0, 0]);
    chip.set_start(0, true);
    assert_eq!(chip.next_drdy_fall_ns(), None);
    write(&mut chip, 500, 6, &[0x04]);
    assert_eq!(next(&mut chip).1, 0x9A);
}

#[test]
fn pulse_convert_makes_one_conversion_and_starts_the_scenes_time() {
    let mut chip = chip(|_| ());
    chip.transfer(5000, &mut [0x80]);
    assert_eq!(chip.scene_zero_ns(), Some(5000));
    assert_eq!(next(&mut chip).1, 0x88);
    assert_eq!(chip.next_drdy_fall_ns(), None);
    chip.transfer(100_000, &mut [0x80]);
    assert_eq!(next(&mut chip).1, 0x89);
}

#[test]
fn register_writes_act_on_the_next_conversion() {
    let mut chip = started();
    write(&mut chip, 100, 1, &[0x31]);
    assert_eq!(next(&mut chip).0, ns(708));
    assert_eq!(next(&mut chip).0, ns(708 + 3106));
}

#[test]
fn options_decide_where_the_datasheet_does_not() {
    let mut chip = chip(|o| (o.first_conversion_with_delay, o.sleep_wake_cycles) = (true, 1000));
    write(&mut chip, 0, 1, &[0x31]);
    chip.set_start(0, true);
    assert_eq!(next(&mut chip).0, ns(2628 + 512));
    let mut chip = common::chip(|o| o.sleep_wake_cycles = 1000);
    chip.set_start(0, true); // IDLMOD is 1 after reset
    assert_eq!(next(&mut chip).0, ns(1708));
}

#[test]
fn a_stalled_chip_gives_nothing_until_let_go() {
    let mut chip = started();
    next(&mut chip);
    chip.advance_to(ns(800));
    chip.begin_fault(Fault::Stall);
    assert_eq!(chip.next_drdy_fall_ns(), None);
    chip.advance_to(1_000_000);
    chip.end_fault(Fault::Stall);
    assert_eq!(chip.next_drdy_fall_ns(), Some(1_000_000 + ns(708)));
}

/// A scene whose volts are its seconds, to show when it was sampled.
struct Ramp;

impl Scene for Ramp {
    fn volts(&mut self, _input: u8, t_s: f64) -> f64 {
        t_s
    }

    fn end_s(&self) -> f64 {
        0.01
    }
}

#[test]
fn the_scene_is_sampled_a_constant_delay_before_drdy_whenever_start_rose() {
    for config0 in [0x02, 0x06] {
        let run = |zero_ns: u64| {
            let mut chip = Ads1258::new(
                Box::new(Ramp),
                Options {
                    noise: false,
                    ..Options::default()
                },
            );
            write(&mut chip, 0, 0, &[config0, 0x32]);
            assert!(!chip.ended());
            chip.set_start(zero_ns, true);
            let delay_ns = chip.sample_delay_ns();
            let codes: Vec<i32> = (0..200)
                .map(|_| next(&mut chip))
                .map(|(edge_ns, _, code)| {
                    let t_s = (edge_ns - zero_ns).saturating_sub(delay_ns) as f64 * 1e-9;
                    assert!((f64::from(code) * 4.096 / 7864320.0 - t_s).abs() < 0.3e-6);
                    code
                })
                .collect();
            assert!(chip.ended());
            codes
        };
        assert_eq!(run(0), run(987_654_321));
    }
}

#[test]
fn noise_has_the_data_rates_strength_and_repeats_with_the_seed() {
    for (config0, drate, uv) in [
        (0x02, 3, 12.0),
        (0x02, 2, 7.9),
        (0x02, 1, 4.5),
        (0x02, 0, 2.8),
        (0x06, 1, 4.5 / 1.4),
    ] {
        let run = |seed| {
            let mut chip = chip(|o| (o.noise, o.seed) = (true, seed));
            write(&mut chip, 0, 0, &[config0, drate, 0, 0, 0, 0, 0x01]);
            chip.set_start(0, true);
            (0..20_000)
                .map(|_| f64::from(next(&mut chip).2))
                .collect::<Vec<_>>()
        };
        let codes = run(7);
        let rms_uv =
            (codes.iter().map(|c| c * c).sum::<f64>() / 20_000.0).sqrt() * 4.096e6 / 7864320.0;
        assert!(
            (rms_uv / uv - 1.0).abs() < 0.02,
            "DRATE {drate}: {rms_uv} uV"
        );
        if drate == 3 {
            assert_eq!(codes, run(7));
            assert_ne!(codes, run(8));
        }
    }
}
