//! Tests the driver against the simulated chip, which has its own register map and rate formula.

use ads1258::{
    Ads1258, Channel, Config, Conversion, DataRate, Delay, Error, Mux, POWER_UP_TICKS, Register,
    Status, Sysred, reading,
};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::InputPin;
use hal_mock::board::ChipSpi;
use hal_mock::{Analog, Constant, Fault, Options, SimulatedBoard};

mod common;
use common::SCAN;

const REFERENCE_V: f64 = 4.096;

/// Applies a different voltage to every input, all well within the range.
fn scene() -> Constant {
    Constant {
        volts: std::array::from_fn(|input| 0.2 * input as f64 - 1.4),
        ..Constant::default()
    }
}

fn ideal_code(input: u8) -> i32 {
    (scene().volts[usize::from(input)] / REFERENCE_V * f64::from(reading::CODES_PER_VREF)).round()
        as i32
}

/// Switches the noise off, so that codes can be compared.
fn options() -> Options {
    options_with(|_| ())
}

fn options_with(change: impl FnOnce(&mut Options)) -> Options {
    let mut options = Options {
        noise: false,
        ..Options::default()
    };
    change(&mut options);
    options
}

fn bench(options: Options) -> (SimulatedBoard, Ads1258<ChipSpi>) {
    let board = SimulatedBoard::new(scene(), options);
    board.set_sclk_hz(4_000_000);
    let adc = Ads1258::new(board.spi());
    (board, adc)
}

/// Returns a chip that was reset, configured and started, as by an application.
fn scanning(config: &Config, options: Options) -> (SimulatedBoard, Ads1258<ChipSpi>) {
    let (board, mut adc) = bench(options);
    adc.stop(&mut board.start_pin()).unwrap();
    adc.reset().unwrap();
    adc.configure(config).unwrap();
    adc.start(&mut board.start_pin()).unwrap();
    (board, adc)
}

fn next(board: &SimulatedBoard, adc: &mut Ads1258<ChipSpi>) -> Conversion {
    board.wait_for_drdy().unwrap();
    adc.read().unwrap()
}

#[test]
fn reset_configure_and_verify() {
    let (board, mut adc) = bench(options());
    assert_eq!(adc.read_id(), Ok(0x8B));
    adc.verify().unwrap(); // the chip must start with the driver's reset values
    adc.configure(&SCAN).unwrap();
    adc.verify().unwrap();
    assert!(Ads1258::new(board.spi()).verify().is_err());

    adc.reset().unwrap();
    adc.verify().unwrap();
    Ads1258::new(board.spi()).verify().unwrap();

    adc.configure(&SCAN).unwrap();
    adc.reset_by_pin(&mut board.reset_pin(), &mut board.delay())
        .unwrap();
    adc.verify().unwrap();
    Ads1258::new(board.spi()).verify().unwrap();

    let mut values = [0; 10];
    adc.read_registers(Register::Config0, &mut values).unwrap();
    assert_eq!(values, Register::RESET_VALUES);
}

#[test]
fn single_and_multiple_access_agree() {
    let (_rig, mut adc) = bench(options());
    adc.write_register(Register::Muxsg1, 0x5A).unwrap();
    adc.write_registers(Register::Muxsch, &[0x12, 0x34, 0x56])
        .unwrap();
    let mut values = [0; 4];
    adc.read_registers(Register::Muxsch, &mut values).unwrap();
    assert_eq!(values, [0x12, 0x34, 0x56, 0x5A]);
    assert_eq!(adc.read_register(Register::Muxsg0), Ok(0x56));
}

#[test]
fn an_ads1158_is_refused() {
    let (_board, mut adc) = bench(options_with(|options| options.id = 0x9B));
    assert_eq!(adc.read_id(), Err(Error::Id { read: 0x9B }));
}

#[test]
fn a_chip_that_is_still_powering_up_is_noticed() {
    let power_up_cycles = u64::from(POWER_UP_TICKS);
    let (board, mut adc) = bench(options_with(|options| {
        options.power_up_cycles = power_up_cycles
    }));
    assert!(matches!(adc.configure(&SCAN), Err(Error::Verify { .. })));
    board.delay().delay_ms(17);
    adc.configure(&SCAN).unwrap();
}

#[test]
fn scans_arrive_in_ascending_channel_ids_with_the_right_codes() {
    let config = SCAN;
    let (board, mut adc) = scanning(&config, options());
    for _ in 0..3 {
        for expected in config.scan() {
            board.wait_for_drdy().unwrap();
            assert_eq!(board.drdy_pin().is_low(), Ok(true));
            let conversion = adc.read().unwrap();
            assert_eq!(board.drdy_pin().is_low(), Ok(false));
            assert_eq!(conversion.status.channel(), Some(expected));
            // NEW is set, OVF and SUPPLY are not.
            assert_eq!(conversion.status, Status(0x80 | expected.id()));
            let code = match expected {
                Channel::Single(input) => ideal_code(input),
                Channel::Offset => 0,
                Channel::Vcc => 5 * reading::CODES_PER_SUPPLY_VOLT,
                Channel::Temp => {
                    (0.168 / REFERENCE_V * f64::from(reading::CODES_PER_VREF)).round() as i32
                }
                Channel::Gain => reading::CODES_PER_VREF,
                Channel::Ref => {
                    (REFERENCE_V * f64::from(reading::CODES_PER_SUPPLY_VOLT)).round() as i32
                }
                Channel::Differential(_) => unreachable!(),
            };
            assert_eq!(conversion.code, code, "{expected}");
        }
    }
    assert_eq!(board.with_chip(|chip| chip.counters().odd_commands), 0);
}

#[test]
fn a_mixed_scan_follows_next_channel() {
    let mux = Mux::AutoScan {
        differential: 0b1000_0001,
        single: 0x8101,
        internal: Sysred::ALL,
    };
    let config = Config { mux, ..SCAN };
    let (board, mut adc) = scanning(&config, options());
    let mut expected = Channel::Differential(0);
    for _ in 0..30 {
        let conversion = next(&board, &mut adc);
        assert_eq!(conversion.status.channel(), Some(expected));
        if let Channel::Differential(pair) = expected {
            // Neighbouring inputs are 0.2 V apart.
            let input_v = reading::volts(conversion.code, REFERENCE_V as f32);
            assert!((input_v + 0.2).abs() < 1e-6, "DIFF{pair}: {input_v} V");
        }
        expected = config.next_channel(expected);
    }
}

#[test]
fn a_second_read_gives_the_same_data_with_new_cleared() {
    let (board, mut adc) = scanning(&SCAN, options());
    let first = next(&board, &mut adc);
    let second = adc.read().unwrap();
    assert!(first.status.is_new());
    assert!(!second.status.is_new());
    assert_eq!(second.code, first.code);
    assert_eq!(second.status.channel(), first.status.channel());
    assert!(next(&board, &mut adc).status.is_new());
}

#[test]
fn a_read_across_the_end_of_a_conversion_is_not_torn() {
    let (board, mut adc) = scanning(&SCAN, options());
    for lead_ns in (0..12_000_u64).step_by(100) {
        // Begin the read, which takes 10 us, `lead_ns` before the next edge.
        let edge_ns = board.wait_for_drdy().unwrap();
        let period_ns = board.with_chip(|chip| chip.conversion_period_ns());
        let fresh = adc.read().unwrap();
        board.advance_ns(edge_ns + period_ns - lead_ns - board.now_ns());
        let conversion = adc.read().unwrap();
        // Either the old result or the next one, but never a mixture.
        let Some(Channel::Single(input)) = conversion.status.channel() else {
            continue;
        };
        assert_eq!(conversion.code, ideal_code(input));
        assert_eq!(
            conversion.status.is_new(),
            conversion.status.channel() != fresh.status.channel()
        );
    }
}

#[test]
fn an_overflow_is_flagged_and_the_code_clips() {
    let mut scene = scene();
    scene.volts[3] = 1.2 * REFERENCE_V;
    scene.volts[5] = -1.2 * REFERENCE_V;
    let board = SimulatedBoard::new(scene, options());
    let mut adc = Ads1258::new(board.spi());
    adc.configure(&SCAN).unwrap();
    adc.start(&mut board.start_pin()).unwrap();
    for channel in SCAN.scan() {
        let conversion = next(&board, &mut adc);
        let overloaded = matches!(channel, Channel::Single(3 | 5));
        assert_eq!(conversion.status.is_overflow(), overloaded, "{channel}");
        match channel {
            Channel::Single(3) => assert_eq!(conversion.code, 0x7F_FFFF),
            Channel::Single(5) => assert_eq!(conversion.code, -0x80_0000),
            _ => {}
        }
    }
}

#[test]
fn a_low_supply_is_flagged() {
    let (board, mut adc) = scanning(&SCAN, options());
    board.with_chip(|chip| chip.analog_mut().avdd_v = 4.0);
    assert!(next(&board, &mut adc).status.is_supply_low());
    board.with_chip(|chip| chip.analog_mut().avdd_v = 5.0);
    assert!(!next(&board, &mut adc).status.is_supply_low());
}

#[test]
fn internal_readings_show_the_chip_and_its_surroundings() {
    let analog = Analog {
        reference_v: 2.5,
        avdd_v: 5.1,
        temperature_c: 61.5,
        offset_v: 40e-6,
        gain: 1.001,
        ..Analog::default()
    };
    let (board, mut adc) = scanning(&SCAN, options_with(|options| options.analog = analog));
    for channel in SCAN.scan() {
        let code = next(&board, &mut adc).code;
        let (found, expected, tolerance) = match channel {
            Channel::Offset => (reading::offset_v(code, 2.5), 40e-6, 2e-7),
            Channel::Vcc => (reading::supply_v(code), 5.1, 1e-5),
            Channel::Ref => (reading::reference_v(code), 2.5, 1e-5),
            // The gain reading includes the converter's offset, which is 16 millionths of VREF.
            Channel::Gain => (reading::gain(code), 1.001, 2e-5),
            Channel::Temp => (reading::temperature_c(code, 2.5), 61.5, 1e-2),
            _ => continue,
        };
        assert!(
            (found - expected).abs() < tolerance,
            "{channel}: {found} is not {expected}"
        );
    }
}

#[test]
fn registers_that_change_by_themselves_are_found_while_scanning() {
    let config = Config {
        gpio_inputs: 0x7F,
        ..SCAN
    };
    let image = config.registers().unwrap();
    for register in Register::ALL.into_iter().take(9) {
        for mask in [0x80, 0x08] {
            let (board, mut adc) = scanning(&config, options());
            board.wait_for_drdy().unwrap();
            adc.verify().unwrap();
            let address = register as u8;
            board.with_chip(|chip| chip.begin_fault(Fault::RegisterFlip { address, mask }));
            let (wrote, read) = (image[register as usize], image[register as usize] ^ mask);
            let expected = match register {
                // The driver ignores the level at an input pin.
                Register::Gpiod if mask == 0x08 => Ok(()),
                _ => Err(Error::Verify {
                    register,
                    wrote,
                    read,
                }),
            };
            assert_eq!(adc.verify(), expected);

            // Only a reset restores reserved bits.
            adc.stop(&mut board.start_pin()).unwrap();
            adc.reset().unwrap();
            adc.configure(&config).unwrap();
            adc.start(&mut board.start_pin()).unwrap();
            adc.verify().unwrap();
        }
    }
}

#[test]
fn verifying_disturbs_no_conversion() {
    let config = SCAN;
    let (board, mut adc) = scanning(&config, options());
    for expected in config.scan().chain(config.scan()) {
        let conversion = next(&board, &mut adc);
        assert_eq!(conversion.status, Status(0x80 | expected.id()));
        adc.verify().unwrap();
    }
    assert_eq!(board.with_chip(|chip| chip.counters().lost), 0);
}

#[test]
fn levels_on_input_pins_do_not_disturb_verification() {
    let config = Config {
        gpio_inputs: 0xF0,
        gpio_levels: 0x06,
        ..SCAN
    };
    let (board, mut adc) = bench(options());
    board.with_chip(|chip| chip.set_gpio_inputs(0xA9));
    adc.configure(&config).unwrap();
    assert_eq!(adc.read_register(Register::Gpiod), Ok(0xA6));
}

#[test]
fn pulses_convert_one_channel_each() {
    let config = SCAN;
    let (board, mut adc) = bench(options());
    adc.configure(&config).unwrap();
    for expected in config.scan() {
        assert_eq!(board.wait_for_drdy(), None);
        adc.pulse_convert().unwrap();
        assert_eq!(next(&board, &mut adc).status, Status(0x80 | expected.id()));
    }
}

#[test]
fn a_stop_finishes_the_running_conversion() {
    let (board, mut adc) = scanning(&SCAN, options());
    board.wait_for_drdy().unwrap();
    adc.stop(&mut board.start_pin()).unwrap();
    assert!(board.wait_for_drdy().is_some());
    assert!(board.wait_for_drdy().is_none());

    // The reset command also lets the conversion finish, but the pin does not.
    adc.start(&mut board.start_pin()).unwrap();
    adc.stop(&mut board.start_pin()).unwrap();
    adc.reset().unwrap();
    assert!(board.wait_for_drdy().is_some());
    adc.start(&mut board.start_pin()).unwrap();
    adc.stop(&mut board.start_pin()).unwrap();
    adc.reset_by_pin(&mut board.reset_pin(), &mut board.delay())
        .unwrap();
    assert!(board.wait_for_drdy().is_none());
}

#[test]
fn a_fixed_channel_measures_its_pair() {
    let config = Config {
        mux: Mux::Fixed { ainp: 12, ainn: 5 },
        ..Config::default()
    };
    let (board, mut adc) = scanning(&config, options());
    for _ in 0..3 {
        let input_v = reading::volts(next(&board, &mut adc).code, REFERENCE_V as f32);
        assert!((input_v - 1.4).abs() < 1e-6);
    }
}

#[test]
fn the_chip_takes_the_time_that_the_rates_say() {
    let inputs = Mux::AutoScan {
        differential: 0,
        single: 0xFFFF,
        internal: Sysred::NONE,
    };
    let configs = [inputs, Mux::Fixed { ainp: 0, ainn: 1 }]
        .into_iter()
        .flat_map(|mux| {
            DataRate::ALL.into_iter().flat_map(move |data_rate| {
                Delay::ALL.into_iter().flat_map(move |delay| {
                    [false, true].map(|chop| Config {
                        mux,
                        data_rate,
                        delay,
                        chop,
                        ..Config::RESET
                    })
                })
            })
        });
    for config in configs {
        let (board, _adc) = scanning(&config, options());
        let first_ns = board.wait_for_drdy().unwrap();
        let last_ns = (0..32).fold(first_ns, |_, _| board.wait_for_drdy().unwrap());
        let expected_ns = f64::from(config.conversion_ticks()) / f64::from(config.clock_hz) * 1e9;
        let found_ns = (last_ns - first_ns) as f64 / 32.0;
        assert!(
            (found_ns - expected_ns).abs() < 0.1,
            "{config:?}: {found_ns} is not {expected_ns} ns"
        );
    }
}

#[test]
fn a_garbled_channel_id_is_no_channel() {
    let (board, mut adc) = scanning(&SCAN, options());
    board.wait_for_drdy().unwrap();
    // A bit error in the byte after the command changes AIN0, 0x08, to 0x19.
    let fault = Fault::DoutFlip {
        bytes_ahead: 1,
        mask: 0x11,
    };
    board.with_chip(|chip| chip.begin_fault(fault));
    let conversion = adc.read().unwrap();
    assert_eq!(conversion.status.channel(), None);
    assert_eq!(conversion.code, ideal_code(0));
}

type Change<T> = fn(&mut T);

#[test]
fn nothing_relies_on_what_the_datasheet_leaves_open() {
    let variants: [Change<Options>; 7] = [
        |options| options.poison = Some(0x00),
        |options| options.poison = Some(0xFF),
        |options| options.poison = Some(0x88),
        |options| options.first_conversion_with_delay = true,
        |options| options.sleep_wake_cycles = 100_000,
        |options| options.id = 0x00,
        |options| options.id = 0xEF,
    ];
    for variant in variants {
        let (board, mut adc) = scanning(&SCAN, options_with(variant));
        for expected in SCAN.scan() {
            let conversion = next(&board, &mut adc);
            assert_eq!(conversion.status, Status(0x80 | expected.id()));
            if let Channel::Single(input) = expected {
                assert_eq!(conversion.code, ideal_code(input));
            }
        }
        adc.stop(&mut board.start_pin()).unwrap();
        adc.read_id().unwrap();
        adc.verify().unwrap();
    }
}

/// If the interface's time-out counts from a frame's start, a slow SCLK cuts frames, but SCLK from
/// [`Config::sclk_min_hz`] does not.
#[test]
fn from_the_least_sclk_on_no_frame_is_cut() {
    let min_hz = SCAN.sclk_min_hz();
    assert_eq!(min_hz, 337_920, "88 bits of 15.72864 MHz / 4096");
    for (sclk_hz, from_start, works) in [
        (min_hz, true, true),
        (min_hz - min_hz / 10, true, false),
        (6_400, true, false),
        (6_400, false, true),
    ] {
        let (board, mut adc) = bench(options_with(|options| {
            options.timeout_from_frame_start = from_start
        }));
        board.set_sclk_hz(sclk_hz);
        let mut all = [0; 10];
        let is_read = adc.configure(&SCAN).is_ok()
            && adc.read_registers(Register::Config0, &mut all).is_ok()
            && all[9] == 0x8B;
        assert_eq!(is_read, works, "{sclk_hz} Hz, from the start: {from_start}");
    }
}

/// Waits for DRDY and reads each conversion of two scans once, in order.
#[test]
fn the_next_conversion_is_waited_for_and_read() {
    let (board, mut adc) = scanning(&SCAN, options());
    let mut drdy = board.drdy_pin();
    for expected in SCAN.scan().chain(SCAN.scan()) {
        let read = embassy_futures::block_on(adc.read_next_async(&mut drdy)).unwrap();
        assert_eq!(read.status, Status(0x80 | expected.id()));
    }
    assert_eq!(board.with_chip(|chip| chip.counters().lost), 0);
}
