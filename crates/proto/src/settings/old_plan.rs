//! Plans as firmware before converters had plans of their own kept them: the ADS1258's registers.
//!
//! It describes bytes in somebody's flash, and never changes.

use crate::plan::{Converters, HealthReadings, Own, Plan, Sampling};
use serde::Deserialize;

/// Id of the setting in a record of version 4.
pub const ID: u8 = 1;

/// The registers' fields, without the clock.
#[derive(Deserialize)]
pub struct Registers {
    inputs: u16,
    data_rate: u8,
    delay: u8,
    chop: bool,
    health: Health,
}

#[derive(Clone, Copy, Deserialize)]
enum Health {
    EveryScan,
    BetweenTouches,
}

/// Reads the value of the setting.
pub fn read(value: &[u8]) -> Option<Plan> {
    let (registers, clock) = postcard::take_from_bytes::<Registers>(value).ok()?;
    let (adc_clock_hz, rest) = postcard::take_from_bytes::<u32>(clock).ok()?;
    rest.is_empty().then(|| registers.plan(adc_clock_hz))
}

impl Registers {
    /// The plan with a clock of the chip.
    pub fn plan(&self, adc_clock_hz: u32) -> Plan {
        let (data_rate, delay) = (self.data_rate & 3, self.delay & 7);
        // SBAS297G, data rate equations, in clock periods.
        let averages = 1 << (2 * (3 - data_rate));
        let settling = [0, 1, 2, 4, 8, 16, 32, 48][usize::from(delay)];
        let ticks = (546 + 128 * (averages + settling)) << u8::from(self.chop);
        let (health, is_between) = match self.health {
            Health::EveryScan => (HealthReadings::EveryScan, 0),
            Health::BetweenTouches => (HealthReadings::BetweenTouches, 1),
        };
        let plan = Plan {
            inputs: self.inputs,
            health,
            sampling: Sampling::InTurn,
            adc_clock_hz,
            frame_ticks: 0,
            own: Own {
                converter: Converters::ADS1258,
                bits: u16::from(data_rate | delay << 2)
                    | u16::from(self.chop) << 5
                    | is_between << 6,
            },
        };
        Plan {
            frame_ticks: plan.slots() * ticks,
            ..plan
        }
    }
}
