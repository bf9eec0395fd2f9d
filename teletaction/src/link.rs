//! `link`: a finger and a stylus with a network between them. The place of the hand goes one way,
//! 250 times a second; textures go the other way, when they have changed and four times a second.
//! No vibration travels: the stylus makes it from the place of its own hand.
//!
//! | step | file |
//! |---|---|
//! | what travels, and what is counted of it | [`message`] |
//! | a network that delays, loses, doubles and damages, simulated | [`network`] |
//! | one end or the other over UDP | [`socket`] |
//! | the finger's end | [`finger`] |
//! | the stylus' end: a simulated hand and actuator, and the error of what is felt | [`stylus`] |
//! | that end on a board of its own, and what the board is requested | [`board`], [`requests`] |
//! | both, and what they report each second | [`run`](mod@run) |

pub mod board;
pub mod finger;
pub mod message;
pub mod network;
pub mod requests;
pub mod run;
pub mod socket;
pub mod stylus;

pub use board::BoardEnd;
pub use run::{Ends, Link, Options, run};
