//! The PC side of Ridgetone, as a library for the command `ridgetone`, for `cargo xtask`, for
//! `ridgetone-eval` and for tests.
//!
//! | concept | where |
//! |---|---|
//! | overview of a recording | [`overview`] |
//! | a recording through the fit alone | `table_fit`, `grid`, `speed`, `clipped`, `fit_report` |
//! | tables of samples in common layouts | [`tables`] |
//! | rows of samples: of a file in any form, or in memory | [`samples`], `raw_rows`, [`frame`] |
//! | the messages of a recording, as packets or as JSON | [`messages`] |
//! | a recording's frames through the library | [`frames`] |
//! | the scene in front of the simulated chip | [`input`], [`touches`] |
//! | the library on this PC, behind the simulated chip | [`replay`] |
//! | calibration of the array with gratings of known period | `calibrate` |
//! | the firmware's tasks on this PC, behind the simulated chip and its faults | [`simulated`] |
//! | the firmware image on the register model of its board | [`emulator`] |
//! | a board on a serial line | `port` |
//! | packets from a board, the emulated board or a recording | [`feed`], `listen` |
//! | requests to a board | [`requests`], `client` |
//! | checks of a board at its first power-up | [`check`] |
//! | the state of a board, for a screen | [`live`], [`analysis`], [`harmonics`] |
//! | the screen on a terminal, the page in a browser | `monitor`, [`view`] |
//! | the messages of many boards on the buses of a robot | [`serve`] |
//! | telemetry in a file, and in other formats | [`recording`], [`record`], `export` |
//! | packets as text, as JSON | [`events`], [`names`], `tone`, [`overtones`], `remarks` |
//! | relation of a board's clock to UTC | [`utc`] |
//! | settings as TOML and `name=value` | [`settings_form`] |
//! | results compared with the truth, and a picture | [`demo`], [`picture`], [`static_image`],
//! [`chart`] |
//! | the commands of `ridgetone-teletaction` | `teletaction` |
//! | the command line | [`cli`], [`usage`], [`program`], [`output`], [`digits`], [`stop`] |
#![forbid(unsafe_code)]
// Messages quote text from files, boards and peers: `note!` escapes and cuts it.
#![deny(clippy::print_stderr)]
// The crate is not published: a field with a clear name and unit needs no documentation.
#![allow(missing_docs)]

pub mod alignment;
pub mod analysis;
mod calibrate;
pub mod chart;
pub mod check;
pub mod cli;
pub mod client;
mod clipped;
mod content;
pub mod demo;
pub mod digits;
pub mod emulator;
pub mod events;
pub mod export;
pub mod feed;
pub mod fit_picture;
pub mod fit_report;
mod fit_rows;
pub mod frame;
pub mod frames;
mod grid;
pub mod harmonics;
pub mod input;
pub mod keys;
pub mod listen;
pub mod live;
mod mcap;
pub mod messages;
mod monitor;
pub mod names;
pub mod output;
pub mod overtones;
pub mod overview;
pub mod part;
pub mod picture;
pub mod port;
pub mod positions;
pub mod program;
mod pseudo_terminal;
#[cfg(test)]
#[path = "../tests/common/ram_flash.rs"]
mod ram_flash;
mod raw_rows;
pub mod record;
pub mod recording;
mod remarks;
pub mod replay;
pub mod requests;
pub mod samples;
pub mod seen;
pub mod serve;
pub mod settings_form;
pub mod simulated;
pub mod speed;
pub mod static_image;
pub mod stop;
pub mod table_fit;
pub mod tables;
mod teletaction;
mod tone;
pub mod touch_part;
mod touch_times;
pub mod touches;
pub mod track;
pub mod usage;
pub mod utc;
pub mod view;
mod wav_rows;
pub mod windows;
