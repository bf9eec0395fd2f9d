//! An estimate is not `good` if a fault in its window may have changed it.

use crate::faults::diagnostics::Diagnostics;
use crate::touch::block::BLOCK_FRAMES;
use crate::touch::motion::LONG_BLOCKS;
use crate::window::Window;
use ridgetone_proto::fault::{FaultKind, FaultSet};
use ridgetone_proto::telemetry::{Estimate, Status, Travel};

/// The window's frame rate may be off the nominal one by this share of it: no crystal is.
const RATE_SHARE: f32 = 0.005;

/// Margin before the window, frames.
const MARGIN_FRAMES: f32 = 2.0;

/// Frames that touch detection takes after a motion until it recognises a standstill:
/// [`crate::touch::motion::LONG_BLOCKS`], the block itself, four still ones and one more.
const KNOWN_STILL_FRAMES: u32 = (LONG_BLOCKS + 6) * BLOCK_FRAMES;

/// Adds the kinds of faults that were seen since a window began to its estimate. If they may have
/// changed the frequency, a good or unsteady estimate becomes doubtful, without period, speed and
/// direction.
///
/// Two kinds count outside of the window too. If levels may have moved shortly before it, the slide
/// may not have begun yet. If an input reached or left a rail shortly before its end, that may have
/// looked like motion.
///
/// To be called after a check of the chip's registers that followed the window's end: only it finds
/// a change in the window.
#[inline(never)]
pub fn qualify(estimate: &mut Estimate, window: &Window, diagnostics: &Diagnostics) {
    let (faults, is_end_unsure) = faults_of(window, estimate.window_s, diagnostics);
    estimate.faults = faults;
    let is_doubtful = is_end_unsure || faults.iter().any(FaultKind::changes_frequency);
    if is_doubtful {
        doubt(estimate);
    }
}

/// Makes a good or unsteady estimate doubtful, without period, speed and direction.
// Not inlined: it is called twice.
#[inline(never)]
pub fn doubt(estimate: &mut Estimate) {
    if matches!(estimate.status, Status::Good | Status::Unsteady) {
        estimate.status = Status::Doubtful;
        estimate.travel = Travel::NONE;
    }
}

/// The kinds of faults that were seen since the latest `window_s` seconds of a window began;
/// whether its end is unsure.
#[inline(never)]
pub fn faults_of(window: &Window, window_s: f32, diagnostics: &Diagnostics) -> (FaultSet, bool) {
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
    // A NaN is off too.
    if !(off_hz.abs() <= RATE_SHARE * nominal_hz) {
        faults = faults.with(FaultKind::Clock);
    }
    let is_end_unsure = diagnostics.rails_change(end_us.wrapping_sub(known_still_us), end_us);
    if is_end_unsure {
        // It may have been before the beginning of a short window.
        faults = faults.with(FaultKind::Overload);
    }
    (faults, is_end_unsure)
}
