//! Tests the parsing of conversions, channel ids, scan order, and conversion to volts and degrees.

use ads1258::{Channel, Config, Conversion, Mux, Status, Sysred, reading};

mod common;
use common::SCAN;

#[test]
fn codes_are_sign_extended() {
    for (bytes, code) in [
        ([0x00, 0x00, 0x00], 0),
        ([0x00, 0x00, 0x01], 1),
        ([0x78, 0x00, 0x00], reading::CODES_PER_VREF),
        ([0x7F, 0xFF, 0xFF], 0x7F_FFFF),
        ([0x80, 0x00, 0x00], -0x80_0000),
        ([0xFF, 0xFF, 0xFF], -1),
        ([0x12, 0x34, 0x56], 0x12_3456),
    ] {
        let [high, middle, low] = bytes;
        let conversion = Conversion::from_bytes([0x88, high, middle, low]);
        let status = Status(0x88);
        assert_eq!(conversion, Conversion { status, code });
    }
}

#[test]
fn status_bits() {
    for byte in 0..=0xFF_u8 {
        let status = Status(byte);
        assert_eq!(status.is_new(), byte & 0b1000_0000 != 0);
        assert_eq!(status.is_overflow(), byte & 0b0100_0000 != 0);
        assert_eq!(status.is_supply_low(), byte & 0b0010_0000 != 0);
        let used = !matches!(byte & 0x1F, 0x19 | 0x1E | 0x1F);
        assert_eq!(status.channel().is_some(), used);
        if let Some(channel) = status.channel() {
            assert_eq!(channel.id(), status.chid());
        }
    }
}

#[test]
fn channel_ids_and_names() {
    let table = [
        (0x00, Channel::Differential(0), "DIFF0"),
        (0x07, Channel::Differential(7), "DIFF7"),
        (0x08, Channel::Single(0), "AIN0"),
        (0x17, Channel::Single(15), "AIN15"),
        (0x18, Channel::Offset, "OFFSET"),
        (0x1A, Channel::Vcc, "VCC"),
        (0x1B, Channel::Temp, "TEMP"),
        (0x1C, Channel::Gain, "GAIN"),
        (0x1D, Channel::Ref, "REF"),
    ];
    for (id, channel, name) in table {
        assert_eq!(channel.id(), id);
        assert_eq!(Channel::from_id(id), Some(channel));
        assert_eq!(channel.to_string(), name);
    }
    assert!((0x1E..=0xFF).all(|id| Channel::from_id(id).is_none()));
    // Numbers out of range map to the unused id.
    assert_eq!(Channel::Differential(8).id(), 0x19);
    assert_eq!(Channel::Single(16).id(), 0x19);
    assert_eq!(Channel::Single(255).id(), 0x19);
}

/// Many scans, including every single channel and all channels together.
fn scans() -> impl Iterator<Item = Config> {
    let (all, none) = (Sysred::ALL, Sysred::NONE);
    let ends = Sysred {
        reference: true,
        offset: true,
        ..none
    };
    let sets = [
        (0, 0, all),
        (0xFF, 0xFFFF, all),
        (0x81, 0x8001, ends),
        (0, 0xFFFF, none),
        (0x10, 0, none),
    ];
    let alone = (0..8)
        .map(|n| (1 << n, 0, Sysred::NONE))
        .chain((0..16).map(|n| (0, 1 << n, Sysred::NONE)));
    sets.into_iter()
        .chain(alone)
        .map(|(differential, single, internal)| Config {
            mux: Mux::AutoScan {
                differential,
                single,
                internal,
            },
            ..Config::default()
        })
}

#[test]
fn a_scan_ascends_in_channel_ids_and_wraps() {
    for config in scans() {
        let channels: Vec<Channel> = config.scan().collect();
        assert_eq!(channels.len(), config.slots());
        assert!(channels.windows(2).all(|pair| pair[0].id() < pair[1].id()));
        for (index, &channel) in channels.iter().enumerate() {
            assert_eq!(
                config.next_channel(channel),
                channels[(index + 1) % channels.len()]
            );
            assert!(config.channel_mask() >> channel.id() & 1 == 1);
        }
    }
}

#[test]
fn the_next_channel_of_one_outside_the_scan() {
    let mux = Mux::AutoScan {
        differential: 0,
        single: 0b1010,
        internal: Sysred::NONE,
    };
    let config = Config {
        mux,
        ..Config::default()
    };
    for (channel, expected) in [
        (Channel::Differential(0), 1),
        (Channel::Single(2), 3),
        (Channel::Ref, 1),
    ] {
        assert_eq!(config.next_channel(channel), Channel::Single(expected));
    }
    let fixed = Config {
        mux: Mux::Fixed { ainp: 0, ainn: 1 },
        ..Config::default()
    };
    assert_eq!(fixed.next_channel(Channel::Vcc), Channel::Vcc);
    assert_eq!(fixed.scan().next(), None);
    assert_eq!(fixed.slots(), 1);
}

#[test]
fn the_default_scan_is_all_inputs_and_all_internal_readings() {
    use Channel::{Gain, Offset, Ref, Temp, Vcc};
    let inputs = (0..16).map(Channel::Single);
    assert!(SCAN.scan().eq(inputs.chain([Offset, Vcc, Temp, Gain, Ref])));
}

#[test]
fn internal_readings() {
    assert_eq!(reading::volts(reading::CODES_PER_VREF, 4.096), 4.096);
    assert_eq!(reading::volts(-1, 5.0), -5.0 / 7_864_320.0);
    assert_eq!(reading::supply_v(5 * 786_432), 5.0);
    assert_eq!(reading::reference_v(786_432 * 4), 4.0);
    assert_eq!(reading::gain(7_864_320), 1.0);
    assert_eq!(reading::offset_v(0, 4.096), 0.0);
}

#[test]
fn temperatures_are_right_to_a_thousandth_of_a_degree() {
    for vref_v in [2.5_f32, 4.096, 5.0] {
        for celsius in -40..=105 {
            for (slope, convert) in [
                (394.0, reading::temperature_c as fn(i32, f32) -> f32),
                (563.0, reading::temperature_board_c),
            ] {
                let sensor_v = (168_000.0 + slope * f64::from(celsius - 25)) * 1e-6;
                let code = (sensor_v / f64::from(vref_v) * 7_864_320.0).round();
                // The code is rounded, so compare with the temperature that it represents.
                let exact =
                    (code * f64::from(vref_v) / 7_864_320.0 * 1e6 - 168_000.0) / slope + 25.0;
                let error = f64::from(convert(code as i32, vref_v)) - exact;
                assert!(
                    error.abs() < 1e-3,
                    "{celsius} C at {vref_v} V: off by {error}"
                );
            }
        }
    }
}

#[test]
fn small_differences_survive_only_in_integers() {
    // Two codes near full scale that are three LSB apart.
    let (code, base) = (7_864_311, 7_864_308);
    let exact = 3.0 * 4.096 / 7_864_320.0;
    let late = reading::volts(code, 4.096) - reading::volts(base, 4.096);
    assert!((reading::volts_above(code, base, 4.096) - exact).abs() < 1e-6 * exact);
    assert!((late - exact).abs() > 1e-2 * exact);
    assert_eq!(
        reading::volts_above(i32::MAX, i32::MIN, 1.0),
        reading::volts(i32::MAX, 1.0)
    );
}
