//! Service delay in scans with one slot.
//!
//! All ids are the same, so only time shows a loss. A conversion that is read late hides a loss
//! after it, because the time to the next one is too short. But a conversion is late by less than
//! its duration, because the next one then replaces it, and no conversion is early. So the least
//! late conversions are taken to be on time, and the others are measured from them.

use ridgetone_proto::division::divide;

/// Exponent of the delay's decay: 2^-6 of a conversion, 1.6 %, per conversion, which exceeds any
/// clock error.
const CATCH_UP: u32 = 6;
/// [`CATCH_UP`] in a storm, which may delay all conversions alike: 244 ppm, twice the difference
/// between two crystals.
const CATCH_UP_IN_STORM: u32 = 12;
/// Number of conversions that may belong to a storm after one that was early or late: 0.17 s with
/// the plan `single`.
const STORM_CONVERSIONS: u16 = 4096;
/// Number of lost conversions in a row after which clocks may differ by more than service is late.
const LONG_GAP: u32 = 8;

/// Service delay of the latest conversion.
#[derive(Clone, Copy, Debug)]
pub struct ServiceDelay {
    late_ns: u32,
    /// Number of further conversions that may belong to a storm.
    in_storm: u16,
}

impl ServiceDelay {
    pub const NONE: Self = Self {
        late_ns: 0,
        in_storm: 0,
    };

    /// Returns the number of conversions since the previous one, at least one. `passed_us` is the
    /// time since then, `step_ns` that of one conversion.
    pub fn steps(&mut self, passed_us: u32, step_ns: u32) -> u32 {
        let passed_ns = passed_us as u64 * 1000;
        let is_off_time = passed_ns.abs_diff(step_ns as u64) > (step_ns * 3 / 8) as u64;
        self.in_storm = if is_off_time {
            STORM_CONVERSIONS
        } else {
            self.in_storm.saturating_sub(1)
        };
        let catch_up = if self.in_storm > 0 {
            CATCH_UP_IN_STORM
        } else {
            CATCH_UP
        };
        let on_time_ns = (step_ns + (step_ns >> catch_up)) as u64;
        let late_ns = (self.late_ns as u64 + passed_ns).saturating_sub(on_time_ns);
        // A conversion that is late by three quarters of its duration or more counts as the next
        // one.
        let early_ns = if late_ns > (LONG_GAP * step_ns) as u64 {
            step_ns / 2
        } else {
            step_ns / 4
        };
        if late_ns + (early_ns as u64) < step_ns as u64 {
            // Nearly always this avoids the division.
            self.late_ns = late_ns as u32;
            return 1;
        }
        let (more, late_ns) = divide(late_ns + early_ns as u64, step_ns);
        self.late_ns = late_ns.saturating_sub(early_ns);
        more as u32 + 1
    }
}
