//! Plans of the STM32's own converter: continuous scans that are averaged into frames.

use super::oversampled::{Averaging, SAMPLE_TICKS, SCANS_MAX};
use core::ops::RangeInclusive;
use ridgetone_proto::plan::{Converters, HealthReadings, Own, Plan, PlanError, Sampling, within};
use serde::{Deserialize, Serialize};

/// Inputs that the STM32's own converter samples, and the number of scans per frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnboardPlan {
    /// Bit k: the scan includes input k, which is taxel k.
    pub inputs: u16,
    /// Scans per frame.
    pub scans: u8,
    /// Clock of the converter, megahertz: a quarter of APB2's.
    #[serde(default = "usual_clock_mhz")]
    pub clock_mhz: u8,
}

/// Clock of the STM32F405's and F446's converter with APB2 at 84 MHz, megahertz.
const fn usual_clock_mhz() -> u8 {
    21
}

impl OnboardPlan {
    /// Clock range of the STM32's ADC, MHz (DS8626, ADC characteristics, supply above 2.4 V).
    pub const CLOCKS_MHZ: RangeInclusive<u8> = 1..=36;

    /// Decodes a plan; the result for a different converter's plan is meaningless.
    pub const fn of(plan: &Plan) -> Self {
        Self {
            inputs: plan.inputs,
            scans: plan.own.bits as u8,
            clock_mhz: (plan.adc_clock_hz / 1_000_000) as u8,
        }
    }

    /// Returns the complete plan, with all derived fields.
    pub const fn plan(&self) -> Plan {
        Plan {
            inputs: self.inputs,
            health: HealthReadings::Never,
            sampling: Sampling::AtOnce,
            adc_clock_hz: self.clock_mhz as u32 * 1_000_000,
            frame_ticks: self.inputs.count_ones() * self.scans as u32 * SAMPLE_TICKS,
            own: Own {
                converter: Converters::ONBOARD,
                bits: self.scans as u16,
            },
        }
    }

    /// Averaging of the scans into frames; `None` if a frame is not a whole number of halves of the
    /// buffer.
    pub const fn averaging(&self) -> Option<Averaging> {
        Averaging::new(self.inputs.count_ones(), self.scans as u32, self.clock_mhz)
    }

    /// Checks the plan, and that this many scans can make a frame. The error names the next number
    /// that can.
    pub fn validate(&self) -> Result<(), PlanError> {
        self.plan().validate()?;
        if self.averaging().is_some() {
            return Ok(());
        }
        let does = |scans: &u8| {
            Self {
                scans: *scans,
                ..*self
            }
            .averaging()
            .is_some()
        };
        let above = (self.scans..=SCANS_MAX).find(does);
        let next = above.or_else(|| (1..self.scans).rev().find(does));
        let next = f32::from(next.unwrap_or(SCANS_MAX));
        let bounds = ("plan.scans", next, next);
        within(&[bounds], &[self.scans.into()])
    }

    /// Checks that a plan fits `pins` (bit k for input k from 0 on) and a converter with one of
    /// these clocks, and that its rates follow from its number of scans.
    pub fn check(plan: &Plan, pins: u16, clocks_mhz: RangeInclusive<u8>) -> Result<(), PlanError> {
        let mut own = Self::of(plan);
        own.clock_mhz = own
            .clock_mhz
            .max(*clocks_mhz.start())
            .min(*clocks_mhz.end());
        let [id, clock_hz, ticks] = [
            Converters::ONBOARD as f32,
            own.plan().adc_clock_hz as f32,
            own.plan().frame_ticks as f32,
        ];
        let bounds = [
            ("plan.converter", id, id),
            ("plan.inputs", 1.0, pins.into()),
            ("plan.adc_clock_hz", clock_hz, clock_hz),
            ("plan.frame_ticks", ticks, ticks),
        ];
        let values = [
            plan.own.converter as f32,
            plan.inputs.into(),
            plan.adc_clock_hz as f32,
            plan.frame_ticks as f32,
        ];
        within(&bounds, &values)?;
        own.validate()?;
        if own.plan() == *plan {
            return Ok(());
        }
        let bits = f32::from(own.plan().own.bits);
        Err(PlanError {
            field: "plan.bits",
            value: plan.own.bits.into(),
            bounds: (bits, bits),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a plan on a board with the usual clock.
    fn check(plan: &Plan, pins: u16) -> Result<(), PlanError> {
        OnboardPlan::check(plan, pins, 21..=21)
    }

    #[test]
    fn the_usual_plans_are_what_scans_give() {
        let usual = |(_, plan): &(_, Plan)| plan.own.converter == Converters::ONBOARD;
        let plans = Plan::NAMED.iter().filter(|named| usual(named));
        assert_eq!(plans.clone().count(), 2);
        for (name, plan) in plans {
            assert_eq!(OnboardPlan::of(plan).plan(), *plan, "{name}");
            assert_eq!(check(plan, 0x3fff), Ok(()), "{name}");
        }
        // The Feather has eight inputs.
        let refused = check(&Plan::ONBOARD, 0xff).unwrap_err();
        assert_eq!(
            (refused.field, refused.bounds),
            ("plan.inputs", (1.0, 255.0))
        );
        for (scans, clock_mhz) in [(160, 21), (28, 21), (190, 25)] {
            let plan = OnboardPlan {
                inputs: 0xff,
                scans,
                clock_mhz,
            }
            .plan();
            assert_eq!(
                OnboardPlan::check(&plan, 0xff, clock_mhz..=clock_mhz),
                Ok(())
            );
        }
    }

    #[test]
    fn what_cannot_work_is_refused_by_what_can() {
        let refused = |plan: Plan| {
            let error = check(&plan, 0x3fff).unwrap_err();
            (error.field, error.bounds)
        };
        let scans = |scans| {
            OnboardPlan {
                inputs: 0x3fff,
                scans,
                clock_mhz: 21,
            }
            .plan()
        };
        let mut wrong = [Plan::ONBOARD; 2];
        wrong[0].frame_ticks = 100_000;
        wrong[1].health = HealthReadings::BetweenTouches;
        assert_eq!(refused(Plan::PAPER), ("plan.converter", (1.0, 1.0)));
        // 91 is 7 x 13, so a half of the buffer would hold a single scan, which is too short.
        assert_eq!(refused(scans(91)), ("plan.scans", (92.0, 92.0)));
        assert_eq!(refused(scans(200)).0, "frame_rate_hz");
        let at_25_mhz = OnboardPlan {
            clock_mhz: 25,
            ..OnboardPlan::of(&Plan::ONBOARD)
        };
        assert_eq!(
            refused(at_25_mhz.plan()),
            ("plan.adc_clock_hz", (21e6, 21e6))
        );
        assert_eq!(
            wrong.map(|plan| refused(plan).0),
            ["plan.frame_ticks", "plan.bits"]
        );
    }
}
