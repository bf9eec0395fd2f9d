//! Result of motion detection in a block of frames.

/// Frames per block: 16.6 ms at 241 Hz.
pub const BLOCK_FRAMES: u32 = 4;

/// Result of one block of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The block differs within itself or from the block before: something moves right now.
    pub now: bool,
    /// As `now`, or the block differs from the trend of the last
    /// [`SHORT_BLOCKS`](super::motion::SHORT_BLOCKS).
    pub quick: bool,
    /// The block differs from the trend of the last [`LONG_BLOCKS`](super::motion::LONG_BLOCKS).
    pub slow: bool,
    /// The latest blocks differ on average, by less than would show in a single block.
    pub faint: bool,
    /// The block differs from the trend of the last
    /// [`LONGEST_BLOCKS`](super::motion::LONGEST_BLOCKS).
    pub longest: bool,
    /// True if a `quick` change cannot be explained by the load alone: the finger moves along the
    /// surface. Computed only if [`seeks_across`](super::motion::Motion::seeks_across) is set.
    pub across: bool,
}

impl Block {
    /// True if the block shows any change.
    pub const fn moves(&self) -> bool {
        self.moves_lately() || self.longest
    }

    /// True if the block shows a change within the last
    /// [`LONG_BLOCKS`](super::motion::LONG_BLOCKS).
    pub const fn moves_lately(&self) -> bool {
        self.quick || self.slow || self.faint
    }
}
