//! The status line of the page: the state of the board, and what to do if nothing arrives.

use crate::feed::{EMULATED, RawFrames};
use crate::listen::SILENT;
use crate::live::{Connection, Live, Phase};
use std::time::Duration;

/// Returns the status in a sentence. `age` is the time since the latest packet; `None` before the
/// first one.
pub fn status(live: &Live, age: Option<Duration>) -> String {
    match (&live.now.connection, age) {
        (Connection::Disconnected { why }, _) => {
            format!("The board is disconnected ({why}). Plug it in again: the command waits for it.")
        }
        (Connection::Over, _) if live.now.counts.received == 0 => {
            "No board is connected: connect one, or drop recordings on this page.".into()
        }
        (Connection::Over, _) => "The recording is over. The page shows its end.".into(),
        (_, None) if live.now.source == EMULATED => {
            "The emulated board is starting.".into()
        }
        (_, None) if live.now.strangers.is_some() => {
            let what = live.now.strangers.as_deref().unwrap_or_default();
            format!("This port has no Ridgetone on it: {what}.")
        }
        (_, None) => {
            "Nothing was received from the board yet. Is it powered, and its TX on this port, at 921600 baud?".into()
        }
        (_, Some(age)) if age > SILENT => {
            format!("The board has been silent for {} s. Is its line still connected?", age.as_secs())
        }
        _ => touch(live).into(),
    }
}

/// Returns the reason why there are no raw frames, if any.
pub fn no_raw(raw: &RawFrames) -> Option<String> {
    match raw {
        RawFrames::On => None,
        RawFrames::Off => Some("Raw frames are switched off.".into()),
        RawFrames::Unavailable => {
            Some("This recording holds no raw frames, from which this is drawn.".into())
        }
        RawFrames::Refused(why) => Some(format!("There are {why}.")),
    }
}

fn touch(live: &Live) -> &'static str {
    match live.now.phase {
        Phase::Unknown => "The board is connected. Its state will be known with the next touch.",
        Phase::Idle if live.now.touches == 0 => {
            "Nothing touches the finger yet. Press a grating on it, hold, then slide."
        }
        Phase::Idle => "Nothing touches the finger.",
        Phase::Held => "The finger is touched. Slide the grating.",
        Phase::Sliding if live.estimate().is_none() => {
            "The grating slides. The first window is not full yet."
        }
        Phase::Sliding => "The grating slides.",
        Phase::HeldAfter => "The slide is over, and the finger is still touched.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_has_a_sentence() {
        let mut live = Live::new("a port");
        let now = Some(Duration::ZERO);
        assert!(status(&live, None).starts_with("Nothing was received"));
        live.now.strangers = Some("text arrives".into());
        assert!(status(&live, None).contains("no Ridgetone on it: text arrives"));
        let emulated = status(&Live::new(EMULATED), None);
        assert!(emulated.starts_with("The emulated board is starting"));
        live.now.connection = Connection::Connected;
        assert!(status(&live, now).starts_with("The board is connected"));
        assert_eq!(
            status(&live, Some(Duration::from_secs(7))),
            "The board has been silent for 7 s. Is its line still connected?"
        );
        live.now.phase = Phase::Idle;
        live.now.counts.received = 1;
        assert!(status(&live, now).starts_with("Nothing touches the finger yet"));
        live.now.touches = 1;
        assert_eq!(status(&live, now), "Nothing touches the finger.");
        live.now.connection = Connection::Disconnected {
            why: "Broken pipe".into(),
        };
        assert!(status(&live, now).contains("disconnected (Broken pipe)"));
        live.now.connection = Connection::Over;
        assert!(status(&live, now).starts_with("The recording is over"));
    }
}
