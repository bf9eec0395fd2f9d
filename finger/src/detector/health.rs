//! `health` once a second: converted a reading a frame, so that no frame has much of it to do.

use super::{Detector, WindowScheduler};
use crate::faults::diagnostics::Diagnostics;
use crate::frame::{Assembler, CONVERSION_NS, OWN, Readings, SLOTS};
use crate::ring::reached;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::FRAME_RATE_HZ;
use ridgetone_proto::telemetry::{Event, Health};

/// Frames from one `health` to the next: one second.
const HEALTH_FRAMES: u32 = FRAME_RATE_HZ as u32;
/// The greeting is repeated after so many healths: who listens in later learns the protocol and the
/// settings too.
const GREETING_HEALTHS: u8 = 10;
/// Steps before it is told: a reading each, and the rate.
const STEPS: u32 = OWN as u32 + 1;
/// Frames before it is told at which they begin: some more, for some frames have no time for one.
const AHEAD_FRAMES: u32 = 2 * STEPS;
/// A frame at the nominal rate, nanoseconds.
const FRAME_NS: u32 = CONVERSION_NS as u32 * SLOTS;

/// What the next `health` will say, in the making.
#[derive(Clone, Debug)]
pub(super) struct HealthReporter {
    /// Frame at which it is to be told, or later if that has no time for it.
    told_at: u32,
    /// Frame of the next step.
    due: u32,
    /// Steps taken.
    step: u32,
    readings: Readings,
    frame_rate_hz: f32,
    /// Healths until the greeting is said again.
    greeting_in: u8,
    /// The latest frame when the rate was checked last, its time, and the losses and restarts until then.
    rate_from: (u32, u64, u32),
    /// Looks in a row at which no conversion had come.
    silent: u8,
}

/// The rate may be off by this share of it: 1 / 200 is half a percent. No crystal is.
const RATE_SHARE: u32 = 200;
/// Frames from one check of the rate to the next, at least. It is asked for with every look and every `health`, which
/// makes 141 at most: a clock that is off by 1 % for 0.6 s, 145 frames, is off for more than half of one such stretch.
const RATE_FRAMES: u32 = 100;
/// Looks, twice a second, from one `health` to the next while no conversion comes.
const SILENT_LOOKS: u8 = 2;
/// What the time of an edge may be ahead of the board's clock by, microseconds.
const AHEAD_US: u32 = 1000;
/// No conversion for so long is silence, microseconds: a hundred frames.
const SILENCE_US: u32 = 400_000;

impl HealthReporter {
    pub const fn new() -> Self {
        Self {
            told_at: HEALTH_FRAMES,
            due: HEALTH_FRAMES - AHEAD_FRAMES,
            step: 0,
            readings: Readings::NONE,
            frame_rate_hz: 0.0,
            greeting_in: GREETING_HEALTHS,
            rate_from: (0, 0, 0),
            silent: 0,
        }
    }

    /// Whether a step is due, `frame` being the latest.
    pub fn is_due(&self, frame: u32) -> bool {
        reached(frame, self.due)
    }

    /// The next one, `latest` being the latest frame.
    fn begin(&mut self, latest: u32) {
        let next = self.told_at.wrapping_add(HEALTH_FRAMES);
        self.told_at = if reached(latest, next) { latest.wrapping_add(HEALTH_FRAMES) } else { next };
        (self.step, self.due) = (0, self.told_at.wrapping_sub(AHEAD_FRAMES));
    }

    /// Takes all steps at once.
    pub fn finish(
        &mut self,
        assembler: &Assembler,
        scheduler: &WindowScheduler,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
    ) {
        for step in 0..STEPS {
            self.prepare(step, assembler, scheduler, diagnostics);
        }
        self.tell(assembler.now_us(), assembler, diagnostics, emit);
    }

    #[inline(never)]
    fn prepare(&mut self, step: u32, assembler: &Assembler, scheduler: &WindowScheduler, diagnostics: &Diagnostics) {
        if step < OWN as u32 {
            assembler.read(step as usize, &mut self.readings);
        } else {
            self.frame_rate_hz = scheduler.frame_rate_hz();
            self.check_rate(assembler, scheduler, diagnostics);
            diagnostics.faults.forget(assembler.board_us());
        }
    }

    /// Whether the frames since this was checked before came at the nominal rate. Where some were lost, or the scan began
    /// anew, that is told as such, and their time says nothing of the clock.
    #[inline(never)]
    fn check_rate(&mut self, assembler: &Assembler, scheduler: &WindowScheduler, diagnostics: &Diagnostics) {
        let (number, t_us) = scheduler.latest;
        let breaks = assembler.lost.wrapping_add(diagnostics.counters().chip_restarts);
        let (from, from_us, from_breaks) = self.rate_from;
        let frames = number.wrapping_sub(from);
        if frames < RATE_FRAMES {
            return;
        }
        self.rate_from = (number, t_us, breaks);
        // A second or so: 32 bits are enough, and what is longer, numbers that wrapped included, is none of this.
        let Ok(passed_us) = u32::try_from(t_us.wrapping_sub(from_us)) else { return };
        let nominal_us = frames.saturating_mul(FRAME_NS / 1000) + frames.saturating_mul(FRAME_NS % 1000) / 1000;
        let is_known = frames < 10 * HEALTH_FRAMES && breaks == from_breaks;
        if is_known && passed_us.abs_diff(nominal_us) > nominal_us / RATE_SHARE {
            diagnostics.fault(FaultKind::Clock, assembler.board_us());
        }
    }

    // Tells what it makes: given back, it would be copied.
    #[inline(never)]
    fn tell(&self, t_us: u64, assembler: &Assembler, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let counters = diagnostics.counters();
        let Readings { supply_v, reference_v, temperature_c, offset_v, gain } = self.readings;
        emit(Event::Health(Health {
            t_us,
            frames: assembler.frames,
            // What did not get into the queue is missing in the scan too; it would count twice if added. Of the two the
            // former knows nothing of whole scans that were not read, the latter counts by the nominal rate.
            conversions_lost: assembler.lost.max(counters.overruns).saturating_add(counters.unseen),
            conversions_doubtful: assembler.doubtful,
            hops_skipped: counters.hops_skipped,
            messages_dropped: counters.messages_dropped,
            chip_restarts: counters.chip_restarts,
            faults: diagnostics.faults.counts(),
            requests_damaged: counters.requests_damaged,
            stack_used_bytes: counters.stack[0],
            stack_bytes: counters.stack[1],
            frame_rate_hz: self.frame_rate_hz,
            load: counters.load,
            supply_v,
            reference_v,
            temperature_c,
            offset_v,
            gain,
        }));
    }
}

impl Detector {
    /// Takes the step that is due.
    #[inline(never)]
    pub(super) fn check(&mut self, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self { assembler, rest, health_reporter, .. } = self;
        let (step, latest) = (health_reporter.step, rest.scheduler.latest.0);
        (health_reporter.step, health_reporter.due) = (step + 1, latest.wrapping_add(1));
        if step < STEPS {
            health_reporter.prepare(step, assembler, &rest.scheduler, diagnostics);
            if step + 1 == STEPS {
                health_reporter.due = health_reporter.told_at;
            }
            return;
        }
        if step == STEPS {
            health_reporter.tell(assembler.now_us(), assembler, diagnostics, emit);
            health_reporter.greeting_in = health_reporter.greeting_in.saturating_sub(1);
            if health_reporter.greeting_in == 0 {
                // With the next frame.
                return;
            }
        } else {
            health_reporter.greeting_in = GREETING_HEALTHS;
            emit(self.hello());
        }
        self.health_reporter.begin(latest);
    }

    /// Twice a second, `board_us` being now: tells what begins and ends while no conversion comes, and `health` with the
    /// greeting as often as otherwise. In a silence of more than 71.6 minutes device time begins again where it stood,
    /// as it does after one ([`crate::frame`]); before the first conversion it is zero.
    #[inline(never)]
    pub fn look(&mut self, board_us: u32, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self { assembler, health_reporter, episodes, rest, .. } = self;
        health_reporter.check_rate(assembler, &rest.scheduler, diagnostics);
        let passed_us = board_us.wrapping_sub(assembler.board_us());
        // An edge's time may be a little ahead of the clock that was looked at.
        let passed_us = if passed_us > u32::MAX - AHEAD_US || !assembler.has_begun() { 0 } else { passed_us };
        let t_us = assembler.now_us().wrapping_add(passed_us as u64);
        diagnostics.faults.forget(board_us);
        episodes.tell((t_us, board_us), diagnostics, emit);
        if passed_us < SILENCE_US && assembler.has_begun() {
            health_reporter.silent = 0;
            return;
        }
        health_reporter.silent += 1;
        if health_reporter.silent < SILENT_LOOKS {
            return;
        }
        health_reporter.silent = 0;
        health_reporter.tell(t_us, assembler, diagnostics, emit);
        health_reporter.greeting_in = health_reporter.greeting_in.saturating_sub(1);
        if health_reporter.greeting_in == 0 {
            health_reporter.greeting_in = GREETING_HEALTHS;
            emit(self.hello());
        }
    }
}
