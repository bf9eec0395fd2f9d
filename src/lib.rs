//! Ridgetone: the tone of the ridges under a robotic fingertip, measured on the chip.
#![no_std]
#![forbid(unsafe_code)]

pub mod bridge;
pub mod frame;
pub mod pipeline;
pub mod settings;
pub mod telemetry;
pub mod window;
