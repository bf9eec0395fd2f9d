//! What each task does, written once. The firmware binds the tasks to interrupts; the PC and the
//! fault campaigns call them in turn.
//!
//! | task | priority | starts with | does |
//! |---|---|---|---|
//! | [`mod@line`] | 5 | a byte sent or received | sends one byte of telemetry, takes one of a request |
//! | [`drdy`] | 4 | DRDY's falling edge | reads one conversion, queues it; checks the chip on request |
//! | [`detect`] | 3 | `drdy` | frames, contact, windows |
//! | [`report`] | 2 | an event | encodes packets |
//! | [`watch`] | 2 | twice a second | requests a check of the chip, decides about the watchdog |
//! | [`fit`] | 1 | a window, a request | runs the estimator; requests when no window is due |
//! | [`idle`] | 0 | | measures load and stack, ends the run |
//!
//! A task's resources are behind [`rtic_core::Mutex`] where a task of higher priority uses them
//! too.

pub mod commands;
pub mod detect;
pub mod drdy;
pub mod fit;
pub mod idle;
pub mod line;
pub mod liveness;
pub mod outbox;
pub mod report;
pub mod requests;
pub mod shared;
pub mod watch;
