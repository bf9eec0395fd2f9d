//! A chip with constant inputs and no noise, and the byte sequences of the tests.
#![allow(dead_code, reason = "every test file takes what it needs")]

use hal_mock::{Ads1258, Constant, Options};

/// Creates a chip with n / 10 volts at AINn, without noise, with poison A5h.
pub fn chip(change: impl FnOnce(&mut Options)) -> Ads1258 {
    let mut options = Options {
        noise: false,
        poison: Some(0xA5),
        ..Options::default()
    };
    change(&mut options);
    let volts = std::array::from_fn(|n| n as f64 / 10.0);
    Ads1258::new(
        Box::new(Constant {
            volts,
            end_s: f64::INFINITY,
        }),
        options,
    )
}

/// The chip of [`chip`] with START high from time zero.
pub fn started() -> Ads1258 {
    let mut chip = chip(|_| ());
    chip.set_start(0, true);
    chip
}

pub fn write(chip: &mut Ads1258, now_ns: u64, address: u8, values: &[u8]) {
    let mut bytes = vec![0x70 | address];
    bytes.extend_from_slice(values);
    chip.transfer(now_ns, &mut bytes);
}

pub fn read(chip: &mut Ads1258, now_ns: u64) -> (u8, i32) {
    let mut bytes = [0x30, 0, 0, 0, 0];
    chip.transfer(now_ns, &mut bytes);
    (bytes[1], code([bytes[2], bytes[3], bytes[4]]))
}

pub fn code([high, mid, low]: [u8; 3]) -> i32 {
    i32::from_be_bytes([high, mid, low, 0]) >> 8
}

/// Moves to the next DRDY edge and reads by command. Returns the edge's time, status and code.
pub fn next(chip: &mut Ads1258) -> (u64, u8, i32) {
    let edge_ns = chip.next_drdy_fall_ns().expect("converting");
    let (status, code) = read(chip, edge_ns);
    (edge_ns, status, code)
}
