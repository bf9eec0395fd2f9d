//! The tasks, written once. The firmware binds them to interrupts; the PC and the fault campaigns
//! call them in turn.
//!
//! | task | priority | starts with | does |
//! |---|---|---|---|
//! | [`SerialLine`] | 5 | a byte sent, the end of a request | sends one byte of telemetry |
//! | [`Drdy`] | 4 | DRDY's falling edge | reads one conversion, queues it; checks the chip on request |
//! | [`Detect`] | 3 | `drdy` | frames, contact, windows |
//! | [`Report`] | 2 | an event, bytes received | takes requests, encodes packets |
//! | [`WatchdogPolicy`] | 2 | twice a second | requests a check of the chip, decides about the watchdog |
//! | [`Fit`] | 1 | a window, a request | runs the estimator; requests when no window is due |
//! | [`Idle`] | 0 | | measures load and stack, ends the run |
//!
//! A task's resources are behind [`rtic_core::Mutex`] if a higher-priority task uses them too.

pub(crate) mod commands;
pub(crate) mod detect;
pub(crate) mod drdy;
pub(crate) mod fit;
pub(crate) mod idle;
pub(crate) mod line;
pub(crate) mod liveness;
pub(crate) mod outbox;
mod plan_request;
pub(crate) mod report;
pub(crate) mod requests;
pub(crate) mod shared;
mod watch;

pub use detect::Detect;
pub use drdy::{Drdy, DrdyPin};
pub use fit::Fit;
pub use idle::{DepthMeter, Idle, Next, Slept, Stack};
pub use line::{Received, Receiver, RequestInbox, SerialLine, SerialPort, receive, receive_all};
pub use liveness::{WATCHDOG_S, WatchdogPolicy};
pub use outbox::{Mail, Outbox, Posted};
pub use report::Report;
pub use requests::{Requests, Targets};
pub use shared::{BYTES, FRAMES, PACKETS, Platform, SAMPLES, Samples, Shared, Task, WINDOWS};
