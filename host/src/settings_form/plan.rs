//! A plan as text: its name, if it has one, otherwise the fields of its converter.

use ridgetone_finger::converter::{Ads1258Plan, OnboardPlan};
use ridgetone_proto::plan::{Converters, HealthReadings, Own, Plan, PlanError, Sampling};
use serde::{Deserialize, Serialize, Serializer};
use toml::Table;

/// Fields of a plan, as its converter defines them.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Fields {
    Ads1258(Ads1258Plan),
    Onboard(OnboardPlan),
    Other(OtherPlan),
}

/// A plan for an unknown converter.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherPlan {
    inputs: u16,
    health: HealthReadings,
    sampling: Sampling,
    adc_clock_hz: u32,
    frame_ticks: u32,
    converter: u8,
    bits: u16,
}

impl Fields {
    pub fn of(plan: &Plan) -> Self {
        if Ads1258Plan::check(plan).is_ok() {
            Self::Ads1258(Ads1258Plan::of(plan))
        } else if OnboardPlan::check(plan, u16::MAX, OnboardPlan::CLOCKS_MHZ).is_ok() {
            Self::Onboard(OnboardPlan::of(plan))
        } else {
            Self::Other(OtherPlan {
                inputs: plan.inputs,
                health: plan.health,
                sampling: plan.sampling,
                adc_clock_hz: plan.adc_clock_hz,
                frame_ticks: plan.frame_ticks,
                converter: plan.own.converter,
                bits: plan.own.bits,
            })
        }
    }

    /// Returns the fields that a table sets: those of `plan`, unless the table names fields of a
    /// different converter, such as in a file from a different board.
    pub fn for_table(plan: &Plan, given: &Table) -> Self {
        let names = |fields: &[&str]| fields.iter().any(|field| given.contains_key(*field));
        let found = Self::of(plan);
        match found {
            Self::Ads1258(_) | Self::Other(_) if names(&["scans"]) => Self::of(&Plan::ONBOARD),
            Self::Onboard(_) | Self::Other(_) if names(&["data_rate", "delay", "chop"]) => {
                Self::of(&Plan::PAPER)
            }
            Self::Ads1258(_) | Self::Onboard(_) if names(&["frame_ticks"]) => Self::of(&Plan {
                own: Own {
                    converter: Converters::FRAMES,
                    bits: 0,
                },
                ..*plan
            }),
            found => found,
        }
    }

    pub fn names(&self) -> &'static str {
        match self {
            Self::Ads1258(_) => "inputs, data_rate, delay, chop, health, adc_clock_hz",
            Self::Onboard(_) => "inputs, scans, clock_mhz",
            Self::Other(_) => {
                "inputs, health, sampling, adc_clock_hz, frame_ticks, converter, bits"
            }
        }
    }

    /// Parses fields of the same converter.
    pub fn read(&self, table: Table) -> Result<Self, toml::de::Error> {
        Ok(match self {
            Self::Ads1258(_) => Self::Ads1258(table.try_into()?),
            Self::Onboard(_) => Self::Onboard(table.try_into()?),
            Self::Other(_) => Self::Other(table.try_into()?),
        })
    }

    /// Returns the plan with these fields, if the converter can run it.
    pub fn plan(&self) -> Result<Plan, PlanError> {
        match self {
            Self::Ads1258(own) => own.validate().map(|()| own.plan()),
            Self::Onboard(own) => own.validate().map(|()| own.plan()),
            Self::Other(other) => {
                let plan = Plan {
                    inputs: other.inputs,
                    health: other.health,
                    sampling: other.sampling,
                    adc_clock_hz: other.adc_clock_hz,
                    frame_ticks: other.frame_ticks,
                    own: Own {
                        converter: other.converter,
                        bits: other.bits,
                    },
                };
                plan.validate().map(|()| plan)
            }
        }
    }
}

pub fn serialize<S: Serializer>(plan: &Plan, to: S) -> Result<S::Ok, S::Error> {
    match plan.name() {
        Some(name) => name.serialize(to),
        None => Fields::of(plan).serialize(to),
    }
}

pub fn names() -> String {
    Plan::NAMED.map(|(name, _)| name).join(", ")
}

pub fn meaning(field: &str) -> &'static str {
    match field {
        "inputs" => "Inputs that are converted: bit k is AINk.",
        "data_rate" => "DRATE of the ADS1258, 0 to 3: 3 is the fastest.",
        "delay" => "DLY of the ADS1258, 0 to 7: how long an input settles before it is converted.",
        "chop" => "Whether each conversion is two with the inputs exchanged, against offset.",
        "health" => {
            "When the chip reads its supply, reference, temperature, offset and gain: \"every_scan\" or \"between_touches\"."
        }
        "scans" => "Scans of the STM32's own converter to a frame, 1 to 255.",
        "clock_mhz" => "Clock of the STM32's own converter in MHz: a quarter of APB2's.",
        "adc_clock_hz" => {
            "Clock of the ADS1258: 15728640 Hz with its crystal, or that of an oscillator on CLKIO."
        }
        _ => "",
    }
}

/// Explains why a plan is refused, from the name in the error.
pub fn reason(name: &str) -> &'static str {
    match name {
        "plan.inputs" => "bit k of plan.inputs stands for input k",
        "plan.converter" => {
            "0 is the ADS1258, 1 the STM32's own: choose a plan of the board's converter by its name"
        }
        "plan.scans" => {
            "the frame is made of halves of a buffer: this is the next number that will do"
        }
        "plan.health" => "0 is \"every_scan\", 1 \"between_touches\"",
        "plan.chop" => {
            "the chip cannot read its own health while it chops: choose plan.health = \"between_touches\""
        }
        "plan.adc_clock_hz" => {
            "the boards' SPI is made for a chip of 13.2 to 16 MHz; 15728640 is the crystal's"
        }
        "frame_rate_hz" => {
            "what this plan gives: touch detection needs 180 frames a second; choose fewer inputs, a higher data_rate or a shorter delay"
        }
        _ => "",
    }
}
