//! Marks estimates as doubtful if a fault may have changed them.

use crate::faults::diagnostics::Diagnostics;
use crate::touch::block::BLOCK_FRAMES;
use crate::touch::motion::LONG_BLOCKS;
use crate::window::Window;
use ridgetone_proto::fault::{FaultKind, FaultSet};
use ridgetone_proto::telemetry::{Estimate, Status, Track, Travel};

/// Maximum relative deviation of the window's frame rate; no crystal deviates that much.
const RATE_TOLERANCE: f32 = 0.005;

/// Margin before the window, frames.
const MARGIN_FRAMES: f32 = 2.0;

/// Frames after a motion until touch detection recognises a standstill:
/// [`crate::touch::motion::LONG_BLOCKS`], the block itself, four still ones and one more.
const KNOWN_STILL_FRAMES: u32 = (LONG_BLOCKS + 6) * BLOCK_FRAMES;

impl Diagnostics {
    /// Adds to an estimate the kinds of faults that were seen since its window began. If they may
    /// have changed the frequency, a good or unsteady estimate becomes doubtful, without period,
    /// speed and direction.
    ///
    /// Two kinds also count outside the window: a shift of the levels shortly before it, because
    /// the slide may not have begun yet, and an input that reached or left a rail shortly before
    /// its end, because that may have looked like motion.
    ///
    /// Must be called after the first check of the chip's registers that follows the window's end,
    /// because no earlier check can find a change within the window.
    pub fn qualify(&self, estimate: &mut Estimate, window: &Window) {
        let (faults, is_doubtful) = faults_of(window, estimate.window_s, self);
        estimate.faults = faults;
        if is_doubtful {
            doubt(estimate);
        }
    }

    /// Makes a track doubtful if [`Self::qualify`] would make an estimate of the window doubtful.
    pub fn qualify_track(&self, track: &mut Track, window: &Window) {
        let window_s = window.frames as f32 / window.frame_rate_hz;
        if faults_of(window, window_s, self).1 {
            track.status = Status::Doubtful;
        }
    }
}

/// Makes a good or unsteady estimate doubtful, without period, speed and direction.
pub fn doubt(estimate: &mut Estimate) {
    if matches!(estimate.status, Status::Good | Status::Unsteady) {
        estimate.status = Status::Doubtful;
        estimate.travel = Travel::NONE;
    }
}

/// Kinds of faults since the latest `window_s` seconds of a window began; and true if they may have
/// changed the frequency, or if the window's end is uncertain.
fn faults_of(window: &Window, window_s: f32, diagnostics: &Diagnostics) -> (FaultSet, bool) {
    let nominal_hz = window.plan.frame_rate_hz();
    let in_us = |frames: f32| (frames * 1e6 / nominal_hz) as u32;
    let known_still_us = in_us((KNOWN_STILL_FRAMES * window.plan.frames_averaged()) as f32);
    let end_us = window.end_us as u32;
    let begin_us = end_us
        .wrapping_sub((window_s * 1e6) as u32)
        .wrapping_sub(in_us(MARGIN_FRAMES));
    let before = diagnostics
        .faults
        .since(begin_us.wrapping_sub(known_still_us))
        .iter()
        .filter(|kind| kind.moves_levels());
    let mut faults = before.fold(diagnostics.faults.since(begin_us), FaultSet::with);
    let off_hz = window.frame_rate_hz - nominal_hz;
    // Negated, so that a NaN counts as a deviation.
    if !(off_hz.abs() <= RATE_TOLERANCE * nominal_hz) {
        faults = faults.with(FaultKind::Clock);
    }
    let is_end_unsure = diagnostics.rails_change(end_us.wrapping_sub(known_still_us), end_us);
    if is_end_unsure {
        // The fault may have ended before the beginning of a short window.
        faults = faults.with(FaultKind::Overload);
    }
    let is_doubtful = is_end_unsure || faults.iter().any(FaultKind::changes_frequency);
    (faults, is_doubtful)
}

#[cfg(test)]
mod tests {
    use super::*;

    use ridgetone_proto::plan::Plan;

    use ridgetone_proto::telemetry::{Movement, Span};

    const END_US: u64 = 10_000_000;

    /// Qualifies a good estimate of a window of one second, with a fault some frames before the
    /// window's start.
    fn after_fault(kind: FaultKind, frames_before: f32) -> Estimate {
        let plan = Plan::PAPER;
        let frame_rate_hz = plan.frame_rate_hz();
        let window = Window {
            end_us: END_US,
            ..Window::new(plan, plan.frame_rate_hz() as u32)
        };
        let mut estimate = Estimate {
            t_us: END_US,
            window_s: 1.0,
            span: Span::Window,
            status: Status::Good,
            frequency: 8.0,
            sigma: 0.001,
            movement: Movement::default(),
            other_tone: None,
            interferer_hz: None,
            harmonics: 1,
            frames_missing: 0,
            faults: FaultSet::NONE,
            travel: Travel::NONE,
            channels: heapless::Vec::new(),
        };
        let before_us = (frames_before * 1e6 / frame_rate_hz) as u32;
        let diagnostics = Diagnostics::new();
        diagnostics.fault(kind, END_US as u32 - 1_000_000 - before_us);
        diagnostics.qualify(&mut estimate, &window);
        estimate
    }

    /// Tests that faults count up to two frames before the window, but not three: a conversion of
    /// the first frame began before its time stamp, and its fault is seen when it has ended.
    #[test]
    fn faults_count_from_two_frames_before_the_window_on() {
        for kind in FaultKind::ALL {
            if !kind.changes_frequency() || kind.moves_levels() {
                continue;
            }
            for frames in [0.5, 1.0, 1.9] {
                let status = after_fault(kind, frames).status;
                assert_eq!(status, Status::Doubtful, "{kind:?}, {frames} frames");
            }
            let estimate = after_fault(kind, 3.0);
            assert_eq!(
                (estimate.status, estimate.faults),
                (Status::Good, FaultSet::NONE),
                "{kind:?}"
            );
        }
    }
}
