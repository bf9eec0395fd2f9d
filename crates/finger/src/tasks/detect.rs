//! `detect`: conversions and a robot's messages in, in the order of their times; events, and
//! windows that are due, out.

use super::line::{Inboxes, ODOMETRY_US};
use super::outbox::{Mail, Outbox};
use super::shared::{PACKETS, Platform, Shared, Task};
use crate::detector::{Detector, Outputs};
use crate::frame::TimedConversion;
use crate::ring::Ring;
use crate::surface::odometry::{Odometer, SentOdometry};
use crate::window::Window;
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::{Consumer, Producer};
use ridgetone_proto::odometry::Odometry;
use ridgetone_proto::telemetry::{Event, Span};
use rtic_core::Mutex;

/// What the task owns.
pub struct Detect<'a> {
    samples: Consumer<'a, TimedConversion>,
    windows: Producer<'a, Window>,
    odometer: Odometer,
    is_greeted: bool,
}

impl<'a> Detect<'a> {
    /// `samples`: from `drdy`; `windows`: to `fit`.
    pub const fn new(
        samples: Consumer<'a, TimedConversion>,
        windows: Producer<'a, Window>,
    ) -> Self {
        Self {
            samples,
            windows,
            odometer: Odometer::new(),
            is_greeted: false,
        }
    }

    /// The next conversion in the queue.
    pub fn next(&self) -> Option<&TimedConversion> {
        self.samples.peek()
    }

    /// Runs after each scan, after what interrupts one, and twice a second without any.
    pub fn run<P: Platform>(
        &mut self,
        detector: &mut Detector,
        ring: &mut Ring,
        mail: Mail<'_, impl Mutex<T = Inboxes>, Outbox<PACKETS>>,
        shared: &Shared<P>,
    ) {
        let Mail { inbox, outbox } = mail;
        let Shared {
            platform,
            diagnostics,
            ..
        } = shared;
        let mut emit = |event: Event| outbox.send(event, shared);
        let Self {
            samples,
            windows,
            odometer,
            is_greeted,
        } = self;
        if !core::mem::replace(is_greeted, true) {
            emit(detector.hello());
        }
        loop {
            if shared.has_odometry.load(Relaxed) {
                // It comes before the conversions that are later.
                let complete_us = shared.odometry_us.load(Relaxed);
                let is_next =
                    |next: &TimedConversion| next.t_us.wrapping_sub(complete_us) as i32 > 0;
                if samples.peek().is_none_or(is_next) {
                    take_odometry(complete_us, ring.lasts_us(), odometer, inbox, shared);
                }
            }
            let conversion = samples.dequeue();
            if conversion.is_none() {
                shared.touched.store(detector.is_touched(), Relaxed);
                if shared.look.swap(false, Relaxed) {
                    let now_us = platform.now_us();
                    detector.look(now_us, diagnostics, &mut emit);
                    odometer.forget(now_us, &shared.track);
                }
            }
            let zero_us = detector.zero_us();
            let mut due = |mut window: Window| {
                let keeps_up = windows.is_empty();
                let end_us = (window.end_us as u32).wrapping_add(zero_us);
                window.follow(odometer.mark(end_us, &shared.track));
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
            match conversion {
                Some(conversion) => match conversion.as_mark() {
                    None => detector.push(conversion, ring, diagnostics, outputs),
                    Some(mark) => {
                        detector.begin(mark, ring, diagnostics, outputs);
                        odometer.change_plan(&shared.track);
                    }
                },
                None => {
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

/// Takes a robot's message out of its inbox.
fn take_odometry<P: Platform>(
    complete_us: u32,
    ring_us: u32,
    odometer: &mut Odometer,
    inbox: &mut impl Mutex<T = Inboxes>,
    shared: &Shared<P>,
) {
    shared.has_odometry.store(false, Relaxed);
    let Some(mut frame) = inbox.lock(|inbox| inbox.odometry.take()) else {
        return;
    };
    take_message(&mut frame, complete_us, ring_us, odometer, shared);
}

/// Takes a robot's message, stuffed and without its zero, that was complete at a board time,
/// microseconds. A full ring lasts for `ring_us`.
pub fn take_message<P: Platform>(
    frame: &mut [u8],
    complete_us: u32,
    ring_us: u32,
    odometer: &mut Odometer,
    shared: &Shared<P>,
) {
    let Shared {
        diagnostics, track, ..
    } = shared;
    match Odometry::decode(frame) {
        Some(message) => {
            let received = SentOdometry {
                message: &message,
                sent_us: complete_us.wrapping_sub(ODOMETRY_US),
            };
            odometer.take(received, ring_us, track, diagnostics);
        }
        None => diagnostics.requests_damaged.add(1),
    }
}

/// Gives a window that is due to the fit by `put`, which is false if there is no place, or counts
/// it as skipped. A stride is fitted only if the fit keeps up: if it would be fitted before the next
/// stride. A whole slide always is.
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
    // An estimate is reported only if the chip is known to have been well until the window's end.
    shared.check.store(true, Relaxed);
    P::pend(shared, Task::Fit);
}
