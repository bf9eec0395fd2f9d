//! The ADS1258's part of a [`Plan`]: register fields.

use ads1258::{CRYSTAL_CLOCK_HZ, Config, DataRate, Delay, IdleMode, Mux, Sysred};
use ridgetone_proto::plan::{
    Bounds, Converters, HealthReadings, Own, Plan, PlanError, Sampling, within,
};
use serde::{Deserialize, Serialize};

/// Minimum clock of the chip, hertz: with a slower clock, the 190 ns that the boards allow CS to
/// settle are less than 2.5 periods (SBAS297G, SPI timing), and SCLK soon exceeds half the clock.
const CLOCK_MIN_HZ: f32 = 13_200_000.0;
/// Maximum clock of the chip, hertz (SBAS297G).
const CLOCK_MAX_HZ: f32 = 16_000_000.0;

/// Inputs that the chip converts, and its settings, which are fields of its registers (SBAS297G).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ads1258Plan {
    /// Bit k: the scan converts AINk, which is taxel k.
    pub inputs: u16,
    /// DRATE, 0 to 3: the chip's data rate.
    pub data_rate: u8,
    /// DLY, 0 to 7: settling time of an input before its conversion.
    pub delay: u8,
    /// CHOP: each conversion consists of two with the inputs exchanged. Excludes health readings in
    /// every scan.
    pub chop: bool,
    /// Schedule of the chip's health readings.
    pub health: HealthReadings,
    /// Clock of the chip, hertz: its crystal's 15,728,640, or that of an oscillator on CLKIO.
    pub adc_clock_hz: u32,
}

/// Bounds of the fields, in the order of the values in [`Ads1258Plan::validate`].
const BOUNDS: [Bounds; 5] = [
    ("plan.data_rate", 0.0, 3.0),
    ("plan.delay", 0.0, 7.0),
    ("plan.chop", 0.0, 0.0),
    ("plan.health", 0.0, 1.0),
    ("plan.adc_clock_hz", CLOCK_MIN_HZ, CLOCK_MAX_HZ),
];

impl Ads1258Plan {
    /// All inputs at 241 Hz, as in the paper: [`Plan::PAPER`].
    pub const PAPER: Self = Self::of(&Plan::PAPER);
    /// All inputs at 1.46 kHz: [`Plan::HAND`].
    pub const HAND: Self = Self::of(&Plan::HAND);

    /// Decodes the register fields of a plan; the result for a different converter's plan is
    /// meaningless.
    pub const fn of(plan: &Plan) -> Self {
        let bits = plan.own.bits;
        Self {
            inputs: plan.inputs,
            data_rate: bits as u8 & 3,
            delay: (bits >> 2) as u8 & 7,
            chop: bits >> 5 & 1 == 1,
            health: plan.health,
            adc_clock_hz: plan.adc_clock_hz,
        }
    }

    /// Returns the complete plan, with all other fields derived from the registers.
    pub const fn plan(&self) -> Plan {
        Plan {
            inputs: self.inputs,
            health: self.health,
            sampling: Sampling::InTurn,
            adc_clock_hz: self.adc_clock_hz,
            frame_ticks: self.config().frame_ticks(),
            own: Own {
                converter: Converters::ADS1258,
                bits: (self.data_rate as u16 & 3)
                    | (self.delay as u16 & 7) << 2
                    | (self.chop as u16) << 5
                    | (matches!(self.health, HealthReadings::BetweenTouches) as u16) << 6,
            },
        }
    }

    /// Checks the registers and what follows from them. The error names the first rule that is
    /// broken.
    pub fn validate(&self) -> Result<(), PlanError> {
        let is_chopped_with_health = self.chop && self.health == HealthReadings::EveryScan;
        let values = [
            self.data_rate as f32,
            self.delay as f32,
            is_chopped_with_health as u8 as f32,
            self.health as u8 as f32,
            self.adc_clock_hz as f32,
        ];
        within(&BOUNDS, &values)?;
        self.plan().validate()
    }

    /// Checks that a plan belongs to this chip and that its rates follow from its registers.
    pub fn check(plan: &Plan) -> Result<(), PlanError> {
        let own = Self::of(plan);
        let id = Converters::ADS1258.into();
        let ticks = own.config().frame_ticks() as f32;
        let bounds = [
            ("plan.converter", id, id),
            ("plan.frame_ticks", ticks, ticks),
        ];
        let values = [plan.own.converter as f32, plan.frame_ticks as f32];
        within(&bounds, &values)?;
        own.validate()?;
        if own.plan() == *plan {
            return Ok(());
        }
        let bits = own.plan().own.bits.into();
        Err(PlanError {
            field: "plan.bits",
            value: plan.own.bits.into(),
            bounds: (bits, bits),
        })
    }

    /// Configuration of the chip. It uses standby instead of sleep, so that the first conversion
    /// after START is not delayed.
    pub const fn config(&self) -> Config {
        let internal = match self.health {
            HealthReadings::EveryScan => Sysred::ALL,
            HealthReadings::BetweenTouches | HealthReadings::Never => Sysred::NONE,
        };
        self.config_of(self.inputs, internal, self.chop)
    }

    /// Configuration of the chip for its health readings alone, without CHOP, which excludes them
    /// (SBAS297G).
    pub const fn health_config(&self) -> Config {
        self.config_of(0, Sysred::ALL, false)
    }

    const fn config_of(&self, single: u16, internal: Sysred, chop: bool) -> Config {
        Config {
            clock_hz: self.adc_clock_hz,
            mux: Mux::AutoScan {
                differential: 0,
                single,
                internal,
            },
            data_rate: match self.data_rate {
                0 => DataRate::Drate0,
                1 => DataRate::Drate1,
                2 => DataRate::Drate2,
                _ => DataRate::Drate3,
            },
            delay: match self.delay {
                0 => Delay::Dly0,
                1 => Delay::Dly1,
                2 => Delay::Dly2,
                3 => Delay::Dly3,
                4 => Delay::Dly4,
                5 => Delay::Dly5,
                6 => Delay::Dly6,
                _ => Delay::Dly7,
            },
            chop,
            idle_mode: IdleMode::Standby,
            // Nothing is connected to these pins: open inputs would float and draw current, and the
            // clock output would toggle for nothing.
            gpio_inputs: 0,
            clock_output: false,
            ..Config::RESET
        }
    }
}

impl Default for Ads1258Plan {
    fn default() -> Self {
        Self::PAPER
    }
}

/// The table of plans assumes the crystal's clock.
const _: () = assert!(Plan::PAPER.adc_clock_hz == CRYSTAL_CLOCK_HZ);

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::settings::TAXELS;

    const PAPER: Ads1258Plan = Ads1258Plan::PAPER;

    #[test]
    fn the_usual_plans_are_what_the_registers_give() {
        for (name, plan) in Plan::usual(Converters::ADS1258) {
            let own = Ads1258Plan::of(&plan);
            assert_eq!(own.plan(), plan, "{name}");
            assert_eq!(Ads1258Plan::check(&plan), Ok(()), "{name}");
            assert_eq!(own.config().validate(), Ok(()), "{name}");
            assert_eq!(own.health_config().validate(), Ok(()), "{name}");
            assert_eq!(own.config().frame_rate_hz(), plan.frame_rate_hz(), "{name}");
            assert_eq!(own.config().slots(), plan.slots() as usize, "{name}");
        }
        let registers = |plan: Ads1258Plan| plan.config().registers();
        let slow = Ads1258Plan {
            adc_clock_hz: 15_272_727,
            ..PAPER
        };
        assert_eq!(registers(slow), registers(PAPER));
    }

    type Change<T> = fn(&mut T);

    #[test]
    fn registers_that_cannot_work_are_refused_by_what_is_wrong() {
        let with = |change: fn(&mut Ads1258Plan)| {
            let mut own = PAPER;
            change(&mut own);
            own
        };
        let refused: [(&str, Change<Ads1258Plan>); 9] = [
            ("plan.inputs", |own| own.inputs = 0),
            ("plan.data_rate", |own| own.data_rate = 4),
            ("plan.delay", |own| own.delay = 8),
            ("plan.chop", |own| {
                (own.chop, own.data_rate, own.delay) = (true, 3, 0)
            }),
            ("plan.health", |own| own.health = HealthReadings::Never),
            ("frame_rate_hz", |own| own.data_rate = 0),
            ("frame_rate_hz", |own| own.delay = 7),
            ("plan.adc_clock_hz", |own| own.adc_clock_hz = 8_000_000),
            ("plan.adc_clock_hz", |own| own.adc_clock_hz = 16_000_001),
        ];
        for (field, change) in refused {
            assert_eq!(
                with(change).validate().map_err(|error| error.field),
                Err(field)
            );
        }
        // SBAS297G, section "Chop": 16 MHz, CHOP 1, DRATE 2 and DLY 4 sample sixteen inputs at
        // 240.15 Hz; this test uses the crystal's clock.
        let chopped = with(|own| {
            (own.chop, own.data_rate, own.delay) = (true, 2, 4);
            own.health = HealthReadings::BetweenTouches;
        });
        assert_eq!(chopped.validate(), Ok(()));
        let rate_hz = chopped.plan().frame_rate_hz();
        assert!((rate_hz - 236.08).abs() < 0.01, "{rate_hz}");
    }

    #[test]
    fn a_plan_of_another_converter_or_with_a_false_rate_is_refused() {
        let refused: [(&str, Change<Plan>); 4] = [
            ("plan.converter", |plan| {
                plan.own.converter = Converters::ONBOARD
            }),
            ("plan.frame_ticks", |plan| plan.frame_ticks /= 2),
            ("plan.bits", |plan| plan.own.bits |= 1 << 12),
            ("plan.bits", |plan| plan.sampling = Sampling::AtOnce),
        ];
        for (field, change) in refused {
            let mut plan = Plan::PAPER;
            change(&mut plan);
            assert_eq!(plan.validate(), Ok(()), "nothing else is wrong with it");
            let found = Ads1258Plan::check(&plan).map_err(|error| error.field);
            assert_eq!(found, Err(field));
        }
    }

    #[test]
    fn every_valid_plan_has_a_window_and_survives_its_bits() {
        for bits in 0..1 << 7 {
            for channels in 1..=TAXELS {
                let health = match bits >> 6 {
                    0 => HealthReadings::EveryScan,
                    _ => HealthReadings::BetweenTouches,
                };
                let own = Ads1258Plan {
                    data_rate: bits & 3,
                    delay: bits >> 2 & 7,
                    chop: bits >> 5 & 1 == 1,
                    inputs: (0xffff_u32 >> (TAXELS - channels)) as u16,
                    health,
                    ..PAPER
                };
                let plan = own.plan();
                assert_eq!(Ads1258Plan::of(&plan), own);
                assert_eq!(plan.own.bits, u16::from(bits));
                if own.validate().is_err() {
                    continue;
                }
                assert_eq!(Ads1258Plan::check(&plan), Ok(()));
                let (window_s, stride_s) = plan.default_window();
                assert!(
                    plan.window_min_s() <= window_s && window_s <= plan.window_max_s(),
                    "{plan:?}"
                );
                assert!(
                    stride_s >= plan.stride_min_s() && plan.window_frames_max() > 60,
                    "{plan:?}"
                );
                // Touch detection works at 180 to 362 frames a second.
                let touch_hz = plan.frame_rate_hz() / plan.frames_averaged() as f32;
                assert!((180.0..=362.0).contains(&touch_hz), "{plan:?}: {touch_hz}");
            }
        }
    }
}
