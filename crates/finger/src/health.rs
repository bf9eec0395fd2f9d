//! Schedules `health` about once a second and the greeting every ten seconds; checks the frame
//! rate.

use crate::assembler::Assembler;
use crate::faults::diagnostics::Diagnostics;
use crate::frame::{FrameClock, Readings};
use crate::ring::reached;
use ridgetone_proto::division::divide;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::Health;

/// The greeting is repeated with every tenth `health`, for listeners that connect later.
const GREETING_HEALTHS: u8 = 10;
/// Inverse of the maximum relative error of the rate: 1 / 200, which no crystal exceeds.
const RATE_TOLERANCE: u64 = 200;
/// Minimum time between checks of the rate, seconds. With a check twice a second and with each
/// `health`, an interval has at most 141 frames by default. So a clock that is off by 1 % for 0.6
/// s, 145 frames, is off for more than half of one of these intervals.
const RATE_S: f32 = 0.415;
/// Number of half-second checks from one `health` to the next while no conversions arrive.
const SILENT_CHECKS: u8 = 2;
/// Time without a conversion that counts as silence, microseconds: by default a hundred frames.
const SILENCE_US: u32 = 400_000;

#[derive(Clone, Debug)]
pub struct HealthReporter {
    /// Number of frames from one `health` to the next: one second.
    health_frames: u32,
    rate_frames: u32,
    due: u32,
    /// Number of `health` messages since the latest greeting.
    ungreeted: u8,
    /// Latest frame, its time, and the number of losses and restarts at the latest check of the
    /// rate.
    rate_from: (u32, u64, u32),
    /// Number of checks in a row without a conversion since the latest `health`.
    silent: u8,
}

impl HealthReporter {
    pub const fn new(plan: &Plan) -> Self {
        let (health_frames, rate_frames) = (plan.frame_rate_hz() as u32, plan.frames_in(RATE_S));
        Self {
            health_frames,
            rate_frames,
            due: health_frames,
            ungreeted: 0,
            rate_from: (0, 0, 0),
            silent: 0,
        }
    }

    /// Continues with a different plan after frame `number`.
    pub fn change(&mut self, plan: &Plan, number: u32, t_us: u64) {
        let Self {
            health_frames,
            rate_frames,
            ..
        } = Self::new(plan);
        (self.health_frames, self.rate_frames) = (health_frames, rate_frames);
        self.due = number.wrapping_add(health_frames);
        self.rate_from = (number, t_us, u32::MAX);
    }

    /// Returns true if `health` is due with the frame `latest`, and schedules the next one.
    #[inline(always)]
    pub fn is_due(&mut self, latest: u32) -> bool {
        let is_due = reached(latest, self.due);
        if is_due {
            let next = self.due.wrapping_add(self.health_frames);
            self.due = if reached(latest, next) {
                latest.wrapping_add(self.health_frames)
            } else {
                next
            };
        }
        is_due
    }

    /// Counts a `health`. Returns true if the greeting is due with it.
    pub fn is_greeting_due(&mut self) -> bool {
        self.ungreeted = (self.ungreeted + 1) % GREETING_HEALTHS;
        self.ungreeted == 0
    }

    /// Must be called twice a second. Returns true if `health` is due because no conversion arrived
    /// for a second; `passed_us` is the time since the latest conversion, if any.
    pub fn is_silence_due(&mut self, passed_us: Option<u32>) -> bool {
        let is_silent = passed_us.is_none_or(|passed_us| passed_us >= SILENCE_US);
        self.silent = if is_silent {
            (self.silent + 1) % SILENT_CHECKS
        } else {
            0
        };
        is_silent && self.silent == 0
    }

    /// Reports a fault if the frames since the last check did not come at the nominal rate. Makes
    /// no check across losses and restarts of the scan, which are reported separately.
    pub fn check_rate(
        &mut self,
        assembler: &Assembler,
        clock: &FrameClock,
        diagnostics: &Diagnostics,
    ) {
        let (number, t_us) = clock.latest;
        let breaks = assembler.lost.wrapping_add(diagnostics.chip_restarts.get());
        let (from, from_us, from_breaks) = self.rate_from;
        let frames = number.wrapping_sub(from);
        if frames < self.rate_frames {
            return;
        }
        self.rate_from = (number, t_us, breaks);
        let (passed_us, nominal_us) = (
            t_us.wrapping_sub(from_us),
            divide(frames as u64 * assembler.scan().frame_ns() as u64, 1000).0,
        );
        // In a longer time, frame numbers may have wrapped.
        let is_known = frames < 10 * self.health_frames
            && passed_us <= u32::MAX as u64
            && breaks == from_breaks;
        if is_known && RATE_TOLERANCE * passed_us.abs_diff(nominal_us) > nominal_us {
            diagnostics.fault(FaultKind::Clock, assembler.board_us);
        }
    }
}

/// Contents of `health` at a device time, microseconds.
pub fn health(
    t_us: u64,
    assembler: &Assembler,
    frame_rate_hz: f32,
    diagnostics: &Diagnostics,
) -> Health {
    let [stack_used_bytes, stack_bytes] = diagnostics.stack_bytes();
    let Readings {
        supply_v,
        reference_v,
        temperature_c,
        offset_v,
        gain,
    } = assembler.readings();
    Health {
        t_us,
        frames: assembler.frames,
        // A conversion that did not fit the queue is missing in the scan too, so take the larger
        // count. They differ: `queue_overruns` leaves out whole scans that were not read, and
        // `lost` relies on the nominal rate.
        conversions_lost: assembler
            .lost
            .max(diagnostics.queue_overruns.get())
            .saturating_add(diagnostics.unseen.get()),
        conversions_doubtful: assembler.doubtful,
        overruns: diagnostics.overruns.get(),
        messages_dropped: diagnostics.messages_dropped.get(),
        chip_restarts: diagnostics.chip_restarts.get(),
        faults: diagnostics.faults.counts(),
        requests_damaged: diagnostics.requests_damaged.get(),
        bytes_overrun: diagnostics.bytes_overrun.get(),
        stack_used_bytes,
        stack_bytes,
        frame_rate_hz,
        load: diagnostics.load(),
        supply_v,
        reference_v,
        temperature_c,
        offset_v,
        gain,
        frames_thinned: diagnostics.frames_thinned.get(),
    }
}
