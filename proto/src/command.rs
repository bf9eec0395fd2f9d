//! What a PC may ask for, and what it is answered.

use crate::framing as wire;
use crate::profile::{After, Knot};
use crate::settings::Settings;
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// Most bytes of an order on the wire, checksum, stuffing and delimiter included: settings with a slide by protocol, or
/// a part of a profile in full. A test has both.
pub const REQUEST_WIRE_MAX: usize = 96;

/// Knots that one command carries.
pub const KNOTS_A_COMMAND: usize = 8;

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Command {
    /// Say `hello`: with it the settings in force.
    Greet,
    /// Use these settings from the next window on, and after the next start too if `keep`. Every 1,365th time or so
    /// that costs 1 to 2 s of conversions: [`Outcome::DoneErased`]; never while something is touched.
    Set {
        /// All of them.
        settings: Settings,
        /// Whether to store them.
        keep: bool,
    },
    /// Forget what is stored, and use the defaults.
    Forget,
    /// Begin anew, as after power-up: the level without touch is learnt again.
    Start,
    /// Tell nothing but `health` until [`Self::Start`].
    Stop,
    /// Part of a speed profile; see [`ridgetone::surface::profile`].
    Follow(Part),
    /// Estimates by time again.
    Unfollow,
    /// Send so many frames raw, from now on.
    Raw {
        /// How many; 0: no more.
        frames: u32,
    },
    /// Reset the board.
    Restart,
}

/// Some knots of a speed profile. With the last ones it is in force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Number of the first of these knots. 0 begins a profile; the others follow in order.
    pub first: u8,
    /// Knots.
    pub knots: Vec<Knot, KNOTS_A_COMMAND>,
    /// Behind the last ones: what comes after them.
    pub last: Option<After>,
}

/// What travels to the board: a command with its number, by which it is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the PC. The same number again is the same command again: answered, but not done twice.
    pub number: u16,
    /// The command.
    pub command: Command,
}

impl Request {
    /// Reads one in its stuffed frame, which is changed; none if any of it is not as it was sent.
    #[inline(never)]
    pub fn decode(frame: &mut [u8]) -> Option<Self> {
        wire::decode(frame)
    }
}

/// The answer to an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The order's number.
    pub number: u16,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// It is done.
    Done,
    /// A setting is outside its bounds; nothing was changed.
    Setting {
        /// Its name, with its unit.
        field: String<24>,
        /// What was asked for.
        value: f32,
        /// Least allowed.
        least: f32,
        /// Greatest allowed.
        greatest: f32,
    },
    /// The profile is refused: knots out of order, too many, too fast, or a part is missing.
    Profile,
    /// In force, but it could not be stored: the flash refuses.
    NotStored,
    /// Another order is being carried out; ask again.
    Busy,
    /// It is done. For it a sector of the flash was erased, during which the processor stood still for 1 to 2 s: the
    /// conversions lost then are told as [`Lost`](crate::fault::FaultKind::Lost) and counted in `health`.
    DoneErased,
}
