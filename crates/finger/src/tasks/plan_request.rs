//! Hands a plan from the task that decides on it to the task that sets up the converter.

use core::sync::atomic::{AtomicU32, Ordering};
use ridgetone_proto::plan::{HealthReadings, Own, Plan, Sampling};

/// Number while a request is being written.
const MIDWAY: u32 = 0;

/// Plan requested for the converter. One task writes it, and a higher-priority task reads it. If
/// the reader interrupts the writer, the number shows that the words are incomplete.
#[derive(Debug)]
pub struct PlanRequest {
    /// Number of the request.
    number: AtomicU32,
    words: [AtomicU32; 5],
}

impl PlanRequest {
    /// Creates the first request, for the plan with which the converter is set up.
    pub const fn new(plan: &Plan) -> Self {
        let [a, b, c, d, e] = words(plan);
        Self {
            number: AtomicU32::new(MIDWAY + 1),
            words: [
                AtomicU32::new(a),
                AtomicU32::new(b),
                AtomicU32::new(c),
                AtomicU32::new(d),
                AtomicU32::new(e),
            ],
        }
    }

    /// Number of the latest request; `None` while it is being written.
    #[inline(always)]
    pub fn number(&self) -> Option<u32> {
        let number = self.number.load(Ordering::Acquire);
        (number != MIDWAY).then_some(number)
    }

    /// Plan of the latest request. Must not be called while [`Self::number`] returns `None`.
    pub fn plan(&self) -> Plan {
        let [packed, adc_clock_hz, frame_ticks, converter, bits] = self
            .words
            .each_ref()
            .map(|word| word.load(Ordering::Acquire));
        Plan {
            inputs: packed as u16,
            health: match packed >> 16 & 3 {
                0 => HealthReadings::EveryScan,
                1 => HealthReadings::BetweenTouches,
                _ => HealthReadings::Never,
            },
            sampling: match packed >> 18 & 1 {
                0 => Sampling::InTurn,
                _ => Sampling::AtOnce,
            },
            adc_clock_hz,
            frame_ticks,
            own: Own {
                converter: converter as u8,
                bits: bits as u16,
            },
        }
    }

    /// Requests a different plan.
    pub fn request(&self, plan: &Plan) {
        let next = self.number.load(Ordering::Relaxed).wrapping_add(1);
        self.number.store(MIDWAY, Ordering::Relaxed);
        for (place, word) in self.words.iter().zip(words(plan)) {
            // Release ordering: the number must be cleared first.
            place.store(word, Ordering::Release);
        }
        let next = if next == MIDWAY { next + 1 } else { next };
        self.number.store(next, Ordering::Release);
    }
}

const fn words(plan: &Plan) -> [u32; 5] {
    let health = match plan.health {
        HealthReadings::EveryScan => 0,
        HealthReadings::BetweenTouches => 1,
        HealthReadings::Never => 2,
    };
    let sampling = match plan.sampling {
        Sampling::InTurn => 0,
        Sampling::AtOnce => 1,
    };
    [
        plan.inputs as u32 | health << 16 | sampling << 18,
        plan.adc_clock_hz,
        plan.frame_ticks,
        plan.own.converter as u32,
        plan.own.bits as u32,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_plan_arrives_as_it_was_requested() {
        let request = PlanRequest::new(&Plan::PAPER);
        let mut latest = request.number();
        assert_eq!(request.plan(), Plan::PAPER);
        let frames = Plan::of_frames(1000.0, 3).unwrap();
        let plans = Plan::NAMED.map(|(_, plan)| plan);
        for plan in plans.iter().chain([&frames]) {
            request.request(plan);
            assert_ne!(request.number(), latest);
            latest = request.number();
            assert_eq!(request.plan(), *plan);
        }
    }
}
