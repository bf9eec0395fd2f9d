//! `settings` and `command`: requests to a board over its line, and its replies.

use crate::events;
use crate::feed::{Feed, FeedEvent, new_requests, request};
use crate::requests::{PATIENCE, Requests};
use crate::settings_form;
use crate::usage::UsageError;
use anyhow::{Context, Result, bail};
use ridgetone_proto::command::{Command, Outcome, Reply};
use ridgetone_proto::plan::Gives;
use ridgetone_proto::telemetry::{Event, Hello, Packet};

/// Number of packets after the reply within which the greeting is expected.
const PACKETS_MAX: usize = 20;

/// The PC's end of the conversation with a board.
pub struct Client<'a> {
    feed: &'a mut Feed,
    requests: Requests,
    /// Rates and windows of the plan in the settings that were sent.
    pub gives: Option<Gives>,
}

impl<'a> Client<'a> {
    pub fn new(feed: &'a mut Feed) -> Self {
        Self {
            feed,
            requests: new_requests(),
            gives: None,
        }
    }

    /// Requests the board's greeting.
    pub fn hello(&mut self) -> Result<Hello> {
        let mut hello = None;
        let keep = |packet: &Packet, hello: &mut Option<Hello>| {
            if let Event::Hello(greeting) = &packet.event {
                *hello = Some(greeting.clone());
            }
        };
        request(
            self.feed,
            &mut self.requests,
            Command::Greet,
            &mut |packet| keep(packet, &mut hello),
        )?;
        // The reply may overtake the greeting.
        for _ in 0..PACKETS_MAX {
            if hello.is_some() {
                break;
            }
            if let Some(FeedEvent::Data(packet)) = self.feed.next(PATIENCE)? {
                keep(&packet, &mut hello);
            }
        }
        hello.context("the board did not send its settings")
    }

    /// Sends a command. Returns true if the board erased flash for it, which costs a second or two
    /// of conversions. Fails if the board refuses the command, with the reason ([`UsageError`] for
    /// a setting), or does not answer.
    pub fn request(&mut self, command: Command) -> Result<bool> {
        let mut take = |packet: &Packet| {
            if let Event::Reply(Reply {
                gives: Some(gives), ..
            }) = &packet.event
            {
                self.gives = Some(*gives);
            }
        };
        let outcome = request(self.feed, &mut self.requests, command, &mut take)?;
        let text = events::outcome(&outcome);
        match outcome {
            Outcome::Done => Ok(false),
            Outcome::DoneErased => Ok(true),
            Outcome::Setting(error) => {
                Err(UsageError(settings_form::explain(&error.field, &text)).into())
            }
            Outcome::NotStored | Outcome::Busy => bail!("the board: {text}"),
        }
    }
}
