//! A block of frames, and what motion detection finds in it.

/// Frames of a block: 16.6 ms at 241 Hz.
pub const BLOCK_FRAMES: u32 = 4;

/// What one block of frames shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// It differs within itself or from the block before: something moves right now.
    pub now: bool,
    /// That, or it differs from the course of the last
    /// [`SHORT_BLOCKS`](super::motion::SHORT_BLOCKS).
    pub quick: bool,
    /// It differs from the course of the last [`LONG_BLOCKS`](super::motion::LONG_BLOCKS).
    pub slow: bool,
    /// The latest blocks differ among each other, if only on the average.
    pub faint: bool,
    /// It differs from the course of the last [`LONGEST_BLOCKS`](super::motion::LONGEST_BLOCKS).
    pub longest: bool,
    /// True if a `quick` change cannot be explained by the load alone: the finger moves along the
    /// surface. Computed only if [`seeks_across`](super::motion::Motion::seeks_across) is set.
    pub across: bool,
}

impl Block {
    /// Whether it shows any change.
    pub const fn moves(&self) -> bool {
        self.moves_lately() || self.longest
    }

    /// Whether it shows one within the last [`LONG_BLOCKS`](super::motion::LONG_BLOCKS).
    pub const fn moves_lately(&self) -> bool {
        self.quick || self.slow || self.faint
    }
}
