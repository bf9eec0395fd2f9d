//! Supervision of the chip: decides when its scan may be interrupted, and restarts it on a fault.

use super::{Acquisition, edge_ns};
use crate::converter::Converter;
use crate::faults::diagnostics::Diagnostics;
use embedded_hal::delay::DelayNs;
use ridgetone_proto::division::divide;
use ridgetone_proto::fault::FaultKind;

/// Number of conversions after an unexpected edge until an edge's time is again the end of a
/// conversion. Serving such an edge, including the check of the chip, takes at most one conversion.
const STEADY_CONVERSIONS: u32 = 4;
/// Number of times that a different scan is put off until a safe moment; then it begins at any
/// moment. With the plan `hand`, the scan of the health readings lasts for at most a second, and a
/// different plan waits for at most 0.2 s.
pub const PUT_OFF_MAX: u16 = 4_000;
/// Time without a conversion after which the chip counts as silent, microseconds: 500 conversions
/// by default.
const SILENT_US: u32 = 100_000;
/// Time without a conversion after which a check need not wait for the next one, microseconds.
const QUIET_US: u32 = 10_000;
/// Pause between the first and the second restart if the fault persists, microseconds. It doubles
/// each time.
const PAUSE_MIN_US: u32 = 125_000;
/// Longest pause, microseconds. A restart delays the other interrupts by only 0.1 ms, so longer
/// pauses would save nothing, and would delay the discovery that the chip works again.
const PAUSE_MAX_US: u32 = 4_000_000;
/// Time without a fault since a restart after which the chip counts as working, microseconds,
/// unless the pause is longer.
const WELL_US: u32 = 1_000_000;

impl<C: Converter> Acquisition<C> {
    /// True if no conversion is expected soon, so [`Self::watch`] can run now. Otherwise the best
    /// moment is right after a conversion, when the next edge is furthest away.
    pub fn is_quiet(&self, now_us: u32) -> bool {
        self.muted || !self.is_set_up || now_us.wrapping_sub(self.latest_us) > QUIET_US
    }

    /// True if a different scan can begin now without losing a conversion: the next one is far off,
    /// or none is expected soon. An edge's time is the end of a conversion, except soon after an
    /// unexpected edge, because a conversion may have ended while that edge was served. Refuses
    /// while DRDY is muted, because the next conversion of the present scan shows how many were
    /// lost. Agrees after 4,000 refusals in a row.
    pub fn can_begin(&mut self, now_us: u32) -> bool {
        let period_us = edge_ns(&self.plan) / 1000;
        let is_steady = now_us.wrapping_sub(self.unexpected_us) > STEADY_CONVERSIONS * period_us;
        let since_us = now_us.wrapping_sub(self.latest_us);
        let is_next_far = is_steady && since_us < period_us / 2 + self.converter.behind_us();
        let can =
            !self.muted && (is_next_far || self.is_quiet(now_us) || self.put_off >= PUT_OFF_MAX);
        self.put_off = if can {
            0
        } else {
            self.put_off.saturating_add(1)
        };
        can
    }

    /// Checks registers and silence, and restarts the chip on a fault. Must be called at least
    /// twice a second, after `Drdy::Watch`, and before an estimate is reported. `now_us` is board
    /// time. Returns true if DRDY was muted or the chip was restarted; the caller then unmutes
    /// DRDY. Otherwise, after an unexpected edge, the caller checks DRDY once more, because a
    /// conversion may have ended in the meantime.
    pub fn watch(
        &mut self,
        now_us: u32,
        diagnostics: &Diagnostics,
        wait: &mut impl DelayNs,
    ) -> bool {
        let was_muted = core::mem::take(&mut self.muted);
        if was_muted {
            // No conversion was read while DRDY was muted.
            let muted_us = now_us.wrapping_sub(self.latest_us);
            self.unseen.passed(muted_us);
            if self.is_health {
                // Gaps between frames show only lost conversions of the plan's own scan.
                diagnostics
                    .unseen
                    .add(divide(u64::from(muted_us) * 1000, self.plan.conversion_ns()).0 as u32);
            }
            (self.storm_count, self.latest_us) = (0, now_us);
            // The next conversion may be read late, at an edge of the storm.
            self.unexpected_us = now_us;
        }
        let fault = if !self.is_set_up {
            FaultKind::NoAnswer
        } else if !self.converter.is_as_set_up() && !self.converter.is_as_set_up() {
            // Read twice, because registers read while START is high may be wrong once (seen on
            // real chips).
            FaultKind::Registers
        } else if now_us.wrapping_sub(self.latest_us) > SILENT_US {
            FaultKind::Silent
        } else {
            self.unexpected_edges = 0;
            self.unseen.reset();
            if self.pause_us > 0
                && now_us.wrapping_sub(self.restarted_us) > self.pause_us.max(WELL_US)
            {
                self.pause_us = 0;
            }
            return was_muted;
        };
        if now_us.wrapping_sub(self.restarted_us) < self.pause_us {
            diagnostics.fault(fault, now_us);
            return was_muted;
        }
        diagnostics.chip_restarts.add(1);
        self.pause_us = (2 * self.pause_us).clamp(PAUSE_MIN_US, PAUSE_MAX_US);
        let since_us = now_us.wrapping_sub(self.latest_us);
        (self.restarted_us, self.latest_us) = (now_us, now_us);
        match fault {
            // The chip has not run since the failed set-up.
            FaultKind::NoAnswer => {}
            FaultKind::Registers => {
                let period_us = self.converter.min_period_us();
                diagnostics
                    .unseen
                    .add(self.unseen.at_most(since_us, period_us));
            }
            _ => diagnostics.unseen.add(self.unseen.of_clock(since_us)),
        }
        self.unseen.reset();
        // Skip the health readings, because a touch may be under way.
        self.is_health = false;
        let is_set_up = self.begin_scan(diagnostics, wait);
        // Report the fault even if the chip answers again after the restart: it has not been
        // reported yet.
        diagnostics.fault(
            if is_set_up {
                fault
            } else {
                FaultKind::NoAnswer
            },
            now_us,
        );
        true
    }
}
