//! No estimate is called good while something was wrong that may have changed it.

use crate::faults::diagnostics::Diagnostics;
use crate::touch::motion::{BLOCK_FRAMES, LONG_BLOCKS};
use crate::window::Window;
use ridgetone_proto::fault::{FaultKind, FaultSet};
use ridgetone_proto::settings::FRAME_RATE_HZ;
use ridgetone_proto::telemetry::{Estimate, Status, Travel};

/// The window's frame rate may be off the nominal one by this share of it. No crystal is.
const RATE_SHARE: f32 = 0.005;

/// A margin at the window's beginning, microseconds: two frames.
const MARGIN_US: u32 = (2e6 / FRAME_RATE_HZ) as u32;

/// So long after something moved, microseconds, a hold that follows it is known to be one, and the slide over that it was
/// taken for: [`crate::touch::motion::LONG_BLOCKS`], the block itself, four still ones and one more.
const KNOWN_STILL_US: u32 = ((LONG_BLOCKS + 6) as f32 * BLOCK_FRAMES as f32 * 1e6 / FRAME_RATE_HZ) as u32;

/// Adds to an estimate of a window the kinds of faults seen since the window began; where they may have changed the
/// frequency, what was good becomes doubtful, and nothing is said of period, speed and direction. Where levels may have
/// moved shortly before the window, what it holds may not be a slide yet. Where an input reached a rail or came back from it
/// shortly before its end, what looked like motion then may have been that, and the window hold a standstill.
///
/// To be called after the chip's registers have been checked, and that after the window's end: what changed in it is
/// known only then.
#[inline(never)]
pub fn qualify(estimate: &mut Estimate, window: &Window, diagnostics: &Diagnostics) {
    let length_us = (estimate.window_s * 1e6) as u32;
    let end_us = estimate.t_us as u32;
    let begin_us = end_us.wrapping_sub(length_us).wrapping_sub(MARGIN_US);
    let before =
        diagnostics.faults.since(begin_us.wrapping_sub(KNOWN_STILL_US)).iter().filter(|kind| kind.moves_levels());
    let mut faults = before.fold(diagnostics.faults.since(begin_us), FaultSet::with);
    let off_hz = window.frame_rate_hz - FRAME_RATE_HZ;
    // A rate that is no number is off too.
    if !(off_hz.abs() <= RATE_SHARE * FRAME_RATE_HZ) {
        faults = faults.with(FaultKind::Clock);
    }
    let is_end_unsure = diagnostics.rails_change(end_us.wrapping_sub(KNOWN_STILL_US), end_us);
    if is_end_unsure {
        // It may be before a window that is short.
        faults = faults.with(FaultKind::Overload);
    }
    estimate.faults = faults;
    let is_doubtful = is_end_unsure || faults.iter().any(FaultKind::changes_frequency);
    if is_doubtful && estimate.status == Status::Good {
        estimate.status = Status::Doubtful;
        estimate.travel = Travel::NONE;
    }
}
