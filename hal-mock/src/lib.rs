#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "simulator"), no_std)]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "simulator")]
pub mod board;
pub mod bridge;
#[cfg(feature = "simulator")]
pub mod chip;
#[cfg(feature = "simulator")]
mod file_error;
#[cfg(feature = "simulator")]
mod flash;
#[cfg(feature = "simulator")]
pub mod half_plane;
#[cfg(feature = "simulator")]
mod printable;
#[cfg(feature = "simulator")]
mod random;
#[cfg(feature = "simulator")]
pub mod scene;
#[cfg(feature = "simulator")]
pub mod scene_file;
#[cfg(feature = "simulator")]
pub mod sliding;
#[cfg(feature = "simulator")]
pub mod stm32_adc;
#[cfg(feature = "simulator")]
mod text_file;
#[cfg(feature = "simulator")]
pub mod trace;

#[cfg(feature = "simulator")]
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
    trace::{
        Failure, OpenRows, PROGRESS_ROWS, Playback, RowClock, RowReader, Rows, Table, TimeColumn,
        Timing, Trace, ValueAt, check_order, spacing_sigma_s, write_csv,
    },
};
