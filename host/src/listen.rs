//! Passes a feed's packets to a sink, until the source is over or the sink breaks off.

use crate::events;
use crate::feed::{Feed, FeedEvent, Requester, other_requests};
use crate::note;
use crate::requests::Requests;
use crate::stop;
use crate::utc::Receipt;
use anyhow::{Result, bail};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::telemetry::{Event, Packet};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Time without a packet after which a board counts as silent: it sends one per second.
pub const SILENT: Duration = Duration::from_secs(3);

/// Longest wait between two checks of [`stop`] and of due requests.
const LOOK: Duration = Duration::from_millis(50);

/// Time after which damaged packets are reported even if none are missing.
const DAMAGED_ALONE: Duration = Duration::from_secs(1);

/// Longest wait for the greeting of a board that is already sending.
const GREETING: Duration = Duration::from_millis(500);

/// A feed whose requests are sent while its packets are read.
///
/// A board that is already sending is asked for its greeting. Its packets are held back until the
/// greeting arrives, because packets of a different protocol would be misread.
pub struct Listener {
    pub feed: Feed,
    requester: Requester,
    is_connected: bool,
    /// The request for the greeting.
    greeting: Requests,
    /// Time at which the greeting was requested; `None` if it is not awaited.
    joining: Option<Instant>,
    held: VecDeque<Heard>,
    /// Numbers of lost and damaged packets already reported.
    reported: (u32, u32),
    damaged_since: Option<Instant>,
    /// Name of the open port, until its first warning.
    unnamed: Option<String>,
    /// True if silence was reported.
    was_silent: bool,
}

/// Event of a feed.
pub enum Heard {
    /// A packet, with the time of its receipt if known.
    Packet(Box<Packet>, Option<Receipt>),
    /// The board of this name is connected.
    Connected(String),
    /// The board of this name is disconnected, for this reason; the feed waits for it.
    Disconnected(String, String),
    Over,
}

impl Listener {
    pub fn new(feed: Feed, requester: Requester) -> Self {
        Self {
            feed,
            requester,
            is_connected: false,
            greeting: other_requests(),
            joining: None,
            held: VecDeque::new(),
            reported: (0, 0),
            damaged_since: None,
            unnamed: None,
            was_silent: false,
        }
    }

    /// Waits for the next event, at most for `most`, and sends the request that is due.
    /// Fails if the board refuses a request or does not answer, or if the source cannot go on.
    pub fn next(&mut self, max: Duration) -> Result<Option<Heard>> {
        if self.joining.is_none()
            && let Some(heard) = self.held.pop_front()
        {
            return Ok(Some(heard));
        }
        let heard = self.hear(max)?;
        let Some(since) = self.joining else {
            return Ok(heard);
        };
        let waits = match &heard {
            Some(Heard::Packet(packet, _)) => !matches!(packet.event, Event::Hello(_)),
            Some(_) => false,
            None => true,
        };
        self.held.extend(heard);
        if waits && since.elapsed() < GREETING {
            return Ok(None);
        }
        self.joining = None;
        Ok(self.held.pop_front())
    }

    /// Asks a board that is already sending for its greeting.
    fn join(&mut self, first: &Packet) -> Result<()> {
        if matches!(first.event, Event::Hello(_)) || !self.feed.has_board() {
            return Ok(());
        }
        self.greeting = other_requests();
        self.greeting.push(Command::Greet);
        let request = self.greeting.due(self.feed.elapsed())?;
        // If nothing can be sent on the line, read it without the greeting.
        if self.feed.send(&request).is_ok() {
            self.joining = Some(Instant::now());
        }
        Ok(())
    }

    fn hear(&mut self, max: Duration) -> Result<Option<Heard>> {
        let event = self.feed.next(max)?;
        let heard = event.map(|event| match event {
            FeedEvent::Data(packet) => Heard::Packet(Box::new(packet), self.feed.receipt()),
            FeedEvent::Connected(name) => Heard::Connected(name),
            FeedEvent::Disconnected(name, why) => Heard::Disconnected(name, why),
            FeedEvent::Over => Heard::Over,
        });
        match &heard {
            Some(Heard::Packet(packet, _)) => {
                if !std::mem::replace(&mut self.is_connected, true) {
                    self.join(packet)?;
                }
                if self.greeting.answered(&packet.event).is_some() {
                    // The greeting is the only request in this queue.
                    return Ok(None);
                }
                if let Some((_, outcome)) = self.requester.answered(packet)
                    && !matches!(outcome, Outcome::Done | Outcome::DoneErased)
                {
                    bail!("{}: {}", self.feed.name(), events::outcome(&outcome));
                }
            }
            Some(Heard::Connected(name)) => self.unnamed = Some(name.clone()),
            Some(Heard::Disconnected(..)) => self.is_connected = false,
            _ => {}
        }
        if self.is_connected && self.feed.has_board() {
            self.requester.tick(&mut self.feed)?;
        }
        Ok(heard)
    }

    /// Describes packets that were newly lost or damaged or, before the first packet, other bytes
    /// on the line; `None` if there is nothing to report.
    pub fn losses(&mut self) -> Option<String> {
        let counts = self.feed.counts();
        if counts.received == 0 && self.feed.has_board() {
            if let Some(what) = self.feed.strangers() {
                let name = self.unnamed.take()?;
                return Some(format!("{name}: {what}"));
            }
            let nothing = self.feed.unanswered();
            let is_new = self.feed.elapsed() > SILENT && !self.was_silent;
            if let (true, Some(nothing), Some(name)) = (is_new, nothing, &self.unnamed) {
                self.was_silent = true;
                return Some(format!("{name}: {nothing}"));
            }
        }
        if (counts.missing, counts.damaged) == self.reported {
            return None;
        }
        // A damaged packet usually shows as a loss with the next packet, but at a wrong baud rate
        // there is no next packet.
        let since = *self.damaged_since.get_or_insert_with(Instant::now);
        if counts.missing <= self.reported.0 && since.elapsed() <= DAMAGED_ALONE {
            return None;
        }
        (self.reported, self.damaged_since) = ((counts.missing, counts.damaged), None);
        Some(format!(
            "{} packets lost, {} damaged so far",
            counts.missing, counts.damaged
        ))
    }
}

/// Takes packets, with the time of receipt if known.
pub type Sink<'a> = dyn FnMut(&Packet, Option<Receipt>) -> Result<ControlFlow<()>> + 'a;

/// Passes packets to `sink`, sends due requests, and reports connections and losses on standard
/// error. Ends when the source is over, when the sink breaks off, or when this process is asked to
/// stop. Returns the feed.
pub fn run(feed: Feed, requester: Requester, sink: &mut Sink<'_>) -> (Feed, Result<()>) {
    let mut listener = Listener::new(feed, requester);
    let ended = listen(&mut listener, sink);
    (listener.feed, ended)
}

fn listen(listener: &mut Listener, sink: &mut Sink<'_>) -> Result<()> {
    while !stop::is_requested() {
        let heard = match listener.next(LOOK) {
            // Ctrl-C reaches the emulator too, which may end first.
            Err(_) if stop::is_requested() => break,
            heard => heard?,
        };
        match heard {
            Some(Heard::Packet(packet, receipt)) if sink(&packet, receipt)?.is_break() => break,
            Some(Heard::Packet(..)) | None => {}
            Some(Heard::Connected(name)) => note!("{name}: open"),
            Some(Heard::Disconnected(name, why)) => {
                note!("{name}: {why}; waiting for the board")
            }
            Some(Heard::Over) => break,
        }
        if let Some(losses) = listener.losses() {
            note!("{losses}");
        }
    }
    Ok(())
}
