//! `health` once a second: converted a reading a frame, so that no frame has much of it to do.

use super::{Counters, Detector, Teller};
use crate::fault::KINDS;
use crate::frame::{Assembler, OWN, Readings};
use crate::settings::FRAME_RATE_HZ;
use crate::telemetry::{Health, News};
use crate::window::reached;

/// Frames from one `health` to the next: one second.
const HEALTH_FRAMES: u32 = FRAME_RATE_HZ as u32;
/// The greeting is repeated after so many healths: who listens in later learns the protocol and the
/// settings too.
const GREETING_HEALTHS: u8 = 10;
/// Steps before it is told: a reading each, and the rate.
const STEPS: u32 = OWN as u32 + 1;
/// Frames before it is told at which they begin: some more, for some frames have no time for one.
const AHEAD_FRAMES: u32 = 2 * STEPS;

/// What the next `health` will say, in the making.
#[derive(Clone, Debug)]
pub(super) struct Checkup {
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
}

impl Checkup {
    pub const fn new() -> Self {
        Self {
            told_at: HEALTH_FRAMES,
            due: HEALTH_FRAMES - AHEAD_FRAMES,
            step: 0,
            readings: Readings::NONE,
            frame_rate_hz: 0.0,
            greeting_in: GREETING_HEALTHS,
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
    pub fn finish(&mut self, assembler: &Assembler, teller: &Teller, counters: &Counters, emit: &mut dyn FnMut(News)) {
        for step in 0..STEPS {
            self.prepare(step, assembler, teller);
        }
        self.tell(assembler, counters, emit);
    }

    #[inline(never)]
    fn prepare(&mut self, step: u32, assembler: &Assembler, teller: &Teller) {
        if step < OWN as u32 {
            assembler.read(step as usize, &mut self.readings);
        } else {
            self.frame_rate_hz = teller.frame_rate_hz();
        }
    }

    // Tells what it makes: given back, it would be copied.
    #[inline(never)]
    fn tell(&self, assembler: &Assembler, counters: &Counters, emit: &mut dyn FnMut(News)) {
        let Readings { supply_v, reference_v, temperature_c, offset_v, gain } = self.readings;
        emit(News::Health(Health {
            t_us: assembler.now_us(),
            frames: assembler.frames,
            // What overran the queue is missing in the scan too; it would count twice if added.
            conversions_lost: assembler.lost.max(counters.overruns),
            conversions_doubtful: assembler.doubtful,
            hops_skipped: counters.hops_skipped,
            messages_dropped: counters.messages_dropped,
            chip_restarts: counters.chip_restarts,
            faults: [0; KINDS],
            orders_damaged: counters.orders_damaged,
            stack_used_bytes: 0,
            stack_bytes: 0,
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
    pub(super) fn check(&mut self, counters: &Counters, emit: &mut dyn FnMut(News)) {
        let Self { assembler, rest, checkup, .. } = self;
        let (step, latest) = (checkup.step, rest.teller.latest.0);
        (checkup.step, checkup.due) = (step + 1, latest.wrapping_add(1));
        if step < STEPS {
            checkup.prepare(step, assembler, &rest.teller);
            if step + 1 == STEPS {
                checkup.due = checkup.told_at;
            }
            return;
        }
        if step == STEPS {
            checkup.tell(assembler, counters, emit);
            checkup.greeting_in = checkup.greeting_in.saturating_sub(1);
            if checkup.greeting_in == 0 {
                // With the next frame.
                return;
            }
        } else {
            checkup.greeting_in = GREETING_HEALTHS;
            emit(self.hello());
        }
        self.checkup.begin(latest);
    }
}
