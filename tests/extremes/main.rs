//! The extremes: what a finger may meet but a tidy test would not think of. In each the fit in f32
//! is near the truth, or its status gives the reason why there is none. Near is within the
//! uncertainty that the likelihood has in f64 (`case::OFF_MAX`).

#[path = "../support/any_settings.rs"]
mod any_settings;
#[allow(dead_code, reason = "every test file uses a part of it")]
#[path = "../reference/mod.rs"]
mod reference;

mod case;
mod corners;
mod counters;
mod disturbances;
mod drift;
mod frequencies;
mod levels;
mod not_a_number;
mod properties;
mod settings;
