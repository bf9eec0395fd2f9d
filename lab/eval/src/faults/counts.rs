//! Counts of estimates and conversions, over one or more runs.

use serde::Serialize;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Estimates with status `good` and no faults.
    pub good: u64,
    /// Estimates with status `good` that report faults.
    pub good_with_faults: u64,
    pub doubtful: u64,
    /// Estimates with status `good` that are off by more than five standard deviations, but by less
    /// than 0.5 %.
    pub off: u64,
    /// Wrong estimates among `good`. Must be zero.
    pub wrong: u64,
    /// Wrong estimates among `good_with_faults`. Must be zero.
    pub wrong_with_faults: u64,
    /// Conversions, frames or requests lost without a report. Must be zero.
    pub silent: u64,
    /// Conversions reported as lost that were not lost.
    pub excess: u64,
    /// Conversions that arrived altered, and received packets, requests or settings that were never
    /// sent. Must be zero.
    pub altered: u64,
    /// Fault episodes in runs without injections. Must be zero.
    pub false_alarms: u64,
    /// Faults after which no complete scan with correct registers follows within five seconds. Must
    /// be zero.
    pub not_recovered: u64,
    /// Runs that ended with wrong register values. Must be zero.
    pub wrong_registers: u64,
    /// In runs without injections: estimates that are doubtful or report faults, and runs without
    /// any estimate. Must be zero.
    pub not_good: u64,
    /// In runs without injections: estimates to which the estimator's own tests give a status other
    /// than `good`. Must not exceed the false alarms of these tests.
    pub not_plain: u64,
    /// Telemetry packets lost or damaged without a report by the board. Must be zero.
    pub packets_unreported: u64,
}

impl Counts {
    /// Returns the number of control estimates whose status is not `good`, if it exceeds the
    /// expected false alarms by more than three standard deviations.
    fn beyond_false_alarms(&self, rate: f64) -> u64 {
        let expected = rate * (self.good + self.not_good + self.not_plain) as f64;
        let is_chance = self.not_plain as f64 <= expected + 3.0 * expected.sqrt();
        if is_chance { 0 } else { self.not_plain }
    }

    /// Returns names and values of the counts that must be zero but are not, including `excess` if
    /// `loss_is_known`. `false_alarm_rate` is the fraction of windows of a steady tone to which the
    /// estimator may give a status other than `good`.
    pub fn failures(&self, loss_is_known: bool, false_alarm_rate: f64) -> Vec<String> {
        let excess = if loss_is_known { self.excess } else { 0 };
        let must_be_zero = [
            ("wrong", self.wrong),
            ("wrong_with_faults", self.wrong_with_faults),
            ("silent", self.silent),
            ("excess", excess),
            ("altered", self.altered),
            ("false_alarms", self.false_alarms),
            ("not_recovered", self.not_recovered),
            ("wrong_registers", self.wrong_registers),
            ("not_good", self.not_good),
            ("not_plain", self.beyond_false_alarms(false_alarm_rate)),
            ("packets_unreported", self.packets_unreported),
        ];
        let failed = must_be_zero.into_iter().filter(|(_, count)| *count > 0);
        failed
            .map(|(name, count)| format!("{name} {count}"))
            .collect()
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

add_fields!(Counts: good good_with_faults doubtful off wrong wrong_with_faults silent excess altered false_alarms
    not_recovered wrong_registers not_good not_plain packets_unreported);
