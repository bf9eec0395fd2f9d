//! A texture: what is under the finger, instead of how it shakes the sensors.

use crate::plan::Plan;
use serde::{Deserialize, Serialize};

/// The second, third and fourth harmonic against the fundamental, common to the valid channels,
/// whatever their gains and delays: real and imaginary part of a ratio without a unit. Its
/// magnitude is the amplitude over the fundamental's; its angle is the phase less as many times the
/// fundamental's, both as cosines. Zeros of a harmonic that was not fitted.
pub type Overtones = [[f32; 2]; 3];

/// A texture under the finger. It follows the estimate that has found it: the first one of a touch,
/// and again when it has changed by more than three standard deviations of the difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Device time of the end of the estimate's window, microseconds.
    pub t_us: u64,
    /// Scan plan of the window: the power is that of its inputs.
    pub plan: Plan,
    /// Spatial period, millimetres.
    pub period_mm: f32,
    /// Standard deviation of the spatial period, millimetres.
    pub period_sigma_mm: f32,
    /// Power of the fundamental: half of its squared amplitude, the mean of the valid channels,
    /// square volts.
    pub power_v2: f32,
    /// Standard deviation of the power due to white noise, square volts.
    pub power_sigma_v2: f32,
    /// Harmonics above the first, in time as the finger slid.
    pub overtones: Overtones,
    /// How hard the finger presses: mean level of the taxels in the hold before the slide, less
    /// that before the touch, volts, signed; none without such a hold ([`Image`](super::Image)).
    pub level_v: Option<f32>,
}
