//! The PC side of Ridgetone, as a library for the command `ridgetone`, for `cargo xtask` and for tests.
//!
//! | what | where |
//! |---|---|
//! | a recording through the fit alone | [`grid`], [`table_fit`], [`fit_report`] |
//! | what the simulated chip feels: a scene or a recording | [`input`] |
//! | the library on this PC, behind the simulated chip | [`replay`] |
//! | gratings of known period, for what turns phases into periods | [`calibrate`] |
//! | speeds and places beside a recording | [`speed`] |
//! | the firmware image in QEMU, with the simulated chip at its bridge | [`emulator`] |
//! | where packets come from: a board's line, the emulated board, a recording; one decoder behind all | [`feed`] |
//! | a board on a serial line, found again when it was unplugged | [`port`], [`listen`] |
//! | the same on a terminal | [`monitor`] |
//! | the same as a page in a browser | [`view`] |
//! | telemetry in a file, and in the formats of others | [`record`], [`recording`], [`export`] |
//! | what is known of a board at this moment, for a screen to show | [`live`] |
//! | how many damaged frames the decoder takes: none | [`bit_errors`] |
//! | orders to a board, and what came of them | [`orders`] |
//! | packets as text, as JSON, for Teleplot | [`events`], [`teleplot`] |
//! | the static image as a map of 4 x 4 | [`static_image`] |
//! | a window made for a test, and the least error that any estimator can have in it | [`simulated`], [`bound`] |
//! | what it costs on the emulated chip | [`mod@bench`] |
//! | what each choice costs and brings, beside other methods: tables and a picture | [`setting`], [`trade`] |
//! | faults injected into all of it, and what became of them | [`faults`] |
//! | the paper's experiment, figure for figure | [`reproduce`] |
//! | what was found beside the truth, and a picture of it | [`demo`], [`picture`] |
//! | settings as TOML and `name=value`; requests to a board and its replies | [`settings_form`], [`client`] |
//! | the command line | [`cli`], [`commands`], [`output`], [`stop`] |
#![forbid(unsafe_code)]

pub mod axis;
pub mod calibrate;
pub mod cli;
pub mod client;
pub mod commands;
pub mod demo;
pub mod emulator;
pub mod events;
pub mod export;
pub mod feed;
pub mod fit_report;
pub mod grid;
pub mod input;
pub mod listen;
pub mod live;
pub mod monitor;
pub mod names;
pub mod output;
pub mod picture;
pub mod port;
pub mod record;
pub mod recording;
pub mod replay;
pub mod requests;
pub mod settings_form;
pub mod speed;
pub mod static_image;
pub mod stop;
pub mod svg;
pub mod table_fit;
pub mod teleplot;
pub mod tone;
pub mod view;
