//! A texture: the surface under the finger, rather than the vibration of the sensors.

use crate::plan::Plan;
use serde::{Deserialize, Serialize};

/// Second, third and fourth harmonic relative to the fundamental, common to the valid channels,
/// independent of their gains and delays: real and imaginary part of a dimensionless ratio. The
/// magnitude is the ratio of the amplitudes; the angle is the phase of harmonic h minus h times the
/// fundamental's, both as cosines. Zeros for a harmonic that was not fitted.
pub type Overtones = [[f32; 2]; 3];

/// A texture under the finger. Sent after the estimate in which it was found: the first of a touch,
/// and again after a change of more than three standard deviations of the difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Device time of the end of the estimate's window, microseconds.
    pub t_us: u64,
    /// Scan plan of the window; `power_v2` refers to its inputs.
    pub plan: Plan,
    /// Spatial period, millimetres.
    pub period_mm: f32,
    /// Standard deviation of the spatial period, millimetres.
    pub period_sigma_mm: f32,
    /// Power of the fundamental: half of its squared amplitude, averaged over the valid channels,
    /// square volts.
    pub power_v2: f32,
    /// Standard deviation of the power due to white noise, square volts.
    pub power_sigma_v2: f32,
    /// Harmonics above the first, in the time domain.
    pub overtones: Overtones,
    /// Pressure of the finger: mean level of the taxels in the hold before the slide, less the
    /// level before the touch, volts, signed; `None` without such a hold ([`Image`](super::Image)).
    pub level_v: Option<f32>,
}
