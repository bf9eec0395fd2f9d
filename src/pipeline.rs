//! push(conversion) -> events; composes the rooms; knows no hardware (stub).

use crate::frame::TimedConversion;
use crate::settings::Settings;
use crate::telemetry::{Estimate, Event, Health};
use crate::window::{FrameSource, Ring, Window};

/// Frames, contact and windows: the middle task.
#[derive(Debug)]
pub struct Detector {
    settings: Settings,
}

/// What the caller counts and the detector reports in `health`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Conversions lost between interrupt and queue.
    pub overruns: u32,
    /// Windows not fitted because the fit was busy.
    pub hops_skipped: u32,
    /// Messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// Processor load, 0 to 1.
    pub load: f32,
}

impl Detector {
    /// A detector at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self { settings }
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        let _ = self.settings;
        Event::Health(Health::default())
    }

    /// Takes one conversion; events go to `emit`, windows that are due for a fit to `due`.
    pub fn push(
        &mut self,
        _conversion: TimedConversion,
        _ring: &mut Ring,
        _counters: &Counters,
        _emit: &mut dyn FnMut(Event),
        _due: &mut dyn FnMut(Window),
    ) {
    }

    /// The signal has ended: closes what is open (a slide that still runs) and reports health.
    pub fn finish(&mut self, _counters: &Counters, _emit: &mut dyn FnMut(Event), _due: &mut dyn FnMut(Window)) {}
}

/// Spectrum and sine fit: the lowest task. Owns their scratch memory.
#[derive(Debug)]
pub struct Estimator {
    settings: Settings,
}

impl Estimator {
    /// An estimator; `const`, so that its scratch memory can live in a static.
    pub const fn new(settings: Settings) -> Self {
        Self { settings }
    }

    /// Fits a window. None if its frames were overwritten before they were read.
    pub fn run(&mut self, _window: &Window, _source: &mut impl FrameSource) -> Option<Estimate> {
        let _ = self.settings;
        None
    }
}

/// The whole path in one call, as a PC runs it: the detector, and each due window fitted at once.
#[derive(Debug)]
pub struct Pipeline {
    detector: Detector,
    estimator: Estimator,
    ring: Ring,
}

impl Pipeline {
    /// A pipeline at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self { detector: Detector::new(settings), estimator: Estimator::new(settings), ring: Ring::new() }
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        self.detector.hello()
    }

    /// Takes one conversion; events go to `emit`.
    pub fn push(&mut self, _conversion: TimedConversion, _emit: &mut dyn FnMut(Event)) {
        let _ = (&self.estimator, &self.ring);
    }

    /// The signal has ended: closes what is open and reports health.
    pub fn finish(&mut self, _emit: &mut dyn FnMut(Event)) {}
}
