//! What a board's wiring adds to its settings. It does not travel: the board's file says it.

/// When the inputs of a scan are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// One after another, a conversion each.
    InTurn,
    /// All at the moment of the data-ready edge.
    AtOnce,
}

/// What a board's wiring adds to its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiring {
    /// When the converter samples: [`Converter::SAMPLING`](crate::converter::Converter::SAMPLING).
    pub sampling: Sampling,
}

impl Wiring {
    /// The wiring of the guide: an ADS1258.
    pub const GUIDE: Self = Self {
        sampling: Sampling::InTurn,
    };
}
