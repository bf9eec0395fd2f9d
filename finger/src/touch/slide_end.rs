//! When did a slide end: where the taxels arrived at the course along which the skin creeps when nothing moves any more.

use crate::touch::motion::Motion;
use crate::touch::onset::Frames;
use crate::touch::past::{BLOCK_FRAMES, SKIP_MAX};
use ridgetone_tone::Values;

/// Blocks from the one in which a slide is last known to have moved to the mean of four that shows where the taxels were
/// soon after it: a slow tone in noise may go on for one of them unnoticed.
const SOON_BLOCKS: u32 = 2;
/// Least distance of two means of four blocks that shows a creep, blocks: nearer ones share some.
const CREEP_BLOCKS: usize = 4;

/// The first frame after a slide that moved until frame `moving_until` at least, and was known to be over with the block
/// that ended with frame `over`: the latest one. The last four blocks have the mean `level`.
pub fn slide_end(frames: &Frames, motion: &Motion, level: &Values, moving_until: u32, over: u32) -> u32 {
    // Blocks between the mean soon after the slide and that of the last four.
    let still = over.wrapping_sub(moving_until) / BLOCK_FRAMES;
    let skip = (still.saturating_sub(SOON_BLOCKS + 4) as usize).min(SKIP_MAX);
    let soon = motion.past().mean_of_four(skip);
    let per_block = if skip < CREEP_BLOCKS { 0.0 } else { 1.0 / skip as f32 };
    let creep = core::array::from_fn(|c| (level[c] - soon[c]) * per_block);
    let middle = over.wrapping_sub(skip as u32 * BLOCK_FRAMES + 2 * BLOCK_FRAMES - 1);
    // The block that moved last differs from the one before it, where the change may have been.
    frames.arrival_creeping(&soon, &creep, middle, moving_until.wrapping_sub(BLOCK_FRAMES))
}
