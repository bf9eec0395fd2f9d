//! What a finger would feel in a window: how four kinds of mechanoreceptors fire, and what people
//! would say.

use crate::fault::FaultSet;
use serde::{Deserialize, Serialize};

/// Kinds of mechanoreceptors: FA I, FA II, SA I, SA II.
pub const RECEPTORS: usize = 4;

/// Bands of the spectrum: thirds of an octave from 0.5 Hz on. The last one ends at 813 Hz, just
/// above what receptors respond to.
pub const BANDS: usize = 32;

/// Level of a band in which the window has no line.
pub const NO_LEVEL: i8 = i8::MIN;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The value.
    pub value: f32,
    /// Its standard deviation.
    pub sigma: f32,
}

/// What a finger would feel, by the method of Sensors 18 (2018) 1588. The crate `ridgetone-feel`
/// has its equations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feel {
    /// Device time of the window's end, microseconds.
    pub t_us: u64,
    /// Length of the window, seconds: the latest part of an estimate's window that a transform can
    /// hold.
    pub window_s: f32,
    /// Values a second in it: frames, or means of a few of them.
    pub rate_hz: f32,
    /// Taxels that are valid in the window; bit k is taxel k.
    pub taxels: u16,
    /// Faults during the window.
    pub faults: FaultSet,
    /// Firing intensities of FA I, FA II, SA I and SA II with one term a hertz (equations 8 and 9
    /// times the distance of the bins), mean of the taxels. None where the rate is too low or the
    /// window too short for the receptor.
    pub per_hz: [Option<Measured>; RECEPTORS],
    /// Tangential over normal force: the settings', or that of the hold before the slide; none if
    /// neither is known.
    pub force_ratio: Option<Measured>,
    /// *Soft*, from 1 to 7 (equation 11).
    pub soft: Option<Measured>,
    /// *Rough*, from 1 to 7 (equation 12); none without forces.
    pub rough: Option<Measured>,
    /// Level of the strongest line in each third of an octave, decibels over one micrometre from
    /// peak to peak, root mean square over the taxels; [`NO_LEVEL`] where the spectrum has none.
    pub levels_db: [i8; BANDS],
}
