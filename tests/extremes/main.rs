//! The extremes: what a finger may meet but a tidy test would not think of. In each the fit in f32
//! is near the maximum of the same likelihood in f64, or its status gives the reason why there is
//! none. Near is three tenths of the uncertainty in the fixed cases (`case::OFF_MAX`), and once the
//! whole of it in thousands of random corners (`corners::THOUSANDS_OFF_MAX`).

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
