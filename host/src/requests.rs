//! Orders to a board: each is sent with a number, and again under the same number until it is answered.
//!
//! [`Requests`] knows no line and no clock, so that the emulator's loop and a serial port's use the same; [`ask`] waits for
//! one answer on any [`Line`].

pub mod receiver;

use anyhow::{Result, bail};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing as wire;
use ridgetone_proto::telemetry::{Event, Packet};
use std::collections::VecDeque;
use std::time::Duration;

/// Time after which an order is sent again: a fit of the longest window takes a tenth of it, erasing a page of flash, which
/// is rare, eight times as long.
pub const PATIENCE: Duration = Duration::from_millis(250);

/// Times that an order is sent: 5 s in all.
pub const TRIES: u32 = 20;

/// An order as it travels.
///
/// # Errors
/// It is longer than [`REQUEST_WIRE_MAX`]; there is none.
pub fn encode(request: &Request) -> Result<Vec<u8>> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX];
    let used = wire::encode(request, &mut bytes)?;
    bytes.truncate(used);
    Ok(bytes)
}

/// Orders to be sent, one after the other: the next one when the one before it was answered.
#[derive(Debug)]
pub struct Requests {
    next: u16,
    waiting: VecDeque<Command>,
    current: Option<Sent>,
}

#[derive(Debug)]
struct Sent {
    request: Request,
    bytes: Vec<u8>,
    tries: u32,
    due: Duration,
}

impl Requests {
    /// None yet; the first one gets the number `first`. A board answers a number that it has just answered without doing
    /// anything: a program that talks to a board for the first time takes any number, by the clock.
    pub const fn new(first: u16) -> Self {
        Self { next: first, waiting: VecDeque::new(), current: None }
    }

    /// Has a command sent.
    pub fn give(&mut self, command: Command) {
        self.waiting.push_back(command);
    }

    /// Whether all are answered.
    pub fn are_done(&self) -> bool {
        self.current.is_none() && self.waiting.is_empty()
    }

    /// What is to be sent at this time; nothing most of the time.
    ///
    /// # Errors
    /// An order was not answered after [`TRIES`].
    pub fn due(&mut self, now: Duration) -> Result<Vec<u8>> {
        if self.current.is_none() {
            let Some(command) = self.waiting.pop_front() else { return Ok(Vec::new()) };
            let request = Request { number: self.next, command };
            self.next = self.next.wrapping_add(1);
            let mut bytes = encode(&request)?;
            // Whatever was on the line before is not to spoil it.
            bytes.insert(0, 0);
            self.current = Some(Sent { request, bytes, tries: 0, due: now });
        }
        let Some(sent) = self.current.as_mut().filter(|sent| now >= sent.due) else { return Ok(Vec::new()) };
        if sent.tries == TRIES {
            let Request { number, command } = &sent.request;
            bail!(
                "the board did not answer order {number} ({command:?}), sent {TRIES} times; is its line's RX connected?"
            );
        }
        (sent.tries, sent.due) = (sent.tries + 1, now + PATIENCE);
        Ok(sent.bytes.clone())
    }

    /// Takes what the board says; gives a command that it has answered, and the answer. An order that finds it busy is sent
    /// again.
    pub fn hear(&mut self, event: &Event) -> Option<(Command, Outcome)> {
        let Event::Reply(reply) = event else { return None };
        if reply.outcome == Outcome::Busy
            || self.current.as_ref().is_none_or(|sent| sent.request.number != reply.number)
        {
            return None;
        }
        self.current.take().map(|sent| (sent.request.command, reply.outcome.clone()))
    }
}

/// A line to a board.
pub trait Line {
    /// Sends bytes.
    ///
    /// # Errors
    /// Those of the line.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Waits for a packet, at most so long.
    ///
    /// # Errors
    /// Those of the line.
    fn receive(&mut self, most: Duration) -> Result<Option<Packet>>;

    /// Time on any clock that goes on.
    fn now(&self) -> Duration;
}

/// Sends a command and waits for its answer; all packets that come meanwhile go to `sink`.
///
/// # Errors
/// The board does not answer; those of the line.
pub fn ask(
    line: &mut dyn Line,
    requests: &mut Requests,
    command: Command,
    sink: &mut dyn FnMut(&Packet),
) -> Result<Outcome> {
    requests.give(command);
    loop {
        let bytes = requests.due(line.now())?;
        if !bytes.is_empty() {
            line.send(&bytes)?;
        }
        if let Some(packet) = line.receive(PATIENCE / 10)? {
            sink(&packet);
            if let Some((_, outcome)) = requests.hear(&packet.event) {
                return Ok(outcome);
            }
        }
    }
}
