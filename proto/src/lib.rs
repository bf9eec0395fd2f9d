//! The contract between a Ridgetone finger and a PC, and what the finger keeps over a reset.
//!
//! | what | where |
//! |---|---|
//! | what the finger sends: numbered packets, each with one event | [`telemetry`] |
//! | what the PC sends: numbered requests, each with one command | [`command`], [`profile`] |
//! | what a robot sends: places or speeds, with its own stamps | [`odometry`] |
//! | faults: their kinds and sets | [`fault`] |
//! | how both travel on the line | [`framing`] |
//! | settings with their bounds, and the scan | [`settings`], [`plan`], [`scan`] |
//! | what survives a reset: settings in flash, a crash record in RAM | [`store`], [`crash`], [`boot`] |
//!
//! Every type serialises with `serde`: on the line with `postcard`, on a PC also as JSON.
//!
//! ```
//! use ridgetone_proto::telemetry::{Contact, Decoder, Event, Packet, WIRE_MAX, encode};
//!
//! let contact = Contact { t_us: 510_003, taxel: 3, height_v: 0.012 };
//! let packet = Packet { sequence: 7, event: Event::Contact(contact) };
//! let mut wire = [0; WIRE_MAX];
//! let used = encode(&packet, &mut wire)?;
//!
//! let mut decoder = Decoder::new();
//! let decoded = wire[..used].iter().find_map(|byte| decoder.push(*byte));
//! assert_eq!(decoded, Some(packet));
//! assert_eq!((decoder.damaged, decoder.missing), (0, 0));
//! # Ok::<(), ridgetone_proto::telemetry::TooLong>(())
//! ```
#![no_std]
// A panic resets the finger, so only tests may panic.
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::unreachable, clippy::todo, clippy::unimplemented))]
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
pub mod profile;
pub mod scan;
pub mod settings;
pub mod store;
pub mod telemetry;
mod text_form;
