//! Numbers of estimates and conversions, of a run or of many.

use serde::Serialize;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Estimates with status `good` and no faults.
    pub good: u64,
    /// Estimates with status `good` that name faults.
    pub good_with_faults: u64,
    pub doubtful: u64,
    /// Estimates with status `good` that are off by more than five of their standard deviations,
    /// but by less than 0.5 %.
    pub off: u64,
    /// Wrong ones among those in `good`. Must be zero.
    pub wrong: u64,
    /// Wrong ones among those in `good_with_faults`. Must be zero.
    pub wrong_with_faults: u64,
    /// Conversions, frames or requests lost without a report. Must be zero.
    pub silent: u64,
    /// Conversions reported as lost beyond those that were.
    pub excess: u64,
    /// Conversions that arrived altered; packets, requests or settings that nobody sent. Must be
    /// zero.
    pub altered: u64,
    /// Fault episodes in runs without injections. Must be zero.
    pub false_alarms: u64,
}

impl Counts {
    /// Whether everything is zero that must be. `excess` must be where the number of lost
    /// conversions is known.
    pub fn is_clean(&self, loss_is_known: bool) -> bool {
        let Self {
            silent,
            altered,
            false_alarms,
            excess,
            ..
        } = *self;
        [
            self.wrong,
            self.wrong_with_faults,
            silent,
            altered,
            false_alarms,
        ] == [0; 5]
            && (excess == 0 || !loss_is_known)
    }
}

/// Adds structs of counts, field by field.
macro_rules! add_fields {
    ($counts:ident: $($field:ident)*) => {
        impl std::ops::AddAssign for $counts {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)*
            }
        }
    };
}
pub(super) use add_fields;

add_fields!(Counts: good good_with_faults doubtful off wrong wrong_with_faults silent excess altered false_alarms);
