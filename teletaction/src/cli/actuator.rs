//! The actuator that makes the vibration, and how a texture drives it.

use crate::link::Hand;
use crate::stimulus::{Actuator, Delay};
use crate::texture;
use crate::touch::Output;
use anyhow::Result;
use clap::Args;
use ridgetone_host::cli::parse::{number, positive};
use ridgetone_host::usage::UsageError;
use std::path::PathBuf;

#[derive(Args, Clone, Debug)]
pub struct ActuatorOptions {
    /// Measured law of a finger's power, a polynomial of the period p: `coefficients` of 1 to p^4,
    /// `period_mm`, `power_max`; uses the texture's power [default: the paper's law].
    #[arg(long, value_name = "FILE.toml")]
    law: Option<PathBuf>,
    /// Maximum voltage of the actuator, V.
    #[arg(long, value_name = "V", default_value_t = f64::from(Actuator::PIEZO.voltage_v), value_parser = positive)]
    voltage_v: f64,
    /// Cut-off of the actuator (-3 dB), Hz: vibrations above it fade, and are gone at twice the
    /// cut-off.
    #[arg(long, value_name = "HZ", default_value_t = f64::from(Actuator::PIEZO.cutoff_hz), value_parser = positive)]
    cutoff_hz: f64,
    /// Maximum change of the voltage, V/s.
    #[arg(long, value_name = "V_S", default_value_t = f64::from(Actuator::PIEZO.slew_v_s), value_parser = positive)]
    slew_v_s: f64,
}

impl ActuatorOptions {
    pub fn output(&self) -> Result<Output> {
        let law = self.law.as_deref().map(texture::load_law).transpose()?;
        let actuator = Actuator {
            voltage_v: self.voltage_v as f32,
            cutoff_hz: self.cutoff_hz as f32,
            slew_v_s: self.slew_v_s as f32,
            ..Actuator::PIEZO
        };
        Output::new(actuator, law).map_err(|error| UsageError(format!("{error:#}")).into())
    }
}

#[derive(Args, Clone, Copy, Debug)]
pub struct DelayOptions {
    /// Mean delay, ms; 120 in the paper.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    pub delay_ms: f64,
    /// Standard deviation of the delay, which is redrawn every 200 ms, ms; 40 in the paper.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    pub jitter_ms: f64,
}

impl DelayOptions {
    pub fn check(&self) -> Result<()> {
        let Self {
            delay_ms,
            jitter_ms,
        } = self;
        let [mean_s, sigma_s] = [delay_ms, jitter_ms].map(|ms| (ms / 1e3) as f32);
        Delay::new(mean_s, sigma_s, 1).map(drop).map_err(|_| {
            let why = format!(
                "--delay-ms {delay_ms} --jitter-ms {jitter_ms}: choose 0 to 1000, and 0 to 500"
            );
            UsageError(why).into()
        })
    }
}

#[derive(Args, Clone, Copy, Debug)]
pub struct HandOptions {
    /// Mean speed of the simulated hand, mm/s.
    #[arg(long, value_name = "MM_S", value_parser = positive)]
    pub speed_mm_s: Option<f64>,
    /// Frequency of the hand's motion to and fro, Hz; at 0 the hand never turns.
    #[arg(long, value_name = "HZ", value_parser = number, allow_negative_numbers = true)]
    turns_hz: Option<f64>,
}

impl HandOptions {
    /// Returns the hand that the options describe, with `default` for missing options.
    pub fn hand(&self, default: Hand) -> Result<Hand> {
        let hand = Hand {
            speed_mm_s: self.speed_mm_s.unwrap_or(default.speed_mm_s),
            turns_hz: self.turns_hz.unwrap_or(default.turns_hz),
        };
        if hand.speed_mm_s > 2000.0 || !(0.0..=10.0).contains(&hand.turns_hz) {
            let why = "--speed-mm-s is at most 2000, and --turns-hz is 0 to 10";
            return Err(UsageError(why.into()).into());
        }
        Ok(hand)
    }
}
