//! A plan by its name, if it has one, otherwise by its fields.

use ridgetone_proto::plan::Plan;
use serde::{Serialize, Serializer};

/// Serializes a plan.
pub fn serialize<S: Serializer>(plan: &Plan, to: S) -> Result<S::Ok, S::Error> {
    match plan.name() {
        Some(name) => name.serialize(to),
        None => plan.serialize(to),
    }
}

/// Names of the usual plans.
pub fn names() -> String {
    Plan::NAMED.map(|(name, _)| name).join(", ")
}

/// What a field is.
pub fn meaning(field: &str) -> &'static str {
    match field {
        "inputs" => "Inputs that are converted: bit k is AINk.",
        "data_rate" => "DRATE of the ADS1258, 0 to 3: 3 is the fastest.",
        "delay" => "DLY of the ADS1258, 0 to 7: how long an input settles before it is converted.",
        "chop" => "Whether each conversion is two with the inputs exchanged, against offset.",
        "health" => {
            "When the chip reads its supply, reference, temperature, offset and gain: \"every_scan\" or \"between_touches\"."
        }
        "adc_clock_hz" => {
            "Clock of the ADS1258: 15728640 Hz with its crystal, or that of an oscillator on CLKIO."
        }
        _ => "",
    }
}

/// Why a plan is refused, by the name in the refusal.
pub fn reason(name: &str) -> &'static str {
    match name {
        "plan.inputs" => "bit k of plan.inputs stands for AINk",
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
