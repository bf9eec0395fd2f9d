//! The whole path from conversions to events in one call, for a PC.
//!
//! The chip runs detector and estimator as tasks of different priority. They share only the
//! [`Ring`], and pass [`Window`]s, so the results are the same. Windows that are not fitted are
//! counted in `overruns`.

use crate::detector::{Detector, Outputs};
use crate::estimator::{Estimator, WindowFit};
use crate::frame::{PlainFrame, TimedConversion};
use crate::ring::Ring;
use crate::tasks::detect::admit;
use crate::tasks::fit::{fit, follow};
use crate::tasks::shared::{Platform, Shared, Task};
use crate::window::Window;
use crate::wiring::Wiring;
use heapless::Vec;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Raw};
use ridgetone_tone::Fitter;

/// Maximum number of windows that are fitted after one conversion. Several windows are due at once
/// when a slide is noticed late.
const WINDOWS_AT_ONCE: usize = 8;

/// Platform on which tasks need not be started, because each step calls the next.
#[derive(Debug)]
struct OneCall;

impl Platform for OneCall {
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        0
    }
}

enum Next<'a> {
    Conversion(TimedConversion),
    Frame(PlainFrame<'a>),
    Raw(&'a Raw),
    /// The signal has ended.
    End,
}

/// Detector and estimator, and the state that they share.
#[derive(Debug)]
pub struct Pipeline {
    detector: Detector,
    estimator: Estimator,
    fitter: Fitter,
    ring: Ring,
    shared: Shared<OneCall>,
}

impl Pipeline {
    /// Creates an idle pipeline. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self::wired(settings, Wiring::GUIDE)
    }

    /// Creates an idle pipeline for a board's wiring.
    pub const fn wired(settings: Settings, wiring: Wiring) -> Self {
        Self {
            detector: Detector::wired(settings, wiring),
            estimator: Estimator::new(settings),
            fitter: Fitter::new(),
            ring: Ring::new(),
            shared: Shared::new(OneCall, settings.plan),
        }
    }

    /// Also reports the next `frames` frames raw.
    pub fn report_raw(&mut self, frames: u32) {
        self.detector.report_raw(frames);
    }

    /// Greeting to send before anything else.
    pub fn hello(&self) -> Event {
        self.detector.hello()
    }

    /// Takes one conversion. Events go to `emit`.
    pub fn push(&mut self, conversion: TimedConversion, emit: &mut dyn FnMut(Event)) {
        self.step(Next::Conversion(conversion), emit);
    }

    /// Takes a plain frame of a different converter, instead of conversions, if the settings' plan
    /// is [`Plan::of_frames`](ridgetone_proto::plan::Plan::of_frames); see the example of [this
    /// crate](crate). Readings of the chip's own health stay zero.
    pub fn push_frame(&mut self, frame: PlainFrame<'_>, emit: &mut dyn FnMut(Event)) {
        self.step(Next::Frame(frame), emit);
    }

    /// Takes a frame that a board has reported raw, instead of its conversions. If the settings
    /// have the board's plan and reference, contacts, slides and estimates equal the board's to the
    /// bit.
    pub fn push_raw(&mut self, raw: &Raw, emit: &mut dyn FnMut(Event)) {
        self.step(Next::Raw(raw), emit);
    }

    /// Ends the signal: ends the touch under way and reports health.
    pub fn finish(&mut self, emit: &mut dyn FnMut(Event)) {
        self.step(Next::End, emit);
    }

    /// Takes the next input; then fits the windows that are due.
    fn step(&mut self, next: Next<'_>, emit: &mut dyn FnMut(Event)) {
        let Self {
            detector,
            estimator,
            fitter,
            ring,
            shared,
        } = self;
        let mut windows = Vec::<Window, WINDOWS_AT_ONCE>::new();
        // The signal waits for the fit, so the fit always keeps up.
        let due = &mut |window: Window| {
            admit(window, true, |window| windows.push(window).is_ok(), shared);
        };
        match next {
            Next::Conversion(conversion) => {
                let outputs = &mut Outputs { emit, due };
                detector.push(conversion, ring, &shared.diagnostics, outputs);
            }
            Next::Frame(frame) => {
                let outputs = &mut Outputs { emit, due };
                detector.push_frame(frame, ring, &shared.diagnostics, outputs);
            }
            Next::Raw(raw) => {
                let outputs = &mut Outputs { emit, due };
                detector.push_raw(raw, ring, &shared.diagnostics, outputs);
            }
            Next::End => detector.finish(ring, &shared.diagnostics, emit, due),
        }
        for window in &windows {
            let source = &mut &*ring;
            if let Some(track) = follow(window, estimator, fitter, source, shared) {
                emit(Event::Track(track));
            } else if let Ok(WindowFit::Done(estimate)) =
                fit(window, estimator, fitter, source, shared)
            {
                estimator.report(&estimate, window, emit);
                let _ = estimator.search(fitter, window, source);
            }
        }
    }
}
