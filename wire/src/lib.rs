//! What the firmware and a PC say to each other, and what the firmware keeps over a reset.
//!
//! A crate of its own because it is compiled for the least size: what is written and read field by field, and not often,
//! takes half the flash so. The crate `ridgetone` re-exports these modules under their own names.
#![no_std]
// A panic resets the finger: only tests may.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented
    )
)]
#![forbid(unsafe_code)]
// `!(a > b)` is meant where it stands: a NaN belongs on that side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod boot;
pub mod command;
pub mod crash;
pub mod fault;
pub mod profile;
pub mod store;
pub mod telemetry;
pub mod wire;

pub use ridgetone_hot::settings;
