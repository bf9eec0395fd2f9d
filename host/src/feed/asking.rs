//! Orders beside the packets: sent while a feed is read, and raw frames asked for again and again.

use super::{Feed, Source};
use crate::requests::{Line, Requests};
use anyhow::Result;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::FRAME_RATE_HZ;
use ridgetone_proto::telemetry::{Event, Packet};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How often raw frames are asked for.
const RENEW: Duration = Duration::from_secs(5);

/// Frames asked for, a minute's: a board whose reader has gone falls silent by itself, and the emulated one may be some times
/// faster than this clock.
const FRAMES: u32 = (60.0 * FRAME_RATE_HZ) as u32;

/// Orders to a board whose packets go elsewhere.
#[derive(Debug)]
pub struct Asking {
    requests: Requests,
    begun: Instant,
    /// When raw frames are to be asked for; none: they are not wanted.
    renew: Option<Instant>,
}

impl Default for Asking {
    fn default() -> Self {
        Self { requests: new_orders(), begun: Instant::now(), renew: None }
    }
}

/// Orders with a first number by the clock: a board answers a number that it has just had without doing anything.
pub fn new_orders() -> Requests {
    let clock = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Requests::new((clock.as_millis() % 65_536) as u16)
}

impl Asking {
    /// Has a command sent.
    pub fn give(&mut self, command: Command) {
        self.requests.give(command);
    }

    /// Asks for raw frames from now on, or no longer.
    pub fn want_raw(&mut self, wanted: bool) {
        self.renew = wanted.then(Instant::now);
        if !wanted {
            self.requests.give(Command::Raw { frames: 0 });
        }
    }

    /// Sends what is due. To be called often while the board is there.
    ///
    /// # Errors
    /// The board does not answer, or the line fails; nothing is asked for any more then.
    pub fn tick<S: Source>(&mut self, feed: &mut Feed<S>) -> Result<()> {
        let now = Instant::now();
        if self.requests.are_done()
            && let Some(due) = self.renew.filter(|due| *due <= now)
        {
            self.renew = Some(due.max(now) + RENEW);
            self.requests.give(Command::Raw { frames: FRAMES });
        }
        let sent = self.requests.due(self.begun.elapsed()).and_then(|bytes| match bytes.as_slice() {
            [] => Ok(()),
            bytes => feed.send(bytes),
        });
        if sent.is_err() {
            (self.requests, self.renew) = (new_orders(), None);
        }
        sent
    }

    /// Takes a packet; gives an answered command, and the answer.
    pub fn hear(&mut self, packet: &Packet) -> Option<(Command, Outcome)> {
        if let (Event::Hello(_), 0, Some(renew)) = (&packet.event, packet.sequence, &mut self.renew) {
            // It has started anew, and has forgotten.
            *renew = Instant::now();
        }
        self.requests.hear(&packet.event)
    }
}

impl<S: Source> Line for Feed<S> {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        Feed::send(self, bytes)
    }

    fn receive(&mut self, most: Duration) -> Result<Option<Packet>> {
        match self.next(most)? {
            Some(super::Happening::Packet(packet)) => Ok(Some(packet)),
            _ => Ok(None),
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }
}
