//! Tests the register bits of all combinations of settings.

use ads1258::{
    CLOCK_MAX_HZ, CLOCK_MIN_HZ, Config, ConfigError, DataRate, Delay, IdleMode, Mux, Register,
    SensorBias, Sysred,
};

mod common;
use common::SCAN;

#[test]
fn registers_have_addresses_names_and_reset_values() {
    let map = [
        ("CONFIG0", 0x0A),
        ("CONFIG1", 0x83),
        ("MUXSCH", 0x00),
        ("MUXDIF", 0x00),
        ("MUXSG0", 0xFF),
        ("MUXSG1", 0xFF),
        ("SYSRED", 0x00),
        ("GPIOC", 0xFF),
        ("GPIOD", 0x00),
        ("ID", 0x8B),
    ];
    for (address, (register, (name, reset_value))) in (0..).zip(Register::ALL.into_iter().zip(map))
    {
        assert_eq!(register as u8, address);
        assert_eq!(register.to_string(), name);
        assert_eq!(Register::RESET_VALUES[usize::from(address)], reset_value);
    }
}

type Change<T> = fn(&mut T);

#[test]
fn every_bit_has_its_place() {
    let registers = |change: fn(&mut Config)| {
        let mut config = Config {
            data_rate: DataRate::Drate0,
            idle_mode: IdleMode::Standby,
            clock_output: false,
            gpio_inputs: 0,
            ..Config::default()
        };
        change(&mut config);
        config.registers().unwrap()
    };
    let config0: [(u8, Change<Config>); 6] = [
        (0x02, |_| ()), // STAT is always set
        (0x42, |config| config.short_spi_timeout = true),
        (0x22, |config| config.mux = Mux::Fixed { ainp: 0, ainn: 1 }),
        (0x12, |config| config.bypass = true),
        (0x0A, |config| config.clock_output = true),
        (0x06, |config| config.chop = true),
    ];
    for (expected, change) in config0 {
        assert_eq!(registers(change)[0], expected);
    }
    let all_fields = registers(|config| {
        config.delay = Delay::Dly5;
        config.sensor_bias = SensorBias::MicroAmps24;
        config.data_rate = DataRate::Drate2;
    });
    assert_eq!(all_fields[1], 0b0101_1110); // 0 101 11 10
    assert_eq!(
        registers(|config| config.idle_mode = IdleMode::Sleep)[1],
        0b1000_0000
    );

    let sysred: [(u8, Change<Sysred>); 5] = [
        (0x20, |internal| internal.reference = true),
        (0x10, |internal| internal.gain = true),
        (0x08, |internal| internal.temp = true),
        (0x04, |internal| internal.vcc = true),
        (0x01, |internal| internal.offset = true),
    ];
    for (expected, change) in sysred {
        let mut internal = Sysred::NONE;
        change(&mut internal);
        assert_eq!(internal.to_bits(), expected);
    }
    assert_eq!(Sysred::ALL.to_bits(), 0x3D);
}

#[test]
fn defaults_are_the_reset_values() {
    assert_eq!(
        Sysred::default().to_bits(),
        Register::RESET_VALUES[Register::Sysred as usize]
    );
    assert_eq!(
        Config::default().registers().unwrap()[..],
        Register::RESET_VALUES[..9]
    );
}

/// Tests every combination of the fields in CONFIG0 and CONFIG1 with every set of internal
/// readings.
#[test]
fn every_configuration_has_its_registers() {
    const IDLE: [IdleMode; 2] = [IdleMode::Standby, IdleMode::Sleep];
    const BIAS: [(u8, SensorBias); 3] = [
        (0b00, SensorBias::Off),
        (0b01, SensorBias::MicroAmps1_5),
        (0b11, SensorBias::MicroAmps24),
    ];
    let mut valid = 0;
    for config0 in (0..0x80_u8).step_by(4) {
        let [spirst, muxmod, bypas, clkenb, chop] =
            [6, 5, 4, 3, 2].map(|bit| config0 >> bit & 1 == 1);
        for config1 in 0..=0xFF_u8 {
            let Some((_, sensor_bias)) = BIAS
                .into_iter()
                .find(|(bits, _)| *bits == config1 >> 2 & 0b11)
            else {
                continue; // 10 is undefined
            };
            for sysred in (0..=0xFF_u8).filter(|bits| bits & 0b1100_0010 == 0) {
                let [reference, gain, temp, vcc, offset] =
                    [5, 4, 3, 2, 0].map(|bit| sysred >> bit & 1 == 1);
                let internal = Sysred {
                    reference,
                    gain,
                    temp,
                    vcc,
                    offset,
                };
                let (mux, expected_mux) = if muxmod {
                    (
                        Mux::Fixed {
                            ainp: 0xC,
                            ainn: 0x3,
                        },
                        [0xC3, 0, 0, 0, 0],
                    )
                } else {
                    let mux = Mux::AutoScan {
                        differential: 0x81,
                        single: 0xA53C,
                        internal,
                    };
                    (mux, [0, 0x81, 0x3C, 0xA5, sysred])
                };
                let config = Config {
                    mux,
                    data_rate: DataRate::ALL[usize::from(config1 & 0b11)],
                    delay: Delay::ALL[usize::from(config1 >> 4 & 0b111)],
                    chop,
                    idle_mode: IDLE[usize::from(config1 >> 7)],
                    sensor_bias,
                    bypass: bypas,
                    clock_output: clkenb,
                    short_spi_timeout: spirst,
                    gpio_inputs: 0x0F,
                    gpio_levels: 0x70,
                    ..Config::default()
                };
                let forbidden = chop && !muxmod && sysred & 0b11_1100 != 0;
                match config.registers() {
                    Ok(image) => {
                        assert!(!forbidden, "{config:?}");
                        // The status byte is always enabled.
                        assert_eq!(image[..2], [config0 | 0x02, config1]);
                        assert_eq!(image[2..7], expected_mux);
                        assert_eq!(image[7..], [0x0F, 0x70]);
                        valid += 1;
                    }
                    Err(error) => {
                        assert!(forbidden, "{config:?}");
                        assert_eq!(error, ConfigError::ChopWithInternalReadings);
                    }
                }
            }
        }
    }
    // 32 CONFIG0 x 192 CONFIG1 x 32 SYSRED, minus the forbidden CHOP in auto-scan (8 of 32) with 30
    // of the 32 SYSRED.
    assert_eq!(valid, 192 * (32 * 32 - 8 * 30));
}

#[test]
fn what_the_chip_cannot_do_is_refused() {
    let clock = |clock_hz| Config {
        clock_hz,
        ..Config::RESET
    };
    let scan = |single, internal| Mux::AutoScan {
        differential: 0,
        single,
        internal,
    };
    let offset = Sysred {
        offset: true,
        ..Sysred::NONE
    };
    let empty = Config {
        mux: scan(0, Sysred::NONE),
        ..Config::RESET
    };
    let chopped = Config { chop: true, ..SCAN };
    let chopped_offset = Config {
        mux: scan(1, offset),
        ..chopped
    };
    for (config, expected) in [
        (clock(CLOCK_MIN_HZ), Ok(())),
        (clock(CLOCK_MAX_HZ), Ok(())),
        (empty, Err(ConfigError::EmptyScan)),
        (chopped, Err(ConfigError::ChopWithInternalReadings)),
        (chopped_offset, Ok(())),
    ] {
        assert_eq!(config.validate(), expected);
        assert_eq!(config.registers().map(|_| ()), expected);
    }
    for clock_hz in [0, CLOCK_MIN_HZ - 1, CLOCK_MAX_HZ + 1, u32::MAX] {
        let refused = clock(clock_hz).registers().unwrap_err();
        assert_eq!(refused, ConfigError::Clock { clock_hz });
    }
    for ainp in 0..=0xFF_u8 {
        for ainn in 0..=0xFF_u8 {
            let mux = Mux::Fixed { ainp, ainn };
            let expected = match (ainp, ainn) {
                (0..=15, 0..=15) => Ok(()),
                (0..=15, number) | (number, _) => Err(ConfigError::ChannelNumber { number }),
            };
            assert_eq!(
                Config {
                    mux,
                    ..Config::RESET
                }
                .validate(),
                expected
            );
        }
    }
}
