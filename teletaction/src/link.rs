//! `link`: a finger and a stylus, connected by a network. The hand's position goes one way, 250
//! times a second; textures go the other way, when they change and four times a second. No
//! vibration is transmitted: the stylus makes it from the position of its own hand.
//!
//! | step | file |
//! |---|---|
//! | messages, and their counts | [`message`] |
//! | a simulated network that delays and loses | [`network`] |
//! | one end over UDP | [`socket`] |
//! | the finger's end | [`finger`] |
//! | the period of the surface from the path of the hand | [`wavelength`] |
//! | the stylus' end: a board, and the requests to it | [`board`], [`requests`] |
//! | a simulated board under a simulated hand, and the error of the stimulus | [`simulated`] |
//! | both ends, and their reports | [`run`](mod@run) |

pub mod board;
pub mod finger;
pub mod message;
pub mod network;
pub mod requests;
pub mod run;
pub mod simulated;
pub mod socket;
pub mod wavelength;

pub use board::BoardEnd;
pub use run::{Ends, Link, Options, run};
pub use simulated::Hand;
