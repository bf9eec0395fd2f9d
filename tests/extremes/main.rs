//! Extreme inputs that a finger may meet. The f32 fit must be within `case::OFF_MAX` standard
//! deviations of the f64 likelihood, or its status must say why there is no result.

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
