//! `fit`: fits the due windows, then carries out requests, so that a request does not affect
//! windows that were due before it.

use super::line::RequestInbox;
use super::outbox::{Mail, Outbox};
use super::requests::{Requests, Targets};
use super::shared::{Platform, Shared, Task};
use crate::detector::Detector;
use crate::estimator::{Estimator, WindowFit};
use crate::ring::Ring;
use crate::window::Window;
use core::ops::DerefMut;
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Consumer;
use ridgetone_proto::store::Store;
use ridgetone_proto::telemetry::{Estimate, Event, Span, Track};
use ridgetone_tone::{Fitter, FrameSource, Overwritten, Values};
use rtic_core::Mutex;

/// State that only this task uses.
pub struct Fit<'a, S> {
    /// The estimator.
    pub estimator: Estimator,
    /// Memory of a fit.
    pub fitter: &'a mut Fitter,
    /// Due windows from `detect`.
    pub windows: Consumer<'a, Window>,
    /// Requests from `line`.
    pub requests: Requests<S>,
}

impl<S: Store> Fit<'_, S> {
    /// Runs when a window is due, and when a request has arrived.
    pub fn run<P: Platform>(
        &mut self,
        ring: &mut impl Mutex<T: DerefMut<Target = Ring>>,
        detector: &mut impl Mutex<T: DerefMut<Target = Detector>>,
        mail: Mail<'_, impl Mutex<T = RequestInbox>, impl Mutex<T = Outbox>>,
        shared: &Shared<P>,
    ) {
        let Mail { inbox, outbox } = mail;
        let Self {
            estimator,
            fitter,
            windows,
            requests,
        } = self;
        loop {
            // Use references to window and estimate, because copies would need more stack.
            while let Some(window) = &windows.dequeue() {
                // Skip this window: it would only delay the later one that is due.
                if window.span == Span::Window
                    && windows.peek().is_some_and(|next| next.span == Span::Window)
                {
                    shared.diagnostics.overruns.add(1);
                    continue;
                }
                let source = &mut Locked {
                    ring: &mut *ring,
                    span: window.span,
                    windows: &*windows,
                };
                if let Some(track) = follow(window, estimator, fitter, source, shared) {
                    outbox.lock(|outbox| outbox.send(Event::Track(track), shared));
                } else if let Ok(WindowFit::Done(estimate)) =
                    &fit(window, estimator, fitter, source, shared)
                {
                    report(outbox, estimate, window, estimator, shared);
                    // If frames were overwritten in the meantime, the next window is searched.
                    let _ = estimator.search(fitter, window, source);
                }
            }
            let targets = Targets {
                estimator,
                detector,
            };
            let mail = Mail { inbox, outbox };
            if !requests.step(|| windows.ready(), targets, mail, shared) {
                break;
            }
        }
    }
}

// Not inlined: its 830 bytes of stack would add to those of a fit, the deepest use of the stack.
#[inline(never)]
fn report<P: Platform>(
    outbox: &mut impl Mutex<T = Outbox>,
    estimate: &Estimate,
    window: &Window,
    estimator: &mut Estimator,
    shared: &Shared<P>,
) {
    estimator.report(estimate, window, &mut |event| {
        outbox.lock(|outbox| outbox.send(event, shared));
    });
}

/// Follows the tone of the latest fit to the end of a window, and qualifies the track like an
/// estimate. Returns `None` if the window has to be fitted.
// Not inlined: its stack would add to that of a fit, the deepest use of the stack.
#[inline(never)]
pub fn follow<P: Platform>(
    window: &Window,
    estimator: &mut Estimator,
    fitter: &mut Fitter,
    source: &mut dyn FrameSource,
    shared: &Shared<P>,
) -> Option<Track> {
    let mut track = estimator.follow(fitter, window, source)?;
    shared.liveness.fits_done.bump();
    check_chip(shared);
    shared.diagnostics.qualify_track(&mut track, window);
    Some(track)
}

/// Has the chip checked at once, unless that was done since the latest window's end.
fn check_chip<P: Platform>(shared: &Shared<P>) {
    if shared.check.load(Relaxed) {
        shared.urgent.store(true, Relaxed);
        P::pend(shared, Task::Drdy);
    }
}

/// Fits a window. Before the estimate is qualified, the chip is checked, unless that was done since
/// the window's end. The caller reports an estimate only if it is [`WindowFit::Done`].
pub fn fit<P: Platform>(
    window: &Window,
    estimator: &mut Estimator,
    fitter: &mut Fitter,
    source: &mut dyn FrameSource,
    shared: &Shared<P>,
) -> Result<WindowFit, Overwritten> {
    // Qualify it in place, because a copy would need more stack.
    let mut outcome = estimator.run(fitter, window, source);
    shared.liveness.fits_done.bump();
    match &mut outcome {
        Ok(WindowFit::Done(estimate)) => {
            check_chip(shared);
            shared.diagnostics.qualify(estimate, window);
        }
        Ok(WindowFit::Growing) => {}
        Err(Overwritten) => shared.diagnostics.overruns.add(1),
    }
    outcome
}

/// The ring behind its lock, which is held for one read at a time. A whole slide that is due aborts
/// the fit of a window, or the slide's frames would be overwritten.
struct Locked<'w, 'q, M> {
    ring: M,
    span: Span,
    windows: &'w Consumer<'q, Window>,
}

impl<M: Mutex<T: DerefMut<Target = Ring>>> FrameSource for Locked<'_, '_, M> {
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        let next = self.windows.peek();
        if self.span == Span::Window && next.is_some_and(|next| next.span == Span::Slide) {
            return Err(Overwritten);
        }
        self.ring
            .lock(|ring| FrameSource::read(&mut &**ring, first, max, show))
    }
}
