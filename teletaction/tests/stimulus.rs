//! The stimulus against the true surface in f64, as sound, and within its limits whatever comes.

#[path = "stimulus/limits.rs"]
mod limits;
#[path = "stimulus/surface.rs"]
mod surface;
#[path = "stimulus/vibration.rs"]
mod vibration;
