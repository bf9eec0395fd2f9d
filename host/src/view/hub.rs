//! Keeps the state for the pages: a new page gets the whole state; all pages then get changes ten
//! times a second.
//!
//! The thread that processes packets never waits for a page. Each page has a short queue. If a page
//! is too slow, its queue is dropped and it gets the whole state again, with the number of updates
//! that it missed.

use super::message::{Common, Message, STREAM, State, Update};
use super::recorder::{Latest, Recorder};
use super::status;
use crate::analysis::{Curves, Spectrum, curves, spectrum};
use crate::digits::seconds;
use crate::events::JsonLines;
use crate::events::view::Estimate;
use crate::feed::{Feed, FeedEvent, Following, RawFrames, SettingsReply};
use crate::live::{Live, Log, POINTS, STRIP_FRAMES, Strips};
use crate::remarks::{phrases, remedy};
use crate::settings_form;
use crate::static_image::PLACES;
use anyhow::{Result, ensure};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::broadcast::{self, Receiver, Sender};

/// Time between two updates.
pub const UPDATE_EVERY: Duration = Duration::from_millis(100);

/// Length of a page's queue: six seconds of updates.
const QUEUE: usize = 64;

/// Length of a queue of packets: four seconds of raw frames.
const PACKETS: usize = 1024;

/// Time between two spectra.
const SPECTRUM_EVERY: Duration = Duration::from_millis(250);

/// Time after a request for the state during which the state counts as watched.
const LOOKED: Duration = Duration::from_secs(3);

/// Approximate duration of a frame, seconds.
const FRAME_S: f64 = 0.004;

pub struct Hub {
    inner: Mutex<Inner>,
    /// Held while waiting for `inner`, so that threads lock `inner` in turn.
    turn: Mutex<()>,
    updates: Sender<Message>,
    /// Single packets, as with `--json`.
    packets: Sender<Arc<str>>,
}

#[derive(Default)]
struct Inner {
    live: Live,
    /// Reason why there are no raw frames, if any.
    no_raw: Option<String>,
    /// True if there is a board that takes settings.
    can_set: bool,
    /// Settings that a page has sent, for [`Hub::wanted`].
    wanted: Option<Settings>,
    settings_reply: Option<SettingsReply>,
    /// A board that a page has connected, for [`Hub::connected`].
    board: Option<Feed>,
    recorder: Option<Recorder>,
    latest: Latest,
    /// Time of the latest request for the state.
    looked: Option<Instant>,
    /// Arrival of the latest packet.
    received: Option<Instant>,
    /// Estimates and frames since the latest update.
    points: Vec<Estimate>,
    frames: Strips,
    /// Log and restarts as of the latest update.
    sent_log: Log,
    sent_restarts: u32,
    spectrum: Option<Spectrum>,
    spectrum_made: Option<Instant>,
    /// True if raw frames arrived after the spectrum was made.
    spectrum_is_old: bool,
    curves: Option<Curves>,
    /// Device time of the estimate that the curves show.
    curves_of_us: Option<u64>,
    number: u64,
    json: JsonLines,
    greeting: Option<Arc<str>>,
}

impl Hub {
    pub fn new(live: Live) -> Self {
        let inner = Inner {
            sent_log: live.log.clone(),
            sent_restarts: live.now.restarts,
            live,
            spectrum_made: Some(Instant::now()),
            ..Inner::default()
        };
        Self {
            inner: Mutex::new(inner),
            turn: Mutex::new(()),
            updates: broadcast::channel(QUEUE).0,
            packets: broadcast::channel(PACKETS).0,
        }
    }

    pub fn take(&self, event: Option<&FeedEvent<Packet>>, following: &mut Following) {
        let inner = &mut *self.lock();
        following.fold(event, &mut inner.live);
        inner.no_raw = status::no_raw(&following.raw);
        inner.can_set = following.has_board() && inner.live.hello().is_some();
        inner.settings_reply.clone_from(&following.settings_reply);
        let Some(FeedEvent::Data(packet)) = event else {
            return;
        };
        inner.received = Some(Instant::now());
        inner.latest.push(packet, following.receipt());
        if let Some(recorder) = &mut inner.recorder
            && let Err(error) = recorder.keep(packet, following.receipt(), inner.live.hello())
        {
            inner.live.note(format!("{error:#}"));
            inner.recorder = None;
        }
        if let Ok(line) = inner.json.line(packet, following.receipt()) {
            let line: Arc<str> = (line + "\n").into();
            if matches!(packet.event, Event::Hello(_)) {
                inner.greeting = Some(Arc::clone(&line));
            }
            // Sending fails if nobody listens, which is not an error.
            let _ = self.packets.send(line);
        }
        match packet.event {
            Event::Estimate(_) => inner
                .points
                .extend(inner.live.history.iter().next_back().cloned()),
            Event::Raw(_) => inner
                .live
                .strips
                .iter()
                .next_back()
                .into_iter()
                .for_each(|f| inner.frames.push(*f)),
            _ => {}
        }
    }

    /// Forgets the relation of the board's clock to UTC, because the clock was stopped.
    pub fn forget_clock(&self) {
        self.lock().json = JsonLines::default();
    }

    /// Sends new data to all pages. Call this every [`UPDATE_EVERY`].
    pub fn publish(&self) -> Result<()> {
        self.send_new(&mut self.lock())
    }

    fn send_new(&self, inner: &mut Inner) -> Result<()> {
        inner.number += 1;
        let analysed = inner.analyse();
        let message = if inner.live.now.restarts == inner.sent_restarts {
            Message {
                kind: "update",
                json: inner.update(analysed)?.into(),
            }
        } else {
            // The time axis has restarted, so the data on the pages is obsolete.
            Message {
                kind: "state",
                json: inner.state(0)?.into(),
            }
        };
        (inner.points, inner.frames) = Default::default();
        (inner.sent_log, inner.sent_restarts) = (inner.live.log.clone(), inner.live.now.restarts);
        // Sending fails if no page is open, which is not an error.
        let _ = self.updates.send(message);
        Ok(())
    }

    /// Returns the whole state for a new page, and the queue of all later updates.
    pub fn join(&self, missed: u64) -> Result<(Message, Receiver<Message>)> {
        let mut inner = self.lock();
        inner.looked = Some(Instant::now());
        // Hold one lock, so that the state and the queue neither overlap nor leave a gap.
        self.send_new(&mut inner)?;
        let json = inner.state(missed)?.into();
        let kind = "state";
        Ok((Message { kind, json }, self.updates.subscribe()))
    }

    /// Forgets all received data except settings and health, for all pages.
    pub fn clear(&self) {
        let mut inner = self.lock();
        inner.live.clear();
        (inner.points, inner.frames) = Default::default();
        // The next message is a whole state.
        inner.sent_restarts = inner.live.now.restarts.wrapping_sub(1);
    }

    /// Returns the latest greeting, and the queue of all later packets.
    pub fn join_packets(&self) -> (Option<Arc<str>>, Receiver<Arc<str>>) {
        let inner = self.lock();
        (inner.greeting.clone(), self.packets.subscribe())
    }

    /// Takes changed settings from a page, as a JSON object. Errors are messages for people.
    pub fn set(&self, json: &str) -> Result<()> {
        let mut inner = self.lock();
        ensure!(inner.can_set, "there is no board that takes settings");
        inner.wanted = Some(settings_form::with_json(&inner.live.settings(), json)?);
        inner.settings_reply = None;
        Ok(())
    }

    /// Takes the settings that a page has requested, if any.
    pub fn wanted(&self) -> Option<Settings> {
        self.lock().wanted.take()
    }

    /// Takes a board that a page has connected, which replaces the current source.
    pub fn connect(&self, board: Feed) {
        self.lock().board = Some(board);
    }

    /// Takes the board that a page has connected, if any, and forgets all earlier data.
    pub fn connected(&self) -> Option<Feed> {
        let mut inner = self.lock();
        let board = inner.board.take()?;
        *inner = Inner {
            live: Live::new(board.name()),
            looked: inner.looked,
            number: inner.number,
            // The next message is a whole state.
            sent_restarts: u32::MAX,
            ..Inner::default()
        };
        Some(board)
    }

    /// Begins to record to a new file; if already recording, stops and returns the recorder.
    pub fn record(&self, path: impl FnOnce() -> PathBuf) -> Option<Recorder> {
        let inner = &mut *self.lock();
        let ended = inner.recorder.take();
        if ended.is_none() {
            inner.recorder = Some(Recorder::new(path(), &inner.live.now.source));
        }
        ended
    }

    pub fn record_latest(&self, path: PathBuf) -> Result<Recorder> {
        let inner = self.lock();
        inner
            .latest
            .recorder(path, &inner.live.now.source, inner.live.hello())
    }

    /// True if a page or a program is watching, or a recording is running.
    pub fn is_watched(&self) -> bool {
        let inner = self.lock();
        let looked = inner.looked.is_some_and(|looked| looked.elapsed() < LOOKED);
        looked
            || inner.recorder.is_some()
            || self.updates.receiver_count() + self.packets.receiver_count() > 0
    }

    /// Locks `inner` in turn. A free mutex goes to the first thread that asks. On a busy computer
    /// this would always be the processing thread, before a waiting page has been woken.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        // A panic under the lock leaves a state that can still be shown.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns the whole state for looking back at a run.
pub fn state_of(live: Live) -> Result<String> {
    let (spectrum, curves) = (spectrum(&live), curves(&live));
    let no_raw = live
        .strips
        .is_empty()
        .then(|| status::no_raw(&RawFrames::Unavailable))
        .flatten();
    Inner {
        live,
        spectrum,
        curves,
        no_raw,
        received: Some(Instant::now()),
        ..Inner::default()
    }
    .state(0)
}

/// Changes due to an analysis of the latest frames.
#[derive(Clone, Copy)]
struct Analysed {
    has_new_spectrum: bool,
    has_new_curves: bool,
}

impl Inner {
    /// Updates spectrum and curves if they are due.
    fn analyse(&mut self) -> Analysed {
        if self.live.strips.is_empty() {
            self.curves_of_us = None;
            return Analysed {
                has_new_spectrum: self.spectrum.take().is_some(),
                has_new_curves: self.curves.take().is_some(),
            };
        }
        self.spectrum_is_old |= !self.frames.is_empty();
        let is_due = self.spectrum_is_old
            && self
                .spectrum_made
                .is_none_or(|made| made.elapsed() >= SPECTRUM_EVERY);
        if is_due {
            (self.spectrum, self.spectrum_made) = (spectrum(&self.live), Some(Instant::now()));
            self.spectrum_is_old = false;
        }
        let (of_us, newest) = (
            self.live.estimate().map(|found| found.t_us),
            self.live.strips.iter().next_back(),
        );
        // An estimate may arrive before the last frames of its window.
        let has_all = of_us
            .zip(newest)
            .is_none_or(|(of_us, newest)| newest.t_s + FRAME_S > seconds(of_us));
        let is_new = of_us != self.curves_of_us && has_all;
        if is_new {
            (self.curves, self.curves_of_us) = (curves(&self.live), of_us);
        }
        Analysed {
            has_new_spectrum: is_due,
            has_new_curves: is_new,
        }
    }

    fn common(&self) -> Common<'_> {
        let status = status::status(&self.live, self.received.map(|received| received.elapsed()));
        let latest = self.live.estimate();
        let remedy = latest
            .and_then(|latest| remedy(latest.status))
            .map(str::to_owned);
        let remarks = remedy
            .into_iter()
            .chain(latest.map(phrases).unwrap_or_default())
            .collect();
        Common {
            update: self.number,
            status,
            no_raw: self.no_raw.as_deref(),
            remarks,
            can_set: self.can_set,
            settings_reply: self.settings_reply.as_ref(),
            recording_s: self.recorder.as_ref().map(Recorder::length_s),
        }
    }

    fn state(&self, missed: u64) -> Result<String> {
        Ok(serde_json::to_string(&State {
            missed,
            common: self.common(),
            stream: STREAM,
            version: env!("CARGO_PKG_VERSION"),
            places: PLACES,
            settings_form: settings_form::entries(),
            points_max: POINTS,
            frames_max: STRIP_FRAMES,
            live: &self.live,
            spectrum: self.spectrum.as_ref(),
            curves: self.curves.as_ref(),
        })?)
    }

    fn update(&self, analysed: Analysed) -> Result<String> {
        Ok(serde_json::to_string(&Update {
            common: self.common(),
            live: &self.live.now,
            points: &self.points,
            strips: &self.frames,
            log: (self.live.log != self.sent_log).then_some(&self.live.log),
            spectrum: analysed.has_new_spectrum.then_some(self.spectrum.as_ref()),
            curves: analysed.has_new_curves.then_some(self.curves.as_ref()),
        })?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

    #[test]
    fn a_thread_that_folds_without_a_rest_lets_a_page_in_that_waits() {
        let hub = Hub::new(Live::new("a test"));
        let rounds = (0..10).filter(|_| {
            let is_in = AtomicBool::new(false);
            std::thread::scope(|scope| {
                let folding = hub.lock();
                scope.spawn(|| {
                    let _page = hub.lock();
                    is_in.store(true, SeqCst);
                });
                // By now the page's thread is waiting for the lock, unless the computer is busy.
                std::thread::sleep(Duration::from_millis(50));
                drop(folding);
                let _folding = hub.lock();
                is_in.load(SeqCst)
            })
        });
        let first = rounds.count();
        assert!(first > 5, "the page was next in {first} of 10 rounds");
    }
}
