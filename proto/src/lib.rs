//! What a Ridgetone finger and a PC send each other, and what the finger keeps over a reset.
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
pub mod framing;
pub mod profile;
pub mod scan;
pub mod settings;
pub mod store;
pub mod telemetry;
mod text_form;
