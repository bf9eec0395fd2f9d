//! Reads a finger's source to the end. A port that fails is reopened.

use super::publisher::Publisher;
use super::source::Source;
use crate::emulator::Firmware;
use crate::events::JsonLines;
use crate::events::view::{self, ConnectionState, Note};
use crate::feed::Requester;
use crate::listen::{Heard, Listener};
use crate::live::Counts;
use crate::note;
use crate::stop;
use crate::utc::Receipt;
use anyhow::Result;
use std::time::{Duration, Instant};

/// Maximum wait for a message.
const POLL: Duration = Duration::from_millis(50);

/// Interval between two attempts to open a source.
const AGAIN: Duration = Duration::from_secs(1);

pub struct Finger {
    name: String,
    source: Source,
    /// True if every frame is requested.
    frames: bool,
    firmware: Option<Firmware>,
    counts: Counts,
}

impl Finger {
    pub fn new(name: String, source: Source, frames: bool, firmware: Option<Firmware>) -> Self {
        Self {
            name,
            source,
            frames,
            firmware,
            counts: Counts::default(),
        }
    }

    /// Publishes until the source ends or the process is asked to stop, and reports the counts.
    /// Returns true if anything was received.
    pub fn run(mut self, mut publisher: Publisher) -> bool {
        let mut reported = String::new();
        while let Err(error) = self.read(&mut publisher) {
            let why = format!("{error:#}");
            if stop::is_requested() {
                break;
            }
            let comes_back = matches!(self.source, Source::Port(_));
            // Report a failure once, not at every attempt.
            if why != reported {
                let again = if comes_back { "; trying again" } else { "" };
                self.say(&format!("{why}{again}"));
                let _ = publisher
                    .note(connection(ConnectionState::Failed, None, Some(&why)))
                    .inspect_err(|error| self.say(&format!("{error:#}")));
                reported = why;
            }
            if !comes_back {
                break;
            }
            let begun = Instant::now();
            while begun.elapsed() < AGAIN && !stop::is_requested() {
                std::thread::sleep(POLL);
            }
        }
        let Counts {
            received,
            missing,
            damaged,
            ..
        } = self.counts;
        self.say(&format!(
            "{received} packets received, {missing} lost, {damaged} damaged"
        ));
        received > 0
    }

    fn say(&self, what: &str) {
        note!("{}: {what}", self.name);
    }

    fn read(&mut self, publisher: &mut Publisher) -> Result<()> {
        let feed = self.source.open(self.firmware.as_ref())?;
        let mut requester = Requester::default();
        requester.want_raw_if(self.frames && feed.has_board());
        let mut listener = Listener::new(feed, requester);
        let ended = self.listen(&mut listener, publisher);
        let counts = listener.feed.counts();
        self.counts.received += counts.received;
        self.counts.missing += counts.missing;
        self.counts.damaged += counts.damaged;
        ended
    }

    fn listen(&self, listener: &mut Listener, publisher: &mut Publisher) -> Result<()> {
        let mut lines = JsonLines::default();
        if !matches!(self.source, Source::Port(_)) {
            self.connected(&listener.feed.name(), publisher)?;
        }
        while !stop::is_requested() {
            match listener.next(POLL)? {
                Some(Heard::Packet(packet, receipt)) => {
                    // A recording is played as if it were live.
                    let receipt = if listener.feed.has_board() {
                        receipt
                    } else {
                        Some(Receipt::now(0.0))
                    };
                    publisher.publish(lines.line(&packet, receipt)?)?;
                }
                Some(Heard::Connected(name)) => self.connected(&name, publisher)?,
                Some(Heard::Disconnected(name, why)) => {
                    self.say(&format!("{name}: {why}; waiting for the board"));
                    publisher.note(connection(
                        ConnectionState::Disconnected,
                        Some(&name),
                        Some(&why),
                    ))?;
                }
                Some(Heard::Over) => {
                    let name = listener.feed.name();
                    publisher.note(connection(ConnectionState::Over, Some(&name), None))?;
                    return Ok(());
                }
                None => {}
            }
            if let Some(losses) = listener.losses() {
                self.say(&losses);
                let counts = listener.feed.counts();
                publisher.note(Note::Lost(view::Lost {
                    at: "line".to_owned(),
                    packets: Some(counts.missing),
                    damaged: Some(counts.damaged),
                    ..view::Lost::default()
                }))?;
            }
        }
        Ok(())
    }

    fn connected(&self, source: &str, publisher: &mut Publisher) -> Result<()> {
        self.say(&format!("{source}: open"));
        publisher.note(connection(ConnectionState::Connected, Some(source), None))
    }
}

fn connection(state: ConnectionState, source: Option<&str>, why: Option<&str>) -> Note {
    Note::Connection(view::Connection {
        state,
        source: source.map(str::to_owned),
        why: why.map(str::to_owned),
    })
}
