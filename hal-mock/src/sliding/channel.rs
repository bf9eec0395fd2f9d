//! A channel's response to load and grating: a constant and a Fourier series in the grating's
//! position.

use core::f64::consts::TAU;

/// Pitch of the units along the sliding direction in mm (paper, section 2.1).
pub(crate) const PITCH_MM: f64 = 2.3;

/// One harmonic of a channel's tone: `cos_v` cos(h k x) + `sin_v` sin(h k x), at position x, with k
/// = 2 pi over the period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonic {
    /// Amplitude in phase with the position, in volts.
    pub cos_v: f64,
    /// Amplitude a quarter of a cycle behind, in volts.
    pub sin_v: f64,
}

impl Harmonic {
    /// `amplitude_v` sin(h k x + `phase_rad`).
    pub(crate) fn of_sine(amplitude_v: f64, phase_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(phase_rad);
        Self {
            cos_v: amplitude_v * sin,
            sin_v: amplitude_v * cos,
        }
    }

    /// Amplitude in volts, not negative.
    pub fn amplitude_v(self) -> f64 {
        libm::hypot(self.cos_v, self.sin_v)
    }

    /// Phase of the sine at x = 0, in radians, -pi to pi.
    pub fn phase_rad(self) -> f64 {
        libm::atan2(self.cos_v, self.sin_v)
    }
}

/// Voltage of a channel under the full load, as a function of the grating's position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pattern {
    /// Mean over a period, in volts.
    pub mean_v: f64,
    /// Varying part: the fundamental, then its overtones.
    pub tone: Vec<Harmonic>,
}

impl Pattern {
    /// Subtracts a pattern with the same number of harmonics.
    pub(crate) fn less(&self, other: &Self) -> Self {
        let pairs = self.tone.iter().zip(&other.tone);
        let tone = pairs.map(|(a, b)| Harmonic {
            cos_v: a.cos_v - b.cos_v,
            sin_v: a.sin_v - b.sin_v,
        });
        Self {
            mean_v: self.mean_v - other.mean_v,
            tone: tone.collect(),
        }
    }

    /// Volts at a position in turns: millimetres over the spatial period.
    pub(crate) fn volts(&self, turns: f64) -> f64 {
        // Drop whole turns to keep the argument of the sine small at any distance.
        let (sin, cos) = libm::sincos(TAU * (turns - libm::floor(turns)));
        let (mut sin_h, mut cos_h) = (sin, cos);
        let mut sum_v = self.mean_v;
        for harmonic in &self.tone {
            sum_v += harmonic.cos_v * cos_h + harmonic.sin_v * sin_h;
            (sin_h, cos_h) = (sin_h * cos + cos_h * sin, cos_h * cos - sin_h * sin);
        }
        sum_v
    }
}

/// Response of one channel to the touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Voltage without contact, in volts.
    pub offset_v: f64,
    /// Pattern under the hold's load while the grating slides: the mean is the step of the load,
    /// the tone comes from the ridges.
    pub sliding: Pattern,
    /// Part of `sliding` due to friction: absent at rest, reversed while the grating slides back.
    pub drag: Pattern,
    /// Height of the contact spike above the load's step in volts.
    pub spike_v: f64,
}

impl Channel {
    /// Volts above the offset under the hold's load, at a position in turns; `drag` is 1 at full
    /// slip, 0 at rest, -1 at full slip back.
    pub(crate) fn loaded_v(&self, turns: f64, drag: f64) -> f64 {
        // Randomly drawn channels have no drag.
        let missing_v = if self.drag.tone.is_empty() {
            0.0
        } else {
            (1.0 - drag) * self.drag.volts(turns)
        };
        self.sliding.volts(turns) - missing_v
    }

    /// Amplitude of the tone's fundamental while the grating slides, in volts.
    pub fn amplitude_v(&self) -> f64 {
        self.sliding
            .tone
            .first()
            .map_or(0.0, |fundamental| fundamental.amplitude_v())
    }
}
