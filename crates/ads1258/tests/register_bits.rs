//! Configurations to bits, over all combinations.

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

#[test]
fn every_bit_has_its_place() {
    let none = Config {
        data_rate: DataRate::Drate0,
        idle_mode: IdleMode::Standby,
        clock_output: false,
        gpio_inputs: 0,
        ..Config::default()
    };
    let config0 = |config: Config| config.registers().unwrap()[0];
    assert_eq!(config0(none), 0x02); // STAT is always set
    assert_eq!(
        config0(Config {
            short_spi_timeout: true,
            ..none
        }),
        0x42
    );
    assert_eq!(
        config0(Config {
            mux: Mux::Fixed { ainp: 0, ainn: 1 },
            ..none
        }),
        0x22
    );
    assert_eq!(
        config0(Config {
            bypass: true,
            ..none
        }),
        0x12
    );
    assert_eq!(
        config0(Config {
            clock_output: true,
            ..none
        }),
        0x0A
    );
    assert_eq!(config0(Config { chop: true, ..none }), 0x06);

    let delay = Delay::Dly5;
    let config1 = Config {
        delay,
        sensor_bias: SensorBias::MicroAmps24,
        data_rate: DataRate::Drate2,
        ..none
    };
    assert_eq!(config1.registers().unwrap()[1], 0b0101_1110); // 0 101 11 10
    assert_eq!(
        Config {
            idle_mode: IdleMode::Sleep,
            ..none
        }
        .registers()
        .unwrap()[1],
        0b1000_0000
    );

    assert_eq!(
        Sysred {
            reference: true,
            ..Sysred::NONE
        }
        .to_bits(),
        0x20
    );
    assert_eq!(
        Sysred {
            gain: true,
            ..Sysred::NONE
        }
        .to_bits(),
        0x10
    );
    assert_eq!(
        Sysred {
            temp: true,
            ..Sysred::NONE
        }
        .to_bits(),
        0x08
    );
    assert_eq!(
        Sysred {
            vcc: true,
            ..Sysred::NONE
        }
        .to_bits(),
        0x04
    );
    assert_eq!(
        Sysred {
            offset: true,
            ..Sysred::NONE
        }
        .to_bits(),
        0x01
    );
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

/// Every combination of the fields that go into CONFIG0 and CONFIG1, with every set of internal
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
                        // The status byte is always on.
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
    // 32 CONFIG0 x 192 CONFIG1 x 32 SYSRED, minus CHOP in auto-scan (8 of 32) with 30 of the 32
    // SYSRED.
    assert_eq!(valid, 192 * (32 * 32 - 8 * 30));
}

#[test]
fn what_the_chip_cannot_do_is_refused() {
    let refused = |config: Config| config.registers().unwrap_err();
    for clock_hz in [0, CLOCK_MIN_HZ - 1, CLOCK_MAX_HZ + 1, u32::MAX] {
        assert_eq!(
            refused(Config {
                clock_hz,
                ..Config::default()
            }),
            ConfigError::Clock { clock_hz }
        );
    }
    for clock_hz in [CLOCK_MIN_HZ, CLOCK_MAX_HZ] {
        assert_eq!(
            Config {
                clock_hz,
                ..Config::default()
            }
            .validate(),
            Ok(())
        );
    }
    let mux = Mux::AutoScan {
        differential: 0,
        single: 0,
        internal: Sysred::NONE,
    };
    assert_eq!(
        refused(Config {
            mux,
            ..Config::default()
        }),
        ConfigError::EmptyScan
    );
    assert_eq!(
        refused(Config { chop: true, ..SCAN }),
        ConfigError::ChopWithInternalReadings
    );
    for ainp in 0..=0xFF_u8 {
        for ainn in 0..=0xFF_u8 {
            let config = Config {
                mux: Mux::Fixed { ainp, ainn },
                ..Config::default()
            };
            let expected = match (ainp, ainn) {
                (0..=15, 0..=15) => Ok(()),
                (0..=15, number) | (number, _) => Err(ConfigError::ChannelNumber { number }),
            };
            assert_eq!(config.validate(), expected);
        }
    }
}

#[test]
fn offset_is_allowed_with_chop() {
    let mux = Mux::AutoScan {
        differential: 0,
        single: 1,
        internal: Sysred {
            offset: true,
            ..Sysred::NONE
        },
    };
    assert_eq!(
        Config {
            mux,
            chop: true,
            ..Config::default()
        }
        .validate(),
        Ok(())
    );
}
