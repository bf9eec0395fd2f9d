//! Follows the textures that a finger reports, and whether it says anything at all.

use super::found::found;
use crate::feed::{Feed, Requester, new_requests};
use crate::listen::{Heard, Listener, SILENT};
use anyhow::Result;
use ridgetone_proto::command::Command;
use ridgetone_stimulus::Texture;
use std::time::{Duration, Instant};

/// What is new of a finger.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// It has another texture under it; if it was silent it no longer is.
    Texture(Texture),
    /// It was silent, and no longer is. Its texture follows as soon as it finds one.
    Back,
    /// It has said nothing for [`SILENT`].
    Silent,
    /// The board at this name is disconnected, for this reason, and is waited for.
    Disconnected(String, String),
    /// The recording is over.
    Over,
}

/// A finger's feed that is followed.
pub struct Follower {
    listener: Listener,
    heard_at: Instant,
    is_silent: bool,
    is_over: bool,
}

impl Follower {
    pub fn new(feed: Feed) -> Self {
        let listener = Listener::new(feed, Requester::default());
        Self { listener, heard_at: Instant::now(), is_silent: false, is_over: false }
    }

    /// Greets the board, which then reports its texture even if that has not changed. It need not answer: a finger may be wired to
    /// send only, and then reports a texture when it has changed.
    fn greet(&mut self) {
        let (feed, mut requests) = (&mut self.listener.feed, new_requests());
        requests.push(Command::Greet);
        if let Ok(bytes) = requests.due(feed.elapsed())
            && feed.has_board()
        {
            let _ = feed.send(&bytes);
        }
    }

    /// The feed, for its counts.
    pub fn into_feed(self) -> Feed {
        self.listener.feed
    }

    /// Nobody looks, or somebody does again: an emulated board waits meanwhile, and counts as heard.
    pub fn idle(&mut self, idle: bool) {
        if self.listener.feed.idle(idle) || idle {
            self.heard_at = Instant::now();
        }
    }

    /// Waits for what is new, at most for `most`.
    pub fn next(&mut self, most: Duration) -> Result<Option<News>> {
        match self.listener.next(most)? {
            Some(Heard::Packet(packet, _)) => {
                self.heard_at = Instant::now();
                let is_back = std::mem::take(&mut self.is_silent);
                if is_back {
                    // It may be another surface by now, or the same, of which the board would say nothing.
                    self.greet();
                }
                Ok(found(&packet).map(News::Texture).or(is_back.then_some(News::Back)))
            }
            Some(Heard::Connected(_)) => {
                self.greet();
                Ok(None)
            }
            Some(Heard::Over) => {
                self.is_over = true;
                Ok(Some(News::Over))
            }
            Some(Heard::Disconnected(name, why)) => {
                self.is_silent = true;
                Ok(Some(News::Disconnected(name, why)))
            }
            _ if !self.is_over && !self.is_silent && self.heard_at.elapsed() > SILENT => {
                self.is_silent = true;
                Ok(Some(News::Silent))
            }
            _ => Ok(None),
        }
    }
}
