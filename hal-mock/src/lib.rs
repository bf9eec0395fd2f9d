#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod board;
pub mod chip;
mod file_error;
#[cfg(feature = "scenes")]
mod flash;
#[cfg(feature = "scenes")]
pub mod half_plane;
mod printable;
mod random;
pub mod scene;
#[cfg(feature = "scenes")]
pub mod scene_file;
#[cfg(feature = "scenes")]
pub mod sliding;
pub mod stm32_adc;
#[cfg(feature = "scenes")]
mod text_file;
pub mod trace;

pub use self::{
    board::SimulatedBoard,
    chip::{Ads1258, Analog, Counters, Fault, Injected, Injection, Options},
    file_error::FileError,
    printable::{escaped, printable},
    scene::{Constant, Noisy, Repeated, Scene},
    stm32_adc::{Amplifier, Stm32Adc},
    trace::{Trace, TraceFrame, write_csv},
};
#[cfg(feature = "scenes")]
pub use self::{
    flash::CutFlash,
    scene_file::{load_scene, parse_scene},
    sliding::{
        Finger, Hand, ParameterError, SkinState, Sliding, SlidingScene, Stimulator, TABLE_2, Truth,
    },
    text_file::short_text,
};
