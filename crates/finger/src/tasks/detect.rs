//! `detect`: turns conversions into events and due windows.

use super::outbox::Outbox;
use super::shared::{Platform, Shared, Task};
use crate::assembler::Next;
use crate::detector::{Detector, Outputs};
use crate::frame::TimedConversion;
use crate::ring::Ring;
use crate::samples::SampleQueue;
use crate::window::Window;
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Producer;
use ridgetone_proto::telemetry::{Event, Span};

/// State that only this task uses.
pub struct Detect<'a> {
    samples: &'a SampleQueue,
    windows: Producer<'a, Window>,
    is_greeted: bool,
}

impl<'a> Detect<'a> {
    /// `samples`: from `drdy`; `windows`: to `fit`.
    pub const fn new(samples: &'a SampleQueue, windows: Producer<'a, Window>) -> Self {
        Self {
            samples,
            windows,
            is_greeted: false,
        }
    }

    /// The next conversion in the queue.
    pub fn next(&self) -> Option<TimedConversion> {
        self.samples.peek()
    }

    /// Runs after each scan, after an event that interrupts a scan, and twice a second without
    /// scans.
    pub fn run<P: Platform>(
        &mut self,
        detector: &mut Detector,
        ring: &mut Ring,
        outbox: &mut Outbox,
        shared: &Shared<P>,
    ) {
        let Shared {
            platform,
            diagnostics,
            ..
        } = shared;
        let mut emit = |event: Event| outbox.send(event, shared);
        let Self {
            samples,
            windows,
            is_greeted,
        } = self;
        if !core::mem::replace(is_greeted, true) {
            emit(detector.hello());
            detector.add_standing_faults(platform.now_us(), diagnostics);
        }
        loop {
            let next = detector.fill(samples);
            if next == Next::Nothing {
                shared.touched.store(detector.is_touched(), Relaxed);
                if shared.look.swap(false, Relaxed) {
                    detector.look(platform.now_us(), diagnostics, &mut emit);
                }
            }
            let mut due = |window: Window| {
                let keeps_up = windows.is_empty();
                admit(
                    window,
                    keeps_up,
                    |window| windows.enqueue(window).is_ok(),
                    shared,
                );
            };
            let outputs = &mut Outputs {
                emit: &mut emit,
                due: &mut due,
            };
            match next {
                Next::Scan => detector.scan(ring, diagnostics, outputs),
                Next::Mark(mark) => detector.begin(mark, ring, diagnostics, outputs),
                Next::Nothing => {
                    if platform.has_ended() && !shared.finished.load(Relaxed) {
                        detector.finish(ring, diagnostics, &mut emit, &mut due);
                        shared.finished.store(true, Relaxed);
                    }
                    break;
                }
            }
        }
        shared.liveness.detected.bump();
    }
}

/// Hands a due window to the fit through `put`, which is false if there is no space, or counts the
/// window as skipped. A stride is handed over only if it would be fitted before the next stride; a
/// whole slide always is.
pub fn admit<P: Platform>(
    window: Window,
    keeps_up: bool,
    put: impl FnOnce(Window) -> bool,
    shared: &Shared<P>,
) {
    if (window.span == Span::Slide || keeps_up) && put(window) {
        shared.liveness.fits_due.bump();
    } else {
        shared.diagnostics.overruns.add(1);
    }
    // Have the chip checked, because an estimate is qualified only after a check that follows the
    // window's end.
    shared.check.store(true, Relaxed);
    P::pend(shared, Task::Fit);
}
