//! Delay of the conversions of a scan with one slot.
//!
//! All ids are the same, so only time shows a loss. A conversion that is read late hides a loss
//! after it: the time to the next one is too short. But a conversion is late by less than the time
//! of one, because the next one takes its place, and no conversion is early. So the least late
//! conversions are on time, and the others are measured from them.

use ridgetone_proto::division::divide;

/// Per conversion the delay shrinks by a conversion's time over two to this power: by 1.6 %, more
/// than a clock is off.
const CATCH_UP: u32 = 6;
/// [`CATCH_UP`] in a storm, which may hold up all conversions alike: 244 ppm, twice what two crystals
/// differ by.
const CATCH_UP_IN_STORM: u32 = 12;
/// Conversions that may be in a storm after one that was off its time: 0.17 s with the plan
/// `single`.
const STORM_CONVERSIONS: u16 = 4096;
/// After so many lost conversions in a row the two clocks differ by more than service is late.
const LONG_GAP: u32 = 8;

/// Service delay of the latest conversion.
#[derive(Clone, Copy, Debug)]
pub struct ServiceDelay {
    late_ns: u32,
    /// Conversions that may still be in a storm.
    in_storm: u16,
}

impl ServiceDelay {
    pub const NONE: Self = Self {
        late_ns: 0,
        in_storm: 0,
    };

    /// Number of conversions since the previous one, at least one, from the time since then,
    /// microseconds, and the time of one conversion, nanoseconds.
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
        // An edge that is served when three quarters have passed shows the next conversion.
        let early_ns = if late_ns > (LONG_GAP * step_ns) as u64 {
            step_ns / 2
        } else {
            step_ns / 4
        };
        if late_ns + (early_ns as u64) < step_ns as u64 {
            // Nearly always, and without the division.
            self.late_ns = late_ns as u32;
            return 1;
        }
        let (more, late_ns) = divide(late_ns + early_ns as u64, step_ns);
        self.late_ns = late_ns.saturating_sub(early_ns);
        more as u32 + 1
    }
}
