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
// `!(a > b)` is intended: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod boot;
pub mod command;
pub mod crash;
pub mod division;
pub mod fault;
mod frame;
pub mod framing;
pub mod odometry;
pub mod plan;
pub mod scan;
pub mod settings;
pub mod store;
pub mod telemetry;
