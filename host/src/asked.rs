//! `settings` and `order`: a board that is asked over its line, and answers.

use crate::cli::Senseless;
use crate::events;
use crate::feed::{Feed, Source, new_orders};
use crate::requests::{Requests, ask};
use crate::settings_form;
use anyhow::{Context, Result, bail};
use ridgetone_proto::command::{Command, KNOTS_A_COMMAND, Outcome, Part};
use ridgetone_proto::profile::{After, Knot};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Hello};

/// A board that is asked.
pub struct Asked<'a, S: Source> {
    feed: &'a mut Feed<S>,
    requests: Requests,
}

impl<'a, S: Source> Asked<'a, S> {
    /// The board behind a feed.
    pub fn new(feed: &'a mut Feed<S>) -> Self {
        Self { feed, requests: new_orders() }
    }

    /// What the board says of itself.
    ///
    /// # Errors
    /// It does not answer.
    pub fn hello(&mut self) -> Result<Hello> {
        let mut hello = None;
        let mut sink = |packet: &ridgetone_proto::telemetry::Packet| {
            if let Event::Hello(told) = &packet.event {
                hello = Some(told.clone());
            }
        };
        ask(self.feed, &mut self.requests, Command::Greet, &mut sink)?;
        // The reply may overtake the greeting.
        let mut tries = 0;
        while hello.is_none() && tries < 20 {
            tries += 1;
            if let Some(crate::feed::Happening::Packet(packet)) = self.feed.next(crate::requests::PATIENCE)?
                && let Event::Hello(told) = packet.event
            {
                hello = Some(told);
            }
        }
        hello.context("the board was asked for its settings and has not told them")
    }

    /// Puts settings into force, from the next window on; with `keep` after the next start too. True if that took a second or
    /// two of conversions, for the flash was erased.
    ///
    /// # Errors
    /// [`Senseless`]: the board refuses them, with the reason. They could not be stored; it does not answer.
    pub fn set(&mut self, settings: Settings, keep: bool) -> Result<bool> {
        self.request(Command::Set { settings, keep })
    }

    /// Has the board forget what it has stored, and use its defaults. True as with [`Self::set`].
    ///
    /// # Errors
    /// Those of [`Self::set`].
    pub fn forget(&mut self) -> Result<bool> {
        self.request(Command::Forget)
    }

    /// Has estimates come by place, with this speed over the surface.
    ///
    /// # Errors
    /// The board refuses the profile; it does not answer.
    pub fn follow(&mut self, knots: &[Knot], after: After) -> Result<()> {
        let mut first = 0;
        for part in knots.chunks(KNOTS_A_COMMAND) {
            let last = (first + part.len() == knots.len()).then_some(after);
            let knots = heapless::Vec::from_slice(part).context("a part of the profile is too long")?;
            self.request(Command::Follow(Part { first: first as u8, knots, last }))?;
            first += part.len();
        }
        Ok(())
    }

    /// Gives an order. True as with [`Self::set`].
    ///
    /// # Errors
    /// The board refuses it, with the reason; it does not answer.
    pub fn request(&mut self, command: Command) -> Result<bool> {
        let outcome = ask(self.feed, &mut self.requests, command, &mut |_| {})?;
        let told = events::outcome(&outcome);
        match outcome {
            Outcome::Done => Ok(false),
            Outcome::DoneErased => Ok(true),
            Outcome::Setting { field, .. } => Err(Senseless(settings_form::explain(&field, &told)).into()),
            Outcome::Profile | Outcome::NotStored | Outcome::Busy => bail!("the board: {told}"),
        }
    }
}
