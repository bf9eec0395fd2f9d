//! Compares the rate formula with the datasheet's table, and tests the rates of whole scans.

use ads1258::{CRYSTAL_CLOCK_HZ, Config, DataRate, Delay, Mux, Sysred};

mod common;
use common::SCAN;

/// The datasheet's rates (SBAS297G) at 16 MHz, DLY 0, CHOP 0, in auto-scan and on a fixed channel.
const TABLE: [(DataRate, f32, f32); 4] = [
    (DataRate::Drate3, 23739.0, 125_000.0),
    (DataRate::Drate2, 15123.0, 31250.0),
    (DataRate::Drate1, 6168.0, 7812.5),
    (DataRate::Drate0, 1831.0, 1953.0),
];

const AUTO_SCAN: Mux = Config::RESET.mux;
const FIXED: Mux = Mux::Fixed { ainp: 0, ainn: 1 };

/// True if a rate equals the table's entry, exactly or rounded to whole samples per second, as most
/// entries are.
fn agrees(rate_hz: f32, entry: f32) -> bool {
    rate_hz == entry || rate_hz.round() == entry
}

#[test]
fn every_entry_of_the_rate_table() {
    for (data_rate, auto_scan, fixed_channel) in TABLE {
        for (mux, entry) in [(AUTO_SCAN, auto_scan), (FIXED, fixed_channel)] {
            let config = Config {
                clock_hz: 16_000_000,
                mux,
                data_rate,
                ..Config::RESET
            };
            let rate_hz = config.conversion_rate_hz();
            assert!(
                agrees(rate_hz, entry),
                "{data_rate:?}: {rate_hz} is not {entry}"
            );
        }
    }
}

#[test]
fn ticks_are_the_formula_without_rounding() {
    for data_rate in DataRate::ALL {
        for delay in Delay::ALL {
            for chop in [false, true] {
                let n = 4_f64.powi(3 - data_rate as i32);
                let td = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 48.0][delay as usize];
                let (chop_count, halves) = if chop { (1.0, 2.0) } else { (0.0, 1.0) };
                let auto_scan = 128.0 * (n + 4.265625 + td) * halves;
                let fixed_channel = 128.0 * (n + chop_count * (4.265625 + td)) * halves;
                for (mux, ticks) in [(AUTO_SCAN, auto_scan), (FIXED, fixed_channel)] {
                    let config = Config {
                        mux,
                        data_rate,
                        delay,
                        chop,
                        ..Config::RESET
                    };
                    assert_eq!(f64::from(config.conversion_ticks()), ticks);
                    assert_eq!(
                        config.conversion_rate_hz(),
                        (f64::from(CRYSTAL_CLOCK_HZ) / ticks) as f32
                    );
                }
            }
        }
    }
}

#[test]
fn the_default_scan_has_241_14_frames_per_second() {
    const FRAME_RATE_HZ: f32 = SCAN.frame_rate_hz();
    assert_eq!(SCAN.clock_hz, 32_768 * 480);
    assert_eq!(SCAN.slots(), 21);
    assert_eq!(SCAN.conversion_ticks(), 128 * 20 + 546);
    assert_eq!(SCAN.frame_ticks(), 21 * 3106);
    assert_eq!(format!("{FRAME_RATE_HZ:.2}"), "241.14");
    assert_eq!(SCAN.conversion_rate_hz(), 15_728_640.0 / 3106.0);
}

#[test]
fn the_chopped_alternative_has_240_15_frames_per_second() {
    let config = Config {
        clock_hz: 16_000_000,
        mux: scan_of(0xFFFF),
        data_rate: DataRate::Drate2,
        delay: Delay::Dly4,
        chop: true,
        ..Config::default()
    };
    assert_eq!(config.validate(), Ok(()));
    assert_eq!(format!("{:.2}", config.frame_rate_hz()), "240.15");
}

const fn scan_of(single: u16) -> Mux {
    Mux::AutoScan {
        differential: 0,
        single,
        internal: Sysred::NONE,
    }
}

#[test]
fn degenerate_rates_are_finite() {
    let with = |mux| Config {
        mux,
        clock_hz: 16_000_000,
        ..Config::default()
    };
    assert_eq!(with(scan_of(0)).frame_rate_hz(), 0.0);
    assert_eq!(with(FIXED).frame_rate_hz(), 125_000.0);
    assert_eq!(with(FIXED).sclk_max_hz(), 8_000_000);
}
