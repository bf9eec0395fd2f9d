//! A feed, what it tells folded into [`Live`], and the board behind it kept sending raw frames: what the terminal's screen
//! and the web page have in common.

use super::{Asking, Feed, Happening};
use crate::events;
use crate::live::{Line, Live};
use anyhow::Result;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;
use std::time::Duration;

/// Raw frames: what strips are drawn from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RawFrames {
    /// They cannot be asked for: there is no board, or nothing that could.
    #[default]
    Unavailable,
    /// They are not wanted.
    Off,
    /// They are asked for.
    On,
    /// They were asked for, and this came of it.
    Refused(String),
}

/// A feed that is followed.
pub struct Following {
    feed: Feed,
    asking: Asking,
    raw: RawFrames,
}

impl Following {
    /// Of a feed, whose board is asked for raw frames if there is one; with `settings` these are put into force on the board
    /// first, but not stored.
    pub fn new(feed: Feed, settings: Option<Settings>) -> Self {
        let raw = if feed.has_board() { RawFrames::On } else { RawFrames::Unavailable };
        let mut asking = Asking::default();
        if let Some(settings) = settings {
            asking.give(Command::Set { settings, keep: false });
        }
        if raw == RawFrames::On {
            asking.want_raw(true);
        }
        Self { feed, asking, raw }
    }

    /// Nothing is known yet, but where it will come from.
    pub fn live(&self) -> Live {
        Live::new(self.feed.name())
    }

    /// Whether raw frames come, or why not.
    pub fn raw(&self) -> &RawFrames {
        &self.raw
    }

    /// Asks for raw frames, or no longer; where there is no board that is not possible.
    pub fn want_raw(&mut self, wanted: bool) {
        if self.raw != RawFrames::Unavailable {
            self.raw = if wanted { RawFrames::On } else { RawFrames::Off };
            self.asking.want_raw(wanted);
        }
    }

    /// Waits for what happens next, at most so long.
    ///
    /// # Errors
    /// Those of the feed.
    pub fn next(&mut self, most: Duration) -> Result<Option<Happening>> {
        self.feed.next(most)
    }

    /// Folds what has happened, if anything has, and sends what is due to the board. To be called after every
    /// [`Self::next`].
    pub fn fold(&mut self, happening: Option<&Happening>, live: &mut Live) {
        match happening {
            Some(Happening::Packet(packet)) => {
                live.take(packet);
                if let Some((command, outcome)) = self.asking.hear(packet)
                    && !matches!(outcome, Outcome::Done | Outcome::DoneErased)
                {
                    let why = events::outcome(&outcome);
                    if matches!(command, Command::Raw { .. }) {
                        self.raw = RawFrames::Refused(format!("no raw frames: {why}"));
                    }
                    live.note(why);
                }
            }
            Some(Happening::Came(name)) => {
                live.source.clone_from(name);
                live.line = Line::There;
                live.note(format!("{name}: open"));
            }
            Some(Happening::Went(name, why)) => {
                live.note(format!("{name}: {why}"));
                live.line = Line::Gone { why: why.clone() };
            }
            Some(Happening::Over) => live.line = Line::Over,
            None => {}
        }
        live.counts = self.feed.counts();
        if self.feed.has_board()
            && live.line == Line::There
            && let Err(error) = self.asking.tick(&mut self.feed)
        {
            live.note(format!("{error:#}"));
            self.raw = RawFrames::Refused("no raw frames: no answer (RX?)".into());
        }
    }

    /// Ends it; gives the feed back, with what it has counted. A board is not left with raw frames on its line. Whether it
    /// hears that is not waited for: they end by themselves.
    pub fn leave(mut self) -> Feed {
        if self.raw == RawFrames::On {
            self.asking.want_raw(false);
            let _ = self.asking.tick(&mut self.feed);
        }
        self.feed
    }
}
