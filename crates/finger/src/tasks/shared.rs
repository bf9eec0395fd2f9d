//! State that the tasks share without a lock, and what they need from their platform.

use super::liveness::Liveness;
use super::plan_request::PlanRequest;
use crate::faults::diagnostics::Diagnostics;
use crate::samples::SampleQueue;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::{Headline, WIRE_MAX};

/// Size of the queue of conversions from `drdy` to `detect`: 7.7 ms at 5064 a second, 1.7 ms at
/// 23,336; the longest step of `detect` takes 0.14 ms. A queue holds one entry less than its size.
pub const SAMPLES: usize = 40;

/// The queue of conversions.
pub type Samples = SampleQueue<[[AtomicU32; 2]; SAMPLES]>;

/// Size of the queue of windows from `detect` to `fit`: one stride may wait, the other places are
/// for whole slides.
pub const WINDOWS: usize = 4;

/// Size of the queue of bytes from `report` to `line`: the next packet is encoded while the last 63
/// bytes are sent, 0.68 ms.
pub const BYTES: usize = 576;

/// Maximum number of queued bytes with which the longest packet still fits.
pub(super) const LOW_WATER: usize = BYTES - 1 - WIRE_MAX;

/// Maximum number of events from `detect` and `fit` that wait for `report`.
pub const PACKETS: usize = 7;

/// Maximum number of raw frames that wait for the line, behind all events.
pub const FRAMES: usize = 4;

/// A task that another task starts, named after its module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is a module")]
pub enum Task {
    Drdy,
    SerialLine,
    Detect,
    Report,
    Fit,
}

/// Platform of the tasks: RTIC on a board, virtual time in a simulation.
pub trait Platform: Sized {
    /// Makes a task run: at once if it has a higher priority than the caller.
    fn pend(shared: &Shared<Self>, task: Task);

    /// Board time, microseconds, wrapping.
    fn now_us(&self) -> u32;

    /// True if the signal is over; on a real board it never is.
    fn has_ended(&self) -> bool {
        false
    }

    /// Logs an event that is being sent, in one line.
    fn log(&self, _: Headline) {}
}

/// State that the tasks share without a lock.
#[derive(Debug)]
pub struct Shared<P> {
    /// Platform of the tasks.
    pub platform: P,
    /// Counters and faults.
    pub diagnostics: Diagnostics,
    /// Signs of life of the tasks, for the watchdog.
    pub liveness: Liveness,
    /// True if `drdy` is to check the chip's registers after the next conversion.
    pub(super) check: AtomicBool,
    /// True if `drdy` is to make this check without waiting for a conversion.
    pub(super) urgent: AtomicBool,
    /// Set every half second: `detect` reports changes even if no conversions arrive.
    pub(super) look: AtomicBool,
    /// Plan requested for the chip.
    pub(super) plan: PlanRequest,
    /// True if `drdy` is to read the chip's own readings, in case the plan's scan has none.
    pub(super) health: AtomicBool,
    /// True if the finger touches something.
    pub(super) touched: AtomicBool,
    /// True if the signal is over, and the last window is in its queue.
    pub(super) finished: AtomicBool,
    /// True if bytes wait for the line.
    pub(super) sending: AtomicBool,
    /// Requests a reset of the board as soon as the line is silent.
    pub(super) restarting: AtomicBool,
}

impl<P> Shared<P> {
    /// Starts without counts or requests. `plan` is the plan with which the chip is set up.
    pub const fn new(platform: P, plan: Plan) -> Self {
        let [
            check,
            urgent,
            look,
            health,
            touched,
            finished,
            sending,
            restarting,
        ] = [const { AtomicBool::new(false) }; 8];
        let (diagnostics, liveness) = (Diagnostics::new(), Liveness::new());
        let plan = PlanRequest::new(&plan);
        Self {
            platform,
            diagnostics,
            liveness,
            check,
            urgent,
            look,
            plan,
            health,
            touched,
            finished,
            sending,
            restarting,
        }
    }

    /// Requests a different plan for the chip.
    pub(super) fn request_plan(&self, plan: &Plan)
    where
        P: Platform,
    {
        self.plan.request(plan);
        self.urgent.store(true, Relaxed);
        P::pend(self, Task::Drdy);
    }

    /// Requests a reset of the board as soon as the line is silent.
    pub fn restart(&self) {
        self.restarting.store(true, Relaxed);
    }

    /// True if a reset of the board is requested as soon as the line is silent.
    pub fn is_restarting(&self) -> bool {
        self.restarting.load(Relaxed)
    }
}
