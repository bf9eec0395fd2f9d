//! Sends requests to a feed's board, and either waits for the reply or reads packets
//! meanwhile.

use super::decoded::Feed;
use super::source::FeedEvent;
use crate::requests::{PATIENCE, Requests};
use anyhow::{Result, anyhow};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Packet, Starts};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time between two requests for raw frames.
const RENEW: Duration = Duration::from_secs(5);

/// Number of frames per request for raw frames: a minute's worth, so that a board whose reader is
/// gone stops sending. The emulated board may run several times faster than this clock.
const FRAMES: u32 = (60.0 * FRAME_RATE_HZ) as u32;

/// Makes requests whose first number comes from the clock: if a board receives the number of its
/// latest reply again, it only repeats this reply.
pub fn new_requests() -> Requests {
    Requests::new(clock_number())
}

/// Makes a second series of requests, whose numbers do not collide with those of [`new_requests`]
/// for half a minute.
pub fn other_requests() -> Requests {
    Requests::new(clock_number() ^ 0x8000)
}

fn clock_number() -> u16 {
    let clock = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    (clock.as_millis() % 65_536) as u16
}

/// Sends a command and waits for its outcome; all packets that arrive meanwhile go to `sink`.
pub fn request(
    feed: &mut Feed,
    requests: &mut Requests,
    command: Command,
    sink: &mut dyn FnMut(&Packet),
) -> Result<Outcome> {
    requests.push(command);
    loop {
        let bytes = requests
            .due(feed.elapsed())
            .map_err(|error| unanswered(feed, error))?;
        if !bytes.is_empty() {
            feed.send(&bytes)?;
        }
        if feed.strangers().is_some() {
            return Err(unanswered(feed, anyhow!("no answer")));
        }
        if let Some(FeedEvent::Data(packet)) = feed.next(PATIENCE / 10)? {
            sink(&packet);
            if let Some((_, outcome)) = requests.answered(&packet.event) {
                return Ok(outcome);
            }
        }
    }
}

/// Returns the reason why a board does not answer: something else is on the line, or nothing.
fn unanswered(feed: &Feed, error: anyhow::Error) -> anyhow::Error {
    match feed.unanswered() {
        Some(what) => anyhow!("{}: {what}", feed.name()),
        None => error,
    }
}

/// Requests to a board whose packets are read elsewhere.
#[derive(Debug)]
pub struct Requester {
    requests: Requests,
    /// Time of the next request for raw frames; `None` if nobody wants them.
    renew: Option<Instant>,
    starts: Starts,
}

impl Default for Requester {
    fn default() -> Self {
        Self {
            requests: new_requests(),
            renew: None,
            starts: Starts::new(),
        }
    }
}

impl Requester {
    /// Puts settings into force first, without storing them.
    pub fn with_settings(settings: Option<Settings>) -> Self {
        let mut requester = Self::default();
        if let Some(settings) = settings {
            requester.push(Command::Set {
                settings,
                keep: false,
            });
        }
        requester
    }

    pub fn push(&mut self, command: Command) {
        self.requests.push(command);
    }

    /// Requests raw frames from now on, or stops them.
    pub fn want_raw(&mut self, wanted: bool) {
        self.renew = wanted.then(Instant::now);
        if !wanted {
            self.requests.push(Command::Raw { frames: 0 });
        }
    }

    /// Requests raw frames from now on if `wanted`; otherwise leaves the board unchanged.
    pub fn want_raw_if(&mut self, wanted: bool) {
        if wanted {
            self.want_raw(true);
        }
    }

    /// Sends the request that is due. Call it often while the board is connected.
    /// Fails if the board does not answer, or the line fails; all requests are dropped then.
    pub fn tick(&mut self, feed: &mut Feed) -> Result<()> {
        let now = Instant::now();
        if self.requests.are_done() && self.renew.is_some_and(|due| due <= now) {
            self.renew = Some(now + RENEW);
            self.requests.push(Command::Raw { frames: FRAMES });
        }
        let sent = self
            .requests
            .due(feed.elapsed())
            .map_err(|error| unanswered(feed, error))
            .and_then(|bytes| match bytes.as_slice() {
                [] => Ok(()),
                bytes => feed.send(bytes),
            });
        if sent.is_err() {
            *self = Self::default();
        }
        sent
    }

    /// Takes a packet; returns the command that it answers, and the outcome.
    pub fn answered(&mut self, packet: &Packet) -> Option<(Command, Outcome)> {
        if self.starts.take(&packet.event)
            && let Some(renew) = &mut self.renew
        {
            // The board has restarted, so it no longer sends raw frames.
            *renew = Instant::now();
        }
        self.requests.answered(&packet.event)
    }
}
