//! Requests to a board: each is sent with a number, and again under the same number until the board
//! answers it.
//!
//! [`Requests`] knows no line and no clock, so that the emulator's loop and a serial port use the
//! same code.

pub mod receiver;

use anyhow::{Result, bail};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::Event;
use std::collections::VecDeque;
use std::time::Duration;

/// Time after which a request is sent again. A fit of the longest window takes a tenth of it;
/// erasing a page of flash, which is rare, takes eight times as long.
pub const PATIENCE: Duration = Duration::from_millis(250);

/// Times that a request is sent: 5 s in all.
pub const TRIES: u32 = 20;

/// A request as it travels.
pub fn encode(request: &Request) -> Result<Vec<u8>> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX];
    let used = framing::encode(request, &mut bytes)?;
    bytes.truncate(used);
    Ok(bytes)
}

/// Requests sent one after the other: the next one when the one before it was answered.
#[derive(Debug)]
pub struct Requests {
    next: u16,
    queue: VecDeque<Command>,
    current: Option<Sent>,
    /// Times that a request was sent, repetitions included.
    pub sends: u32,
}

#[derive(Debug)]
struct Sent {
    request: Request,
    bytes: Vec<u8>,
    tries: u32,
    due: Duration,
}

impl Requests {
    /// No request yet; the first one gets the number `first`. A board repeats its answer to the
    /// number that it answered last without doing anything: a program that talks to a board for the
    /// first time should take a number by the clock.
    pub const fn new(first: u16) -> Self {
        Self {
            next: first,
            queue: VecDeque::new(),
            current: None,
            sends: 0,
        }
    }

    pub fn push(&mut self, command: Command) {
        self.queue.push_back(command);
    }

    pub fn are_done(&self) -> bool {
        self.current.is_none() && self.queue.is_empty()
    }

    /// Bytes to send at this time; mostly none.
    pub fn due(&mut self, now: Duration) -> Result<Vec<u8>> {
        if self.current.is_none() {
            let Some(command) = self.queue.pop_front() else {
                return Ok(Vec::new());
            };
            let request = Request {
                number: self.next,
                command,
            };
            self.next = self.next.wrapping_add(1);
            let mut bytes = encode(&request)?;
            // Ends whatever was on the line before, which would spoil the request.
            bytes.insert(0, 0);
            self.current = Some(Sent {
                request,
                bytes,
                tries: 0,
                due: now,
            });
        }
        let Some(sent) = self.current.as_mut().filter(|sent| now >= sent.due) else {
            return Ok(Vec::new());
        };
        if sent.tries == TRIES {
            let Request { number, command } = &sent.request;
            bail!(
                "the board did not answer request {number} ({command:?}), sent {TRIES} times; is its line's RX connected?"
            );
        }
        (sent.tries, sent.due) = (sent.tries + 1, now + PATIENCE);
        self.sends = self.sends.saturating_add(1);
        Ok(sent.bytes.clone())
    }

    /// Takes an event; gives the command that it answers, and the outcome. A request that finds the
    /// board busy is sent again.
    pub fn answered(&mut self, event: &Event) -> Option<(Command, Outcome)> {
        let Event::Reply(reply) = event else {
            return None;
        };
        if reply.outcome == Outcome::Busy
            || self
                .current
                .as_ref()
                .is_none_or(|sent| sent.request.number != reply.number)
        {
            return None;
        }
        self.current
            .take()
            .map(|sent| (sent.request.command, reply.outcome.clone()))
    }
}
