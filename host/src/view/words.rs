//! What is to be said where there is nothing to see: why, and what to do about it.

use crate::feed::RawFrames;
use crate::live::{Line, Live, Phase};
use std::time::Duration;

/// A board says something every second; this long without a word it is silent.
const SILENT: Duration = Duration::from_secs(3);

/// What happens, in a sentence. `heard` is how long ago the latest packet came; none if there was none.
pub fn say(live: &Live, heard: Option<Duration>) -> String {
    match (&live.line, heard) {
        (Line::Gone { why }, _) => format!("The board is gone ({why}). It is waited for: plug it in again."),
        (Line::Over, _) => "The recording is over. This is what was seen last.".into(),
        (_, None) => {
            "Nothing was heard from the board yet. Is it powered, and its TX on this port, at 921600 baud?".into()
        }
        (_, Some(heard)) if heard > SILENT => {
            format!("The board has been silent for {} s. Is its line still connected?", heard.as_secs())
        }
        _ => touch(live).into(),
    }
}

/// Why there are no raw frames, if they do not come.
pub fn no_raw(raw: &RawFrames) -> Option<String> {
    match raw {
        RawFrames::On => None,
        RawFrames::Off => Some("Raw frames are not asked for.".into()),
        RawFrames::Unavailable => Some("This recording holds no raw frames, from which this is drawn.".into()),
        RawFrames::Refused(why) => Some(format!("There are {why}.")),
    }
}

fn touch(live: &Live) -> &'static str {
    match live.phase {
        Phase::Unknown => "The board is there. What it feels will be known with the next touch.",
        Phase::Idle if live.touches == 0 => "Nothing touches the finger yet. Press a grating on it, hold, then slide.",
        Phase::Idle => "Nothing touches the finger.",
        Phase::Held => "The finger is touched. Slide the grating.",
        Phase::Sliding if live.estimate().is_none() => "It slides. The first window is not full yet.",
        Phase::Sliding => "It slides.",
        Phase::HeldAfter => "The slide is over, and the finger is still touched.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_there_is_nothing_to_see_is_said() {
        let mut live = Live::new("a port");
        let now = Some(Duration::ZERO);
        assert!(say(&live, None).starts_with("Nothing was heard"));
        live.line = Line::There;
        assert!(say(&live, now).starts_with("The board is there"));
        assert_eq!(
            say(&live, Some(Duration::from_secs(7))),
            "The board has been silent for 7 s. Is its line still connected?"
        );
        live.phase = Phase::Idle;
        assert!(say(&live, now).starts_with("Nothing touches the finger yet"));
        live.touches = 1;
        assert_eq!(say(&live, now), "Nothing touches the finger.");
        live.line = Line::Gone { why: "Broken pipe".into() };
        assert!(say(&live, now).contains("gone (Broken pipe)"));
        live.line = Line::Over;
        assert!(say(&live, now).starts_with("The recording is over"));
    }
}
