//! Commands of the PC, and the board's replies.

use crate::framing;
use crate::plan::Gives;
use crate::settings::{Settings, SettingsError};
use serde::{Deserialize, Serialize};

/// Maximum number of bytes of a request on the wire. The longest requests are settings, up to 110
/// bytes: the rest is reserved for future settings.
pub const REQUEST_WIRE_MAX: usize = 136;

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Command {
    /// Send `hello`, which includes the current settings.
    Greet,
    /// Use these settings from the next window on; with `keep`, also after the next start. About
    /// every 512th time, storing them loses 1 to 2 s of conversions ([`Outcome::DoneErased`]), but
    /// never during a touch.
    Set {
        /// All settings.
        settings: Settings,
        /// True to also store the settings.
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
    /// Number chosen by the PC. A repeated number means a repeated request: the board replies, but
    /// does not execute the command twice.
    pub number: u16,
    /// The command.
    pub command: Command,
}

impl Request {
    /// Decodes one stuffed frame without its zero, in place; `None` if it is damaged. This is
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
    /// Rates and windows of the new plan, in the reply to accepted settings.
    pub gives: Option<Gives>,
}

impl Reply {
    /// Creates a reply to a request other than settings.
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
    /// The settings are used, but not stored: the flash failed, or a page would have to be erased
    /// during a touch.
    NotStored,
    /// The board is executing a different request; send this one again.
    Busy,
    /// Done, but a sector of the flash was erased: 1 to 2 s of conversions were lost, and are
    /// reported as lost.
    DoneErased,
}
