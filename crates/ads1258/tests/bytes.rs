//! Tests every method, byte for byte, against scripted SPI transactions.

use ads1258::{
    Ads1258, Channel, Config, ConfigError, Conversion, Error, Model, Mux, RESET_LOW_US, Register,
    SettledCs, Status,
};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, Phase, Polarity, SpiDevice};
use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as DelayTransaction};
use embedded_hal_mock::eh1::digital::{Mock as PinMock, State, Transaction as PinTransaction};
use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as SpiTransaction};

mod common;
use common::SCAN;

/// Registers of [`SCAN`], derived by hand from the register map.
const IMAGE: [u8; 9] = [0x0A, 0x31, 0x00, 0x00, 0xFF, 0xFF, 0x3D, 0xFF, 0x00];

/// Byte on DOUT during a command byte, which the driver must ignore.
const POISON: u8 = 0xEE;

fn writing(bytes: &[u8]) -> Vec<SpiTransaction<u8>> {
    vec![
        SpiTransaction::transaction_start(),
        SpiTransaction::write_vec(bytes.to_vec()),
        SpiTransaction::transaction_end(),
    ]
}

fn reading(command: u8, answer: &[u8]) -> Vec<SpiTransaction<u8>> {
    let mut sent = vec![command];
    sent.resize(answer.len() + 1, 0);
    let received = [&[POISON], answer].concat();
    vec![
        SpiTransaction::transaction_start(),
        SpiTransaction::transfer_in_place(sent, received),
        SpiTransaction::transaction_end(),
    ]
}

fn writing_all(image: &[u8; 9]) -> Vec<SpiTransaction<u8>> {
    writing(&[&[0x70][..], image].concat())
}

fn verify_error<T>(register: Register, wrote: u8, read: u8) -> Result<(), Error<T>> {
    Err(Error::Verify {
        register,
        wrote,
        read,
    })
}

/// Calls `call` with a driver whose bus expects exactly these transactions.
fn expect<T>(
    script: &[Vec<SpiTransaction<u8>>],
    call: impl FnOnce(&mut Ads1258<SpiMock<u8>>) -> T,
) -> T {
    let mut adc = Ads1258::new(SpiMock::new(&script.concat()));
    let result = call(&mut adc);
    adc.destroy().done();
    result
}

#[test]
fn the_bus_is_in_mode_0() {
    assert_eq!(ads1258::MODE.polarity, Polarity::IdleLow);
    assert_eq!(ads1258::MODE.phase, Phase::CaptureOnFirstTransition);
}

#[test]
fn reset_and_pulse_convert_are_one_byte_each() {
    expect(&[writing(&[0xC0])], |adc| adc.reset()).unwrap();
    expect(&[writing(&[0x80])], |adc| adc.pulse_convert()).unwrap();
}

#[test]
fn single_registers() {
    for register in Register::ALL {
        let address = register as u8;
        let script = [reading(0x40 | address, &[0x5A])];
        assert_eq!(expect(&script, |adc| adc.read_register(register)), Ok(0x5A));
        if register != Register::Id {
            let script = [writing(&[0x60 | address, 0xA5])];
            expect(&script, |adc| adc.write_register(register, 0xA5)).unwrap();
        }
    }
}

#[test]
fn several_registers() {
    let all = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    for (first, answer) in [
        (Register::Config0, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9][..]),
        (Register::Muxsg0, &[0x12, 0x34]),
    ] {
        let mut values = vec![0; answer.len()];
        let script = [reading(0x50 | first as u8, answer)];
        expect(&script, |adc| adc.read_registers(first, &mut values)).unwrap();
        assert_eq!(values, answer);
    }
    for (first, values) in [
        (Register::Config0, &all[..]),
        (Register::Gpioc, &[0xF0, 0x0A]),
    ] {
        let script = [writing(&[&[0x70 | first as u8][..], values].concat())];
        expect(&script, |adc| adc.write_registers(first, values)).unwrap();
    }
}

#[test]
fn ranges_off_the_map_transfer_nothing() {
    for first in Register::ALL {
        let places = 10 - first as usize;
        for count in [0, places + 1, 11, 12, 300] {
            let expected = Err(Error::RegisterRange { first, count });
            let read = expect(&[], |adc| adc.read_registers(first, &mut vec![0; count]));
            assert_eq!(read, expected);
            let written = expect(&[], |adc| adc.write_registers(first, &vec![0; count]));
            assert_eq!(written, expected);
        }
        // The last register, ID, can be read but not written.
        let expected = Err(Error::RegisterRange {
            first,
            count: places,
        });
        let written = expect(&[], |adc| adc.write_registers(first, &vec![0; places]));
        assert_eq!(written, expected);
    }
    let (first, count) = (Register::Id, 1);
    let written = expect(&[], |adc| adc.write_register(first, 0));
    assert_eq!(written, Err(Error::RegisterRange { first, count }));
}

#[test]
fn id_counts_bit_4_only() {
    for id in 0..=0xFF_u8 {
        let is_right = id & 0x10 == 0;
        let expected = if is_right {
            Ok(id)
        } else {
            Err(Error::Id { read: id })
        };
        let found = expect(&[reading(0x49, &[id])], |adc| adc.read_id());
        assert_eq!(found, expected);
    }
}

#[test]
fn every_wrong_bit_is_found_by_configure_and_verify() {
    for (index, register) in Register::ALL.into_iter().take(9).enumerate() {
        for bit in 0..8 {
            let mut found = IMAGE;
            found[index] ^= 1 << bit;
            // All GPIO pins are inputs here, so GPIOD reads external levels.
            let expected = match register {
                Register::Gpiod => Ok(()),
                _ => verify_error(register, IMAGE[index], found[index]),
            };
            let script = [writing_all(&IMAGE), reading(0x50, &found)];
            assert_eq!(expect(&script, |adc| adc.configure(&SCAN)), expected);
            let script = [
                writing_all(&IMAGE),
                reading(0x50, &IMAGE),
                reading(0x50, &found),
            ];
            let verified = expect(&script, |adc| {
                adc.configure(&SCAN).unwrap();
                adc.verify()
            });
            assert_eq!(verified, expected);
        }
    }
}

#[test]
fn output_pins_are_verified_and_input_pins_are_not() {
    let config = Config {
        gpio_inputs: 0xF0,
        gpio_levels: 0x05,
        ..SCAN
    };
    let image = config.registers().unwrap();
    assert_eq!(image[7..], [0xF0, 0x05]);
    for levels in 0..=0xFF_u8 {
        let mut found = image;
        found[8] = levels;
        let expected = match levels & 0x0F {
            0x05 => Ok(()),
            _ => verify_error(Register::Gpiod, 0x05, levels),
        };
        let script = [writing_all(&image), reading(0x50, &found)];
        assert_eq!(expect(&script, |adc| adc.configure(&config)), expected);
    }
}

#[test]
fn verify_knows_the_reset_values_and_every_write() {
    let reset = [0x0A, 0x83, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00];
    let changed = [0x0A, 0x31, 0x00, 0x00, 0xFF, 0x0F, 0x00, 0xFF, 0x00];
    let script = [
        reading(0x50, &reset),
        writing(&[0x61, 0x31]),
        writing(&[0x74, 0xFF, 0x0F]),
        reading(0x50, &changed),
        writing(&[0xC0]),
        reading(0x50, &reset),
    ];
    expect(&script, |adc| {
        adc.verify().unwrap();
        adc.write_register(Register::Config1, 0x31).unwrap();
        adc.write_registers(Register::Muxsg0, &[0xFF, 0x0F])
            .unwrap();
        adc.verify().unwrap();
        adc.reset().unwrap();
        adc.verify().unwrap();
    });
}

#[test]
fn a_bus_without_chip_is_found() {
    for stuck in [0x00, 0xFF] {
        let script = [writing_all(&IMAGE), reading(0x50, &[stuck; 9])];
        let result = expect(&script, |adc| adc.configure(&SCAN));
        assert_eq!(result, verify_error(Register::Config0, 0x0A, stuck));
    }
}

#[test]
fn an_impossible_configuration_transfers_nothing() {
    let config = Config {
        mux: Mux::Fixed { ainp: 16, ainn: 0 },
        ..Config::default()
    };
    let expected = Err(Error::Config(ConfigError::ChannelNumber { number: 16 }));
    assert_eq!(expect(&[], |adc| adc.configure(&config)), expected);
}

#[test]
fn read_is_one_transfer_of_five_bytes() {
    let script = [reading(0x30, &[0x97, 0x80, 0x00, 0x01])];
    let conversion = expect(&script, |adc| adc.read()).unwrap();
    let (status, code) = (Status(0x97), -0x7F_FFFF);
    assert_eq!(conversion, Conversion { status, code });
    assert_eq!(status.channel(), Some(Channel::Single(15)));
}

#[test]
fn the_pins() {
    let (high, low) = (
        PinTransaction::set(State::High),
        PinTransaction::set(State::Low),
    );
    let mut adc = Ads1258::new(SpiMock::<u8>::new(&[]));
    let mut start = PinMock::new(&[high.clone(), low.clone()]);
    adc.start(&mut start).unwrap();
    adc.stop(&mut start).unwrap();
    start.done();

    let mut reset = PinMock::new(&[low, high]);
    let mut delay = CheckedDelay::new(&[DelayTransaction::delay_us(RESET_LOW_US)]);
    adc.reset_by_pin(&mut reset, &mut delay).unwrap();
    reset.done();
    delay.done();
    adc.destroy().done();

    // At least 2 tCLK at the slowest clock.
    const { assert!(RESET_LOW_US >= 2 * 1_000_000 / ads1258::CLOCK_MIN_HZ) }
}

struct Broken;

impl ErrorType for Broken {
    type Error = ErrorKind;
}

impl SpiDevice for Broken {
    fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        Err(ErrorKind::ModeFault)
    }
}

#[test]
fn errors_of_the_bus_are_passed_on() {
    let mut adc = Ads1258::new(Broken);
    let expected = Error::Spi(ErrorKind::ModeFault);
    assert_eq!(adc.reset(), Err(expected));
    assert_eq!(adc.pulse_convert(), Err(expected));
    assert_eq!(adc.configure(&Config::default()), Err(expected));
    assert_eq!(adc.verify(), Err(expected));
    assert_eq!(adc.read(), Err(expected));
    assert_eq!(adc.read_id(), Err(expected));
    assert_eq!(adc.write_register(Register::Gpiod, 0), Err(expected));
    let mut values = [0x77; 3];
    assert_eq!(
        adc.read_registers(Register::Config0, &mut values),
        Err(expected)
    );
    assert_eq!(values, [0x77; 3]);
}

#[test]
fn errors_can_be_shown() {
    let wrong_register = verify_error(Register::Muxsg1, 0xFF, 0x0F).unwrap_err();
    let empty: Error<ErrorKind> = ConfigError::EmptyScan.into();
    assert!(std::error::Error::source(&empty).is_some());
    for (error, expected) in [
        (wrong_register, "MUXSG1 should hold 0xFF, but holds 0x0F"),
        (empty, "configuration: no channel selected for the scan"),
        (Error::Spi(ErrorKind::Overrun), "SPI: Overrun"),
        (Error::Id { read: 0x9B }, "ID is 0x9B: not an ADS1258"),
    ] {
        assert_eq!(error.to_string(), expected);
    }
}

/// The ADS1158 sends 16 bits, returned as the upper 16 of 24. Its bit ID4 is set.
#[test]
fn the_sibling_of_16_bits() {
    let script = [
        reading(0x30, &[0x88, 0xFF, 0xFE]),
        reading(0x49, &[0x9B]),
        reading(0x49, &[0x8B]),
    ];
    let spi = SpiMock::new(&script.concat());
    let mut adc = Ads1258::of_model(spi, Model::Ads1158);
    let conversion = adc.read().unwrap();
    assert_eq!((conversion.status.chid(), conversion.code), (8, -2 << 8));
    // 1 LSB in 16 bits is VREF / 0x7800 (SBAS429D, data format).
    let volts = ads1258::reading::volts(conversion.code, 4.096);
    assert!((volts + 2.0 * 4.096 / 30_720.0).abs() < 1e-9, "{volts}");
    assert_eq!(adc.read_id(), Ok(0x9B));
    let error = adc.read_id().unwrap_err();
    assert_eq!(error.to_string(), "ID is 0x8B: not an ADS1158");
    adc.destroy().done();
}

/// Rounded up from 2.5 periods of 16 MHz (156.25 ns) and half a period of 5.25 MHz (95.2 ns).
#[test]
fn cs_settles_and_rises_half_a_bit_late() {
    let pin = PinMock::new(&[
        PinTransaction::set(State::Low),
        PinTransaction::set(State::High),
    ]);
    let delay = CheckedDelay::new(&[157, 96, 157].map(DelayTransaction::delay_ns));
    let mut cs = SettledCs::new(pin, delay, 16_000_000, 5_250_000);
    cs.set_low().unwrap();
    cs.set_high().unwrap();
    let (mut pin, mut delay) = cs.destroy();
    pin.done();
    delay.done();
}
