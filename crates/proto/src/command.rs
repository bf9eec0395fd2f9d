//! Commands of the PC, and the board's replies.

use crate::framing;
use crate::plan::Gives;
use crate::settings::{Settings, SettingsError};
use serde::{Deserialize, Serialize};

/// Maximum number of bytes of a request on the wire. The longest ones are settings, of 110 bytes at
/// most: the rest is room for more of them.
pub const REQUEST_WIRE_MAX: usize = 136;

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Command {
    /// Send `hello`, which carries the settings in force.
    Greet,
    /// Use these settings from the next window on; with `keep` also after the next start. About
    /// every 512th time keeping costs 1 to 2 s of conversions ([`Outcome::DoneErased`]), but
    /// never during a touch.
    Set {
        /// All of them.
        settings: Settings,
        /// True to store the settings, too.
        keep: bool,
    },
    /// Delete the stored settings, and use the defaults.
    Forget,
    /// Start again, as after power-up: the level without touch is measured again.
    Start,
    /// Send nothing but `health`, `fault` and `converter` until [`Self::Start`].
    Stop,
    /// Send the next frames as they are read.
    Raw {
        /// Number of frames; 0 stops them.
        frames: u32,
    },
    /// Reset the board.
    Restart,
}

/// A command with its number, which the reply repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the PC. A repeated number is a repeated request: the board replies, but does not
    /// carry it out twice.
    pub number: u16,
    /// The command.
    pub command: Command,
}

impl Request {
    /// Decodes one stuffed frame without its zero, in place; `None` if it is damaged. It is
    /// compiled in this crate, optimised for size, and not into its callers.
    pub fn decode(frame: &mut [u8]) -> Option<Self> {
        framing::decode(frame)
    }
}

/// The reply to a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The request's number.
    pub number: u16,
    /// The result.
    pub outcome: Outcome,
    /// To settings that are not refused: what their plan gives.
    pub gives: Option<Gives>,
}

impl Reply {
    /// A reply that is not to settings.
    pub const fn new(number: u16, outcome: Outcome) -> Self {
        Self {
            number,
            outcome,
            gives: None,
        }
    }
}

/// Result of a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Done.
    Done,
    /// A setting is outside its bounds; nothing has changed.
    Setting(SettingsError),
    /// In force, but not stored: the flash refuses, or a page would have to be erased during a
    /// touch.
    NotStored,
    /// The board carries out another request; send this one again.
    Busy,
    /// Done, and a sector of the flash was erased for it: conversions of 1 to 2 s were lost, and
    /// are reported so.
    DoneErased,
}
