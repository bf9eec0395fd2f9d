//! Tests the chip through embedded-hal.
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::{Operation, SpiDevice};
use hal_mock::{Constant, Options, SimulatedBoard, Sliding, SlidingScene};

fn board(end_s: f64) -> SimulatedBoard {
    let options = Options {
        noise: false,
        poison: Some(0xA5),
        ..Options::default()
    };
    SimulatedBoard::new(
        Constant {
            volts: [1.0; 16],
            end_s,
        },
        options,
    )
}

#[test]
fn all_operations_of_a_transaction_are_one_frame() {
    let board = board(1.0);
    let mut spi = board.spi();
    let (mut id, mut same) = ([0u8; 1], [0x41u8, 0]);
    let mut both = [0u8; 3];
    spi.transaction(&mut [
        Operation::Write(&[0x49]),
        Operation::Read(&mut id),
        Operation::DelayNs(1000),
        Operation::TransferInPlace(&mut same),
        Operation::Transfer(&mut both, &[0x44]),
    ])
    .unwrap();
    assert_eq!((id, same), ([0x8B], [0xA5, 0x83]));
    assert_eq!(both, [0xA5, 0xFF, 0xA5]);
    assert_eq!(board.now_ns(), 1000);
    spi.write(&[0x49]).unwrap();
    spi.read(&mut id).unwrap();
    assert_eq!(
        id,
        [0x00],
        "a new frame: no register, but data that are not there yet"
    );
}

#[test]
fn a_driver_that_reads_with_ones_on_din_gets_what_the_chip_gives() {
    let board = board(1.0);
    board.set_read_fill(0xFF);
    let mut bytes = [0; 2];
    board
        .spi()
        .transaction(&mut [Operation::Write(&[0x58]), Operation::Read(&mut bytes)])
        .unwrap();
    assert_eq!(bytes, [0x00, 0x8B]);
}

#[test]
fn bytes_take_the_time_of_sclk() {
    let board = board(1.0);
    board.set_sclk_hz(1_000_000);
    board.spi().write(&[0x70, 0x02, 0x31]).unwrap();
    assert_eq!(board.now_ns(), 24_000);
    board.delay().delay_us(6);
    assert_eq!(board.now_ns(), 30_000);
}

#[test]
fn a_slow_frame_and_a_short_time_out_do_not_go_together() {
    let board = board(1.0);
    board.spi().write(&[0x60, 0x42]).unwrap(); // SPIRST = 1: 256 cycles are 16.3 us
    let mut byte = [0u8];
    let mut frame = |pause_ns| {
        let mut operations = [
            Operation::Write(&[0x40]),
            Operation::DelayNs(pause_ns),
            Operation::Read(&mut byte),
        ];
        board.spi().transaction(&mut operations).unwrap();
        byte[0]
    };
    assert_eq!(frame(16_000), 0x42);
    assert_eq!(
        frame(17_000),
        0x00,
        "reset in the middle: the zero byte is a direct read"
    );
}

#[test]
fn waiting_moves_time_from_edge_to_edge_until_the_scene_ends() {
    let board = board(0.01);
    assert_eq!(board.wait_for_drdy(), None, "idle");
    board.delay().delay_ms(3);
    board.start_pin().set_high().unwrap();
    let mut drdy = board.drdy_pin();
    let mut edges = 0;
    while let Some(edge_ns) = board.wait_for_drdy() {
        assert_eq!(board.now_ns(), edge_ns);
        assert!(drdy.is_low().unwrap());
        let mut bytes = [0u8; 4];
        board.spi().read(&mut bytes).unwrap();
        assert_eq!(bytes[0] & 0x80, 0x80);
        assert!(drdy.is_high().unwrap());
        edges += 1;
    }
    // The first edge is at 708 cycles, then one every 674, the last at or after 10 ms = 157286.4
    // cycles.
    assert_eq!(edges, 1 + (157_287 - 708_u32).div_ceil(674));
    board.with_chip(|chip| {
        let c = chip.counters();
        assert_eq!(
            (c.conversions, c.read, c.lost),
            (u64::from(edges), u64::from(edges), 0)
        );
    });
}

#[test]
fn polling_drdy_lets_time_pass_if_set_so() {
    let board = board(1.0);
    board.set_poll_ns(500);
    board.start_pin().set_high().unwrap();
    let mut drdy = board.drdy_pin();
    while drdy.is_high().unwrap() {}
    assert!(board.now_ns() >= 45_013 && board.now_ns() < 46_100);
}

#[test]
fn the_reset_pin_resets() {
    let board = board(1.0);
    board.spi().write(&[0x61, 0x31]).unwrap();
    let mut reset = board.reset_pin();
    reset.set_low().unwrap();
    reset.set_high().unwrap();
    assert_eq!(board.with_chip(|chip| chip.registers()[1]), 0x83);
}

#[test]
fn a_run_repeats_bit_for_bit_whatever_the_start_up_took() {
    let run = |start_up_us| {
        let board = SimulatedBoard::new(
            SlidingScene::new(Sliding::default()).unwrap(),
            Options::default(),
        );
        board.delay().delay_us(start_up_us);
        board
            .spi()
            .write(&[0x70, 0x02, 0x31, 0x00, 0x00, 0xFF, 0xFF, 0x3D])
            .unwrap();
        let zero_ns = board.now_ns();
        board.start_pin().set_high().unwrap();
        let mut all = Vec::new();
        while let Some(edge_ns) = board.wait_for_drdy() {
            let mut bytes = [0x30, 0, 0, 0, 0];
            board.spi().transfer_in_place(&mut bytes).unwrap();
            all.push((
                edge_ns - zero_ns,
                u32::from_be_bytes([bytes[1], bytes[2], bytes[3], bytes[4]]),
            ));
        }
        all
    };
    let once = run(0);
    // 5.01 s of the default scene: one conversion every 3106 cycles after the first at 2628, the
    // last at or after the end.
    assert_eq!(once.len(), 25_371);
    assert!(once == run(0));
    assert!(once == run(16_777));
}
