//! `detect`: conversions in; events, and windows that are due, out.

use super::outbox::{Outbox, post};
use super::shared::{PACKETS, Platform, Shared, Task};
use crate::detector::Detector;
use crate::frame::TimedConversion;
use crate::ring::Ring;
use crate::window::Window;
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::{Consumer, Producer};
use ridgetone_proto::telemetry::{Event, Span};

/// What the task owns.
pub struct Detect<'a> {
    samples: Consumer<'a, TimedConversion>,
    windows: Producer<'a, Window>,
    is_greeted: bool,
}

impl<'a> Detect<'a> {
    /// `samples`: from `drdy`; `windows`: to `fit`.
    pub const fn new(samples: Consumer<'a, TimedConversion>, windows: Producer<'a, Window>) -> Self {
        Self { samples, windows, is_greeted: false }
    }

    /// The next conversion in the queue.
    pub fn next(&self) -> Option<&TimedConversion> {
        self.samples.peek()
    }

    /// Runs after each conversion, and twice a second without one.
    pub fn run<P: Platform>(
        &mut self,
        detector: &mut Detector,
        ring: &mut Ring,
        outbox: &mut Outbox<PACKETS>,
        shared: &Shared<P>,
    ) {
        let Shared { platform, diagnostics, .. } = shared;
        let mut emit = |event: Event| post(outbox, event, shared);
        let mut due = |window| admit(window, &mut self.windows, shared);
        if !core::mem::replace(&mut self.is_greeted, true) {
            emit(detector.hello());
        }
        while let Some(conversion) = self.samples.dequeue() {
            detector.push(conversion, ring, diagnostics, &mut emit, &mut due);
        }
        if shared.look.swap(false, Relaxed) {
            detector.look(platform.now_us(), diagnostics, &mut emit);
        }
        if platform.has_ended() && !shared.finished.load(Relaxed) {
            detector.finish(ring, diagnostics, &mut emit, &mut due);
            shared.finished.store(true, Relaxed);
        }
        shared.liveness.detected.bump();
    }
}

/// Where windows wait for the fit.
pub trait WindowQueue {
    /// Whether the fit keeps up: a hop that waits now is fitted before the next hop.
    fn fit_keeps_up(&self) -> bool;

    /// False if there is no place.
    fn put(&mut self, window: Window) -> bool;
}

impl WindowQueue for Producer<'_, Window> {
    fn fit_keeps_up(&self) -> bool {
        self.is_empty()
    }

    fn put(&mut self, window: Window) -> bool {
        self.enqueue(window).is_ok()
    }
}

/// Gives a window that is due to the fit, or counts it as skipped. A hop is fitted only if the fit keeps up; a whole slide
/// always is.
pub fn admit<P: Platform>(window: Window, windows: &mut impl WindowQueue, shared: &Shared<P>) {
    let is_wanted = window.span == Span::Slide || windows.fit_keeps_up();
    if is_wanted && windows.put(window) {
        shared.liveness.fits_due.bump();
    } else {
        shared.diagnostics.hops_skipped.add(1);
    }
    // An estimate is reported only if the chip is known to have been well until the window's end.
    shared.check.store(true, Relaxed);
    P::pend(shared, Task::Fit);
}
