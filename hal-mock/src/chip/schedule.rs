//! Schedules faults in the chip's virtual time, so that they act at the same moments with every
//! driver.
//!
//! A fault acts right after an edge of DRDY, before its result is read, so that the time of an edge
//! does not change after it was announced. While no conversion runs, the fault acts at its
//! scheduled time.

use super::Ads1258;
use super::faults::Fault;
use std::collections::VecDeque;

/// A fault with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// Beginning, seconds of scene time.
    pub at_s: f64,
    /// Duration, seconds; ignored for single events.
    pub lasts_s: f64,
    /// The fault.
    pub fault: Fault,
}

/// Times at which an injection acted, virtual nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Injected {
    /// Beginning of the fault.
    pub begun_ns: Option<u64>,
    /// End of the fault.
    pub over_ns: Option<u64>,
}

/// Pending injections, and a log of those that have acted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Schedule {
    /// Nanoseconds of scene time, number of the injection, and true for its beginning or false for
    /// its end.
    steps: VecDeque<(u64, usize, bool)>,
    log: Vec<Injected>,
}

impl Schedule {
    pub(crate) fn new(injections: &[Injection]) -> Self {
        let ns = |seconds: f64| (seconds.max(0.0) * 1e9) as u64;
        let mut steps: Vec<_> = injections
            .iter()
            .enumerate()
            .flat_map(|(number, one)| {
                [
                    (ns(one.at_s), number, true),
                    (ns(one.at_s + one.lasts_s), number, false),
                ]
            })
            .collect();
        // A stable sort keeps the beginning of a fault without duration before its end.
        steps.sort_by_key(|step| step.0);
        Self {
            steps: steps.into(),
            log: vec![Injected::default(); injections.len()],
        }
    }
}

impl Ads1258 {
    /// Times at which each of [`Options::injections`](super::Options::injections) acted.
    pub fn injected(&self) -> &[Injected] {
        &self.schedule.log
    }

    /// Time of the chip's next event: a result or, while no conversion runs, an injection.
    pub fn next_event_ns(&self) -> Option<u64> {
        self.next_result_ns()
            .or_else(|| Some(self.next_step_ns()?.max(self.now_ns)))
    }

    fn next_step_ns(&self) -> Option<u64> {
        self.schedule
            .steps
            .front()
            .and_then(|step| Some(self.zero_ns?.saturating_add(step.0)))
    }

    /// Begins and ends the injections that are due.
    pub(crate) fn inject(&mut self) {
        while self
            .next_step_ns()
            .is_some_and(|step_ns| step_ns <= self.now_ns)
        {
            let Some((_, number, begins)) = self.schedule.steps.pop_front() else {
                return;
            };
            let Some(fault) = self
                .options
                .injections
                .get(number)
                .map(|injection| injection.fault)
            else {
                return;
            };
            if let Some(log) = self.schedule.log.get_mut(number) {
                *(if begins {
                    &mut log.begun_ns
                } else {
                    &mut log.over_ns
                }) = Some(self.now_ns);
            }
            if begins {
                self.begin_fault(fault)
            } else {
                self.end_fault(fault)
            }
        }
    }
}
