#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod board;
pub mod chip;
mod file_error;
mod flash;
pub mod half_plane;
mod printable;
mod random;
pub mod scene;
pub mod scene_file;
pub mod sliding;
pub mod stm32_adc;
mod text_file;
pub mod trace;

pub use self::{
    board::SimulatedBoard,
    chip::{Ads1258, Analog, Counters, Fault, Injected, Injection, Options},
    file_error::FileError,
    flash::CutFlash,
    printable::{escaped, printable},
    scene::{Constant, Noisy, Repeated, Scene},
    scene_file::{load_scene, parse_scene},
    sliding::{
        Finger, Hand, ParameterError, SkinState, Sliding, SlidingScene, Stimulator, TABLE_2, Truth,
    },
    stm32_adc::{Amplifier, Stm32Adc},
    text_file::short_text,
    trace::{Trace, TraceFrame, write_csv},
};
