//! A finger: its source is read from the beginning to the end, and opened again after a failure if
//! that can help.

use super::name::Source;
use super::open::{self, Emulator};
use super::publisher::Publisher;
use super::url;
use crate::events::JsonLines;
use crate::events::view::{self, ConnectionState, Note};
use crate::feed::Requester;
use crate::listen::{Heard, Listener};
use crate::live::Counts;
use crate::note;
use crate::stop;
use crate::utc::Receipt;
use anyhow::Result;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait for a message.
const LOOK: Duration = Duration::from_millis(50);

/// Time between two attempts to open a source.
const AGAIN: Duration = Duration::from_secs(1);

pub struct Finger {
    name: String,
    source: Source,
    /// Whether every frame is requested.
    frames: bool,
    emulator: Option<Arc<Emulator>>,
    counts: Counts,
}

impl Finger {
    pub fn new(
        name: String,
        source: Source,
        frames: bool,
        emulator: Option<Arc<Emulator>>,
    ) -> Self {
        Self {
            name,
            source,
            frames,
            emulator,
            counts: Counts::default(),
        }
    }

    /// Publishes until the source is over or this process is to stop, and reports the counts. Gives
    /// whether anything came.
    pub fn run(mut self, mut publisher: Publisher) -> bool {
        let mut reported = String::new();
        while let Err(error) = self.read(&mut publisher) {
            let why = format!("{error:#}");
            // Ctrl-C reaches an emulator too, which may end first.
            if stop::is_requested() {
                break;
            }
            let comes_back = matches!(self.source, Source::Port(_) | Source::Url(_));
            // Once, not at every attempt.
            if why != reported {
                self.say(&format!(
                    "{why}{}",
                    if comes_back { "; trying again" } else { "" }
                ));
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
                std::thread::sleep(LOOK);
            }
        }
        let Counts {
            received,
            missing,
            damaged,
            ..
        } = self.counts;
        self.say(&format!(
            "{received} telemetry frames received, {missing} lost, {damaged} damaged"
        ));
        received > 0
    }

    fn say(&self, what: &str) {
        note!("{}: {what}", self.name);
    }

    fn read(&mut self, publisher: &mut Publisher) -> Result<()> {
        if let Source::Url(url) = &self.source {
            let mut lines = url::Lines::open(url)?;
            self.connected(url, publisher)?;
            while !stop::is_requested() {
                if let Some(line) = lines.next()? {
                    publisher.publish(line)?;
                    self.counts.received += 1;
                }
            }
            return Ok(());
        }
        let mut requester = Requester::default();
        let feed = open::feed(&self.source, self.emulator.as_deref())?;
        requester.want_raw_if(self.frames && feed.has_board());
        let mut listener = Listener::new(feed, requester);
        let before = self.counts;
        let ended = self.listen(&mut listener, publisher);
        let Counts {
            received,
            missing,
            damaged,
            stepped_back,
        } = listener.feed.counts();
        self.counts.received = before.received + received;
        self.counts.missing = before.missing + missing;
        self.counts.damaged = before.damaged + damaged;
        self.counts.stepped_back = before.stepped_back + stepped_back;
        ended
    }

    fn listen(&self, listener: &mut Listener, publisher: &mut Publisher) -> Result<()> {
        let mut lines = JsonLines::default();
        if !matches!(self.source, Source::Port(_)) {
            self.connected(&listener.feed.name(), publisher)?;
        }
        while !stop::is_requested() {
            match listener.next(LOOK)? {
                Some(Heard::Packet(packet, receipt)) => {
                    // A recording is played as if it happened now.
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
                let Counts {
                    missing, damaged, ..
                } = listener.feed.counts();
                publisher.note(Note::Lost(view::Lost {
                    at: "line".to_owned(),
                    packets: Some(missing),
                    damaged: Some(damaged),
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
