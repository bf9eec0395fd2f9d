//! What the pages are told: everything to one that comes, and what is new to all of them, ten times a second.
//!
//! Whoever folds the packets never waits for a page. Each page has a short queue; one that is too slow for it loses what is
//! in it, is told everything anew, and how many updates it has missed.

use super::words;
use crate::feed::{Following, Happening};
use crate::live::analysis::{Curves, Spectrum, curves, spectrum};
use crate::live::{Frame, Live, POINTS, Point, STRIP_FRAMES, Strips};
use crate::static_image::{PLACES, SIDE};
use anyhow::Result;
use ridgetone_proto::telemetry::Event;
use serde::Serialize;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::broadcast::{self, Receiver, Sender};

/// Between two updates.
pub const BEAT: Duration = Duration::from_millis(100);

/// Updates that wait for a page: those of six seconds.
const QUEUE: usize = 64;

/// Between two spectra.
const SPECTRUM_EVERY: Duration = Duration::from_millis(250);

/// A frame, seconds, roughly.
const FRAME_S: f64 = 0.004;

/// Something that a page is told.
#[derive(Clone, Debug)]
pub struct Message {
    /// `state`: everything; `update`: what is new.
    pub kind: &'static str,
    /// JSON on one line.
    pub json: Arc<str>,
}

/// What all pages show.
pub struct Hub {
    inner: Mutex<Inner>,
    updates: Sender<Message>,
}

struct Inner {
    live: Live,
    /// Why there are no raw frames, if that is known.
    no_raw: Option<String>,
    heard: Option<Instant>,
    /// What has come since the latest update.
    points: Vec<Point>,
    frames: Vec<Frame>,
    log_told: VecDeque<String>,
    restarts_told: u32,
    /// Device time of the estimate whose curves were told.
    curves_of_us: Option<u64>,
    /// What was made of the raw frames, when, and whether some have come since.
    spectrum: Option<Spectrum>,
    spectrum_made: Instant,
    spectrum_is_old: bool,
    curves: Option<Curves>,
    number: u64,
}

/// Everything.
#[derive(Serialize)]
struct State<'a> {
    update: u64,
    missed: u64,
    version: &'static str,
    places: [[usize; SIDE]; SIDE],
    points_most: usize,
    frames_most: usize,
    words: String,
    no_raw: Option<&'a str>,
    live: &'a Live,
    spectrum: Option<&'a Spectrum>,
    curves: Option<&'a Curves>,
}

/// What is new.
#[derive(Serialize)]
struct Update<'a> {
    update: u64,
    words: String,
    no_raw: Option<&'a str>,
    live: Live,
    points: &'a [Point],
    strips: Strips,
    log: Option<&'a VecDeque<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spectrum: Option<Option<&'a Spectrum>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    curves: Option<Option<&'a Curves>>,
}

impl Hub {
    /// Of what is known so far.
    pub fn new(live: Live) -> Self {
        let restarts_told = live.restarts;
        let inner = Inner {
            log_told: live.log.clone(),
            live,
            no_raw: None,
            heard: None,
            points: Vec::new(),
            frames: Vec::new(),
            restarts_told,
            curves_of_us: None,
            spectrum: None,
            spectrum_made: Instant::now(),
            spectrum_is_old: false,
            curves: None,
            number: 0,
        };
        Self { inner: Mutex::new(inner), updates: broadcast::channel(QUEUE).0 }
    }

    /// Folds what has happened, if anything has.
    pub fn take(&self, happening: Option<&Happening>, following: &mut Following) {
        let mut inner = self.lock();
        following.fold(happening, &mut inner.live);
        inner.no_raw = words::no_raw(following.raw());
        let Some(Happening::Packet(packet)) = happening else { return };
        inner.heard = Some(Instant::now());
        match packet.event {
            Event::Estimate(_) => {
                let point = inner.live.history.points().next_back().copied();
                inner.points.extend(point);
            }
            Event::Raw(_) => {
                let frame = inner.live.strips.frames().next_back().copied();
                inner.frames.extend(frame);
            }
            _ => {}
        }
    }

    /// Tells all pages what is new. To be called every [`BEAT`].
    ///
    /// # Errors
    /// It cannot be written as JSON; there is no such thing in it.
    pub fn publish(&self) -> Result<()> {
        self.tell_new(&mut self.lock())
    }

    fn tell_new(&self, inner: &mut Inner) -> Result<()> {
        inner.number += 1;
        let analysed = inner.analyse();
        let message = if inner.live.restarts == inner.restarts_told {
            Message { kind: "update", json: inner.update(analysed)?.into() }
        } else {
            // A new axis: nothing of what pages have fits it.
            Message { kind: "state", json: inner.state(0)?.into() }
        };
        (inner.points, inner.frames) = (Vec::new(), Vec::new());
        (inner.log_told, inner.restarts_told) = (inner.live.log.clone(), inner.live.restarts);
        // Nobody listens: that is no error.
        let _ = self.updates.send(message);
        Ok(())
    }

    /// Everything that is known, for a page that comes, and all updates from then on.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn join(&self, missed: u64) -> Result<(Message, Receiver<Message>)> {
        let mut inner = self.lock();
        // Under one lock with the rest, so that nothing comes twice and nothing is left out.
        self.tell_new(&mut inner)?;
        let updates = self.updates.subscribe();
        Ok((Message { kind: "state", json: inner.state(missed)?.into() }, updates))
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // Whoever panicked with it left a model that is as good as any.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether the spectrum and the curves are new.
type Analysed = (bool, bool);

impl Inner {
    fn analyse(&mut self) -> Analysed {
        if self.live.strips.is_empty() {
            let had = (self.spectrum.take().is_some(), self.curves.take().is_some());
            self.curves_of_us = None;
            return had;
        }
        self.spectrum_is_old |= !self.frames.is_empty();
        let is_due = self.spectrum_is_old && self.spectrum_made.elapsed() >= SPECTRUM_EVERY;
        if is_due {
            (self.spectrum, self.spectrum_made) = (spectrum(&self.live), Instant::now());
            self.spectrum_is_old = false;
        }
        let (of_us, newest) = (self.live.estimate().map(|found| found.t_us), self.live.strips.frames().next_back());
        // An estimate may overtake the last frames of its window.
        let has_all = of_us.zip(newest).is_none_or(|(of_us, newest)| newest.t_s + FRAME_S > of_us as f64 / 1e6);
        let is_new = of_us != self.curves_of_us && has_all;
        if is_new {
            (self.curves, self.curves_of_us) = (curves(&self.live), of_us);
        }
        (is_due, is_new)
    }

    fn words(&self) -> String {
        words::say(&self.live, self.heard.map(|heard| heard.elapsed()))
    }

    fn state(&self, missed: u64) -> Result<String> {
        let (no_raw, words, live) = (self.no_raw.as_deref(), self.words(), &self.live);
        Ok(serde_json::to_string(&State {
            update: self.number,
            missed,
            version: env!("CARGO_PKG_VERSION"),
            places: PLACES,
            points_most: POINTS,
            frames_most: STRIP_FRAMES,
            words,
            no_raw,
            live,
            spectrum: self.spectrum.as_ref(),
            curves: self.curves.as_ref(),
        })?)
    }

    fn update(&self, (spectrum, curves): Analysed) -> Result<String> {
        let mut strips = Strips::default();
        self.frames.iter().for_each(|frame| strips.add(*frame));
        let log = (self.live.log != self.log_told).then_some(&self.live.log);
        let (no_raw, words, live) = (self.no_raw.as_deref(), self.words(), self.live.without_rows());
        Ok(serde_json::to_string(&Update {
            update: self.number,
            words,
            no_raw,
            live,
            points: &self.points,
            strips,
            log,
            spectrum: spectrum.then_some(self.spectrum.as_ref()),
            curves: curves.then_some(self.curves.as_ref()),
        })?)
    }
}
