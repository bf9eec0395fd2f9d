//! Whether a window has a tone.

/// How far a fit can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A common tone, with its uncertainty.
    Good,
    /// The channels share no tone that stands out of their noise.
    NoTone,
    /// The window holds too little of a cycle, or too few frames, to decide.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Two readings an octave (or another harmonic step) apart explain the window about equally well.
    Ambiguous,
}

impl Status {
    /// Whether a fit of this status has a frequency.
    pub const fn has_tone(self) -> bool {
        matches!(self, Self::Good | Self::Ambiguous)
    }
}
