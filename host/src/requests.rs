//! Requests to a board. Each request has a number and is repeated with the same number until the
//! board answers.
//!
//! [`Requests`] uses neither a line nor a clock, so that it works in the emulator's loop and on a
//! serial port.

pub mod receiver;

use anyhow::{Result, bail};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::Event;
use std::collections::VecDeque;
use std::time::Duration;

/// Time after which a request is repeated. A fit of the longest window takes a tenth of this time;
/// erasing a page of flash, which is rare, takes eight times as long.
pub const PATIENCE: Duration = Duration::from_millis(250);

/// Maximum number of times that a request is sent, within 5 s.
pub const TRIES: u32 = 20;

pub fn encode(request: &Request) -> Result<Vec<u8>> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX];
    let used = framing::encode(request, &mut bytes)?;
    bytes.truncate(used);
    Ok(bytes)
}

/// Queue of requests; each is sent after the previous one was answered.
#[derive(Debug)]
pub struct Requests {
    next: u16,
    queue: VecDeque<Command>,
    current: Option<Sent>,
    /// Number of requests sent, including repetitions.
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
    /// Creates an empty queue whose first request gets the number `first`. If a board receives the
    /// number that it answered last, it only repeats the answer. A program that talks to a board
    /// for the first time should therefore derive `first` from the clock.
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

    /// Returns the bytes to send now, usually none.
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
            // Terminates any bytes already on the line, which would otherwise corrupt the request.
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

    /// Takes an event. If it answers the current request, returns the command and the outcome. If
    /// the board was busy, the request is sent again.
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
