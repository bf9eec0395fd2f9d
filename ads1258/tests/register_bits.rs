//! Typed registers and whole configurations to and from bits, over all combinations.

use ads1258::{
    CLOCK_MAX_HZ, CLOCK_MIN_HZ, Config, Config0, Config1, ConfigError, DataRate, Delay, IdleMode, Mux, Register,
    SensorBias, Sysred,
};

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
    for (address, (register, (name, reset_value))) in (0..).zip(Register::ALL.into_iter().zip(map)) {
        assert_eq!(register.address(), address);
        assert_eq!(Register::from_address(address), Some(register));
        assert_eq!(register.to_string(), name);
        assert_eq!(register.reset_value(), reset_value);
    }
    assert!((10..=0xFF).all(|address| Register::from_address(address).is_none()));
}

#[test]
fn every_byte_either_survives_the_types_or_is_refused() {
    for bits in 0..=0xFF_u8 {
        let expected = (bits & 0b1000_0001 == 0).then_some(bits);
        assert_eq!(Config0::from_bits(bits).map(Config0::to_bits), expected);
        let expected = (bits >> 2 & 0b11 != 0b10).then_some(bits);
        assert_eq!(Config1::from_bits(bits).map(Config1::to_bits), expected);
        let expected = (bits & 0b1100_0010 == 0).then_some(bits);
        assert_eq!(Sysred::from_bits(bits).map(Sysred::to_bits), expected);
    }
}

#[test]
fn every_bit_has_its_place() {
    let none = Config0 { spirst: false, muxmod: false, bypas: false, clkenb: false, chop: false, stat: false };
    assert_eq!(none.to_bits(), 0);
    assert_eq!(Config0 { spirst: true, ..none }.to_bits(), 0x40);
    assert_eq!(Config0 { muxmod: true, ..none }.to_bits(), 0x20);
    assert_eq!(Config0 { bypas: true, ..none }.to_bits(), 0x10);
    assert_eq!(Config0 { clkenb: true, ..none }.to_bits(), 0x08);
    assert_eq!(Config0 { chop: true, ..none }.to_bits(), 0x04);
    assert_eq!(Config0 { stat: true, ..none }.to_bits(), 0x02);

    let config1 =
        Config1 { idlmod: IdleMode::Standby, dly: Delay::Dly5, sbcs: SensorBias::MicroAmps24, drate: DataRate::Drate2 };
    assert_eq!(config1.to_bits(), 0b0101_1110); // 0 101 11 10

    assert_eq!(Sysred { reference: true, ..Sysred::NONE }.to_bits(), 0x20);
    assert_eq!(Sysred { gain: true, ..Sysred::NONE }.to_bits(), 0x10);
    assert_eq!(Sysred { temp: true, ..Sysred::NONE }.to_bits(), 0x08);
    assert_eq!(Sysred { vcc: true, ..Sysred::NONE }.to_bits(), 0x04);
    assert_eq!(Sysred { offset: true, ..Sysred::NONE }.to_bits(), 0x01);
    assert_eq!(Sysred::ALL.to_bits(), 0x3D);
}

#[test]
fn defaults_are_the_reset_values() {
    assert_eq!(Config0::default().to_bits(), Register::Config0.reset_value());
    assert_eq!(Config1::default().to_bits(), Register::Config1.reset_value());
    assert_eq!(Sysred::default().to_bits(), Register::Sysred.reset_value());
    let reset_values: Vec<u8> = Register::ALL.iter().take(9).map(|register| register.reset_value()).collect();
    assert_eq!(Config::default().registers().unwrap()[..], reset_values);
}

/// Every combination of the fields that go into CONFIG0 and CONFIG1, with every set of internal readings.
#[test]
fn every_configuration_comes_out_of_its_registers_again() {
    let mut valid = 0;
    for config0_bits in (0..0x80_u8).step_by(4) {
        for config1 in (0..=0xFF).filter_map(Config1::from_bits) {
            for internal in (0..=0xFF).filter_map(Sysred::from_bits) {
                let config0 = Config0::from_bits(config0_bits).unwrap();
                let (mux, expected_mux) = if config0.muxmod {
                    (Mux::Fixed { ainp: 0xC, ainn: 0x3 }, [0xC3, 0, 0, 0, 0])
                } else {
                    let mux = Mux::AutoScan { differential: 0x81, single: 0xA53C, internal };
                    (mux, [0, 0x81, 0x3C, 0xA5, internal.to_bits()])
                };
                let config = Config {
                    mux,
                    data_rate: config1.drate,
                    delay: config1.dly,
                    chop: config0.chop,
                    idle_mode: config1.idlmod,
                    sensor_bias: config1.sbcs,
                    bypass: config0.bypas,
                    clock_output: config0.clkenb,
                    short_spi_timeout: config0.spirst,
                    gpio_inputs: 0x0F,
                    gpio_levels: 0x70,
                    ..Config::default()
                };
                let forbidden = config.chop && !config0.muxmod && internal.to_bits() & 0b11_1100 != 0;
                match config.registers() {
                    Ok(image) => {
                        assert!(!forbidden, "{config:?}");
                        // The status byte is always on.
                        assert_eq!(Config0::from_bits(image[0]), Some(Config0 { stat: true, ..config0 }));
                        assert_eq!(Config1::from_bits(image[1]), Some(config1));
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
    // 32 CONFIG0 x 192 CONFIG1 x 32 SYSRED, minus CHOP in auto-scan (8 of 32) with 30 of the 32 SYSRED.
    assert_eq!(valid, 192 * (32 * 32 - 8 * 30));
}

#[test]
fn what_the_chip_cannot_do_is_refused() {
    let refused = |config: Config| config.registers().unwrap_err();
    for clock_hz in [0, CLOCK_MIN_HZ - 1, CLOCK_MAX_HZ + 1, u32::MAX] {
        assert_eq!(refused(Config { clock_hz, ..Config::default() }), ConfigError::Clock { clock_hz });
    }
    for clock_hz in [CLOCK_MIN_HZ, CLOCK_MAX_HZ] {
        assert_eq!(Config { clock_hz, ..Config::default() }.validate(), Ok(()));
    }
    let mux = Mux::AutoScan { differential: 0, single: 0, internal: Sysred::NONE };
    assert_eq!(refused(Config { mux, ..Config::default() }), ConfigError::EmptyScan);
    assert_eq!(refused(Config { chop: true, ..Config::paper_scan() }), ConfigError::ChopWithInternalReadings);
    for ainp in 0..=0xFF_u8 {
        for ainn in 0..=0xFF_u8 {
            let config = Config { mux: Mux::Fixed { ainp, ainn }, ..Config::default() };
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
    let mux = Mux::AutoScan { differential: 0, single: 1, internal: Sysred { offset: true, ..Sysred::NONE } };
    assert_eq!(Config { mux, chop: true, ..Config::default() }.validate(), Ok(()));
}
