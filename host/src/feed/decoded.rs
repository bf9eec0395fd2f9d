//! Decodes packets from the bytes of a source.

use super::pace::Pace;
use super::source::{FeedEvent, Source};
use super::strangers::Strangers;
use crate::live::Counts;
use crate::recording::Keep;
use crate::utc::Receipt;
use anyhow::{Context, Result, bail};
use ridgetone_proto::telemetry::{Decoder, PROTOCOL, Packet};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

pub struct Feed {
    source: Box<dyn Source + Send>,
    decoder: Decoder,
    received: u64,
    /// Number of the latest packet, so that a packet that arrives twice is returned once.
    latest: Option<u16>,
    bytes: u64,
    strangers: Strangers,
    queue: VecDeque<(FeedEvent<Packet>, Option<Receipt>)>,
    receipt: Option<Receipt>,
    is_over: bool,
    pace: Option<Pace>,
    recording: Option<Box<dyn Keep + Send>>,
    opened: Instant,
}

impl Feed {
    /// Makes a feed from a source that has not been read yet.
    pub fn new(source: impl Source + Send + 'static) -> Self {
        Self {
            source: Box::new(source),
            decoder: Decoder::new(),
            received: 0,
            latest: None,
            bytes: 0,
            strangers: Strangers::default(),
            queue: VecDeque::new(),
            receipt: None,
            is_over: false,
            pace: None,
            recording: None,
            opened: Instant::now(),
        }
    }

    /// Delays packets until their device time, because a recording has all of them at once.
    #[must_use]
    pub fn paced(self, pace: Pace) -> Self {
        Self {
            pace: Some(pace),
            ..self
        }
    }

    /// Writes all bytes to `recording` as they arrive.
    #[must_use]
    pub fn recorded(self, recording: Box<dyn Keep + Send>) -> Self {
        Self {
            recording: Some(recording),
            ..self
        }
    }

    /// Waits for the next event, at most for `most`. After a disconnection the gap in the sequence
    /// numbers shows how many packets are missing. Fails if the board speaks a different protocol,
    /// the source cannot go on, or the recording cannot be written.
    pub fn next(&mut self, max: Duration) -> Result<Option<FeedEvent<Packet>>> {
        let begun = Instant::now();
        loop {
            let left = max.saturating_sub(begun.elapsed());
            if let Some((event, receipt)) = self.queue.pop_front() {
                let wait = match (&mut self.pace, &event) {
                    (Some(pace), FeedEvent::Data(packet)) => pace.wait(packet, Instant::now()),
                    _ => Duration::ZERO,
                };
                std::thread::sleep(wait.min(left));
                if wait <= left {
                    self.receipt = receipt;
                    return Ok(Some(event));
                }
                self.queue.push_front((event, receipt));
                return Ok(None);
            }
            if self.is_over {
                std::thread::sleep(left);
                return Ok(None);
            }
            match self.source.next(left)? {
                Some(event) => self.take(event)?,
                None if left.is_zero() => return Ok(None),
                None => {}
            }
        }
    }

    fn take(&mut self, event: FeedEvent<Vec<u8>>) -> Result<()> {
        match event {
            FeedEvent::Connected(name) => self.queue.push_back((FeedEvent::Connected(name), None)),
            FeedEvent::Data(bytes) => self.decode(&bytes, self.source.receipt())?,
            FeedEvent::Disconnected(name, why) => {
                // End a frame that was cut off: it would spoil the first one after the
                // reconnection.
                self.decode(&[0], self.source.receipt())?;
                self.queue
                    .push_back((FeedEvent::Disconnected(name, why), None));
            }
            FeedEvent::Over => {
                self.is_over = true;
                self.queue.push_back((FeedEvent::Over, None));
            }
        }
        if let Some(protocol) = self.decoder.foreign {
            let name = self.name();
            if !self.source.has_board() {
                bail!(
                    "{name}: holds protocol {protocol}, this command reads protocol {PROTOCOL}: open it with the version that wrote it"
                );
            }
            bail!(
                "{name}: the board speaks protocol {protocol}, this command {PROTOCOL}: build both from one version"
            );
        }
        Ok(())
    }

    fn decode(&mut self, bytes: &[u8], receipt: Option<Receipt>) -> Result<()> {
        self.bytes += bytes.len() as u64;
        if self.received == 0 {
            self.strangers.take(bytes);
        }
        if let Some(recording) = &mut self.recording {
            recording.keep(bytes, receipt).context("the recording")?;
        }
        for byte in bytes {
            let before = self.decoder.stepped_back;
            let Some(packet) = self.decoder.push(*byte) else {
                continue;
            };
            let is_before_once_more = self.latest == Some(packet.sequence);
            self.latest = Some(packet.sequence);
            if is_before_once_more && self.decoder.stepped_back != before {
                continue;
            }
            self.received += 1;
            self.queue.push_back((FeedEvent::Data(packet), receipt));
        }
        Ok(())
    }

    /// Returns when the latest packet from [`next`](Self::next) was received; `None` for a
    /// recording without times of receipt.
    pub fn receipt(&self) -> Option<Receipt> {
        self.receipt
    }

    /// Returns the time that a byte takes on the line, seconds.
    pub fn byte_s(&self) -> f64 {
        self.source.byte_s()
    }

    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.source.send(bytes)
    }

    /// See [`Source::idle`].
    pub fn idle(&mut self, idle: bool) -> bool {
        self.source.idle(idle)
    }

    pub fn has_board(&self) -> bool {
        self.source.has_board()
    }

    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Describes received bytes that are not packets: text, or a wrong baud rate.
    pub fn strangers(&self) -> Option<String> {
        let what = || self.strangers.what();
        (self.received == 0 && self.has_board())
            .then(what)
            .flatten()
    }

    /// Describes what arrives from a board that does not answer; `None` if packets do.
    pub fn unanswered(&self) -> Option<String> {
        let nothing = || "nothing arrives: is the board powered, and its TX on this port?".into();
        let is_silent = self.bytes == 0 && self.has_board();
        self.strangers().or_else(|| is_silent.then(nothing))
    }

    pub fn name(&self) -> String {
        self.source.name()
    }

    pub fn elapsed(&self) -> Duration {
        self.opened.elapsed()
    }

    pub fn counts(&self) -> Counts {
        Counts::of(&self.decoder, self.received)
    }
}
