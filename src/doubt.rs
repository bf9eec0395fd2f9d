//! No estimate is called good while something was wrong that may have changed it.

use crate::fault::FaultKind;
use crate::settings::FRAME_RATE_HZ;
use crate::tally::Tally;
use crate::telemetry::{Estimate, Status, Travel};
use crate::window::Window;

/// The window's frame rate may be off the nominal one by this share of it. No crystal is.
const RATE_SHARE: f32 = 0.005;

/// A margin at the window's beginning, microseconds: two frames.
const MARGIN_US: u32 = (2e6 / FRAME_RATE_HZ) as u32;

/// Adds to an estimate of a window the kinds of faults seen since the window began; where they may have changed the
/// frequency, what was good becomes doubtful, and nothing is said of period, speed and direction.
///
/// To be called after the chip's registers have been checked, and that after the window's end: what changed in it is
/// known only then.
#[inline(never)]
pub fn cast_doubt(estimate: &mut Estimate, window: &Window, tally: &Tally) {
    let length_us = (estimate.window_s * 1e6) as u32;
    let begin_us = (estimate.t_us as u32).wrapping_sub(length_us).wrapping_sub(MARGIN_US);
    let mut doubts = tally.faults.since(begin_us);
    let off_hz = window.frame_rate_hz - FRAME_RATE_HZ;
    // A rate that is no number is off too.
    if !(off_hz.abs() <= RATE_SHARE * FRAME_RATE_HZ) {
        doubts = doubts.with(FaultKind::Clock);
    }
    estimate.doubts = doubts;
    if doubts.iter().any(FaultKind::changes_frequency) && estimate.status == Status::Good {
        estimate.status = Status::Doubtful;
        estimate.travel = Travel::NONE;
    }
}
