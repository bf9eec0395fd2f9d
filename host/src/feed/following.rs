//! A feed folded into [`Live`], from a board that keeps sending raw frames: the common part of the
//! terminal's screen and the web page.

use super::decoded::Feed;
use super::requester::Requester;
use super::source::FeedEvent;
use crate::events;
use crate::live::{Connection, Live};
use crate::utc::Receipt;
use anyhow::Result;
use ridgetone_proto::command::{Command, Outcome, Reply};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet};
use serde::Serialize;
use std::time::Duration;

/// State of the raw frames, from which strips are drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RawFrames {
    /// There is no board that could send raw frames.
    #[default]
    Unavailable,
    /// Raw frames were not requested.
    Off,
    /// Raw frames were requested.
    On,
    /// The request failed, for this reason.
    Refused(String),
}

pub struct Following {
    feed: Feed,
    requester: Requester,
    /// State of the request for raw frames.
    pub raw: RawFrames,
    /// The board's answer to [`Self::set`]; `None` until it arrives.
    pub settings_reply: Option<SettingsReply>,
    answers: u32,
    is_setting: bool,
    is_idle: bool,
}

/// Outcome of settings that were sent to the board.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SettingsReply {
    /// Counts from 1, to distinguish answers with the same text.
    pub number: u32,
    pub text: String,
    pub is_refused: bool,
}

impl Following {
    /// Follows a feed, and requests raw frames if there is a board; `settings` are put into force
    /// first, but not stored.
    pub fn new(feed: Feed, settings: Option<Settings>) -> Self {
        let raw = if feed.has_board() {
            RawFrames::On
        } else {
            RawFrames::Unavailable
        };
        let mut requester = Requester::with_settings(settings);
        if raw == RawFrames::On {
            requester.want_raw(true);
        }
        Self {
            feed,
            requester,
            raw,
            settings_reply: None,
            answers: 0,
            is_setting: false,
            is_idle: false,
        }
    }

    /// Returns a state that has only the name of the source.
    pub fn live(&self) -> Live {
        Live::new(self.feed.name())
    }

    /// Requests raw frames, or stops them; does nothing without a board.
    pub fn want_raw(&mut self, wanted: bool) {
        if self.raw != RawFrames::Unavailable {
            self.raw = if wanted {
                RawFrames::On
            } else {
                RawFrames::Off
            };
            self.requester.want_raw(wanted);
        }
    }

    /// True if there is a board that accepts settings.
    pub fn has_board(&self) -> bool {
        self.feed.has_board()
    }

    /// See [`Source::idle`](super::Source::idle).
    pub fn idle(&mut self, idle: bool) -> bool {
        self.is_idle = idle;
        self.feed.idle(idle)
    }

    /// Puts settings into force on the board, without storing them.
    pub fn set(&mut self, settings: Settings) {
        (self.settings_reply, self.is_setting) = (None, true);
        self.requester.push(Command::Set {
            settings,
            keep: false,
        });
        // The greeting reports which settings are in force.
        self.requester.push(Command::Greet);
    }

    fn set_ended(&mut self, text: String, is_refused: bool) {
        if std::mem::take(&mut self.is_setting) {
            self.answers += 1;
            self.settings_reply = Some(SettingsReply {
                number: self.answers,
                text,
                is_refused,
            });
        }
    }

    pub fn next(&mut self, max: Duration) -> Result<Option<FeedEvent<Packet>>> {
        self.feed.next(max)
    }

    pub fn receipt(&self) -> Option<Receipt> {
        self.feed.receipt()
    }

    /// Folds an event, if there is one, and sends the request that is due. Call it after every
    /// [`Self::next`].
    pub fn fold(&mut self, event: Option<&FeedEvent<Packet>>, live: &mut Live) {
        match event {
            Some(FeedEvent::Data(packet)) => {
                live.take(packet);
                if let Some((command, outcome)) = self.requester.answered(packet) {
                    let is_done = matches!(outcome, Outcome::Done | Outcome::DoneErased);
                    let why = events::outcome(&outcome);
                    if matches!(command, Command::Set { .. }) {
                        let text = match &packet.event {
                            _ if !is_done => why.clone(),
                            Event::Reply(Reply {
                                gives: Some(gives), ..
                            }) => {
                                format!(
                                    "Applied, not stored (lost at the next restart): {}.",
                                    events::given(gives)
                                )
                            }
                            _ => "Applied, not stored (lost at the next restart).".into(),
                        };
                        self.set_ended(text, !is_done);
                    }
                    if is_done {
                        return self.follow_up(live);
                    }
                    if matches!(command, Command::Raw { .. }) {
                        self.raw = RawFrames::Refused(format!("no raw frames: {why}"));
                    }
                    live.note(why);
                }
            }
            Some(FeedEvent::Connected(name)) => {
                live.now.source.clone_from(name);
                live.now.connection = Connection::Connected;
                live.note(format!("{name}: open"));
            }
            Some(FeedEvent::Disconnected(name, why)) => {
                live.note(format!("{name}: {why}"));
                live.now.connection = Connection::Disconnected { why: why.clone() };
            }
            Some(FeedEvent::Over) => live.now.connection = Connection::Over,
            None => {}
        }
        self.follow_up(live);
    }

    fn follow_up(&mut self, live: &mut Live) {
        live.now.counts = self.feed.counts();
        live.now.strangers = self.feed.strangers();
        // A paused source does not answer.
        if self.feed.has_board()
            && !self.is_idle
            && live.now.connection == Connection::Connected
            && let Err(error) = self.requester.tick(&mut self.feed)
        {
            live.note(format!("{error:#}"));
            self.set_ended(format!("{error:#}"), true);
            self.raw = RawFrames::Refused("no raw frames: no answer (RX?)".into());
        }
    }

    /// Stops raw frames and returns the feed. Does not wait for the answer: the board stops by
    /// itself after a minute.
    pub fn finish(mut self) -> Feed {
        if self.raw == RawFrames::On {
            self.requester.want_raw(false);
            let _ = self.requester.tick(&mut self.feed);
        }
        self.feed
    }
}
