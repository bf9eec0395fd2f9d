//! Guesses on the way from a periodogram to the fit.

use crate::nuisance::Curve;

/// The strongest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Cycles per half window ([`crate::abscissa`]).
    pub nu: f32,
    /// Whether there is a slope under it.
    pub slope: bool,
    /// The curve under it.
    pub curve: Curve,
    /// Its harmonics; 0 if their number is not known yet.
    pub harmonics: usize,
    /// Whether it may be the second, or the third, harmonic of its tone.
    pub suspects: [bool; 2],
    /// It is open whether this is the tone.
    pub ambiguous: bool,
}

impl SpectralLine {
    /// Whether it may be a harmonic of its tone.
    pub fn is_suspected(&self) -> bool {
        self.suspects != [false; 2]
    }
}

/// Where the fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialGuess {
    /// Cycles per half window ([`crate::abscissa`]).
    pub nu: f32,
    /// It is open whether this is the fundamental.
    pub ambiguous: bool,
    /// The fundamental below the strongest line that it belongs, or may belong, to; 0 if there is none.
    pub below: f32,
    /// Whether each channel has a slope.
    pub slope: bool,
    /// Curve of each channel.
    pub curve: Curve,
    /// Harmonics to fit; 0 if their number is not known yet.
    pub harmonics: usize,
}

impl InitialGuess {
    /// At a line that is its own fundamental.
    pub fn at(line: &SpectralLine) -> Self {
        let SpectralLine { nu, ambiguous, slope, curve, harmonics, .. } = *line;
        Self { nu, ambiguous, below: 0.0, slope, curve, harmonics }
    }
}
