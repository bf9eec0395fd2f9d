//! Ridgetone: the tone of the ridges under a robotic fingertip, measured on the chip.
#![no_std]
#![forbid(unsafe_code)]

pub mod bridge;
pub mod contact;
pub mod frame;
pub mod moments;
pub mod motion;
pub mod normal;
pub mod phase;
pub mod pipeline;
pub mod settings;
pub mod sine_fit;
pub mod spectrum;
pub mod telemetry;
pub mod window;
