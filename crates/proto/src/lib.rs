#![doc = include_str!("../README.md")]
#![no_std]
// A panic resets the finger, so only tests may panic.
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]
#![cfg_attr(
    not(test),
    deny(clippy::unreachable, clippy::todo, clippy::unimplemented)
)]
#![forbid(unsafe_code)]
// `!(a > b)` is intended, so that a NaN takes this branch.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

/// Version of the firmware and of all its crates: major, minor, patch.
pub const VERSION: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn number(text: &str) -> u8 {
    let (mut digits, mut number) = (text.as_bytes(), 0);
    while let [digit, others @ ..] = digits {
        number = 10 * number + (*digit - b'0');
        digits = others;
    }
    number
}

pub mod boot;
pub mod command;
pub mod crash;
pub mod division;
pub mod fault;
mod frame;
pub mod framing;
pub mod plan;
pub mod scan;
pub mod settings;
pub mod store;
pub mod telemetry;
