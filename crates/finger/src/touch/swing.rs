//! What means of frames hide: motion that is faster than they are.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::chi_square::root;
use ridgetone_proto::plan::Plan;
use ridgetone_tone::Values;

/// Noise that is not white makes a comparison larger while nothing moves. Motion is this many times
/// what it was then.
pub const OVER_TYPICAL: f32 = 4.0;
/// [`OVER_TYPICAL`] for an average of blocks, which varies less than one block.
pub const FAINT_OVER_TYPICAL: f32 = 1.3;
/// Standard deviations of the squares of averaged frames about their means that are motion, and
/// those of an average of them, which has a third of theirs.
const SWINGING: f32 = 8.0;
const SWINGING_FAINT: f32 = 1.5;

/// The squares of averaged frames about their means: what is faster than the means. They are
/// weighted as differences of the means are, so only their ratio to what is typical says something.
/// Noise alone makes them a chi-square with a degree of freedom for each frame but one of a mean,
/// of each taxel.
#[derive(Clone, Debug)]
pub struct Swing {
    /// Multiples of what is typical above which one block is motion, and an average of blocks.
    pub limit: f32,
    pub faint_limit: f32,
    /// The sum over the block under way.
    pub sum: f32,
}

impl Swing {
    pub const fn new(plan: &Plan) -> Self {
        let freedom = (BLOCK_FRAMES * (plan.frames_averaged() - 1)) as f32 * plan.channels() as f32;
        // Standard deviation over mean.
        let root = if freedom > 0.0 {
            root(2.0 / freedom)
        } else {
            0.0
        };
        let (limit, faint_limit) = (1.0 + SWINGING * root, 1.0 + SWINGING_FAINT * root);
        Self {
            limit: if limit > OVER_TYPICAL {
                limit
            } else {
                OVER_TYPICAL
            },
            faint_limit: if faint_limit > FAINT_OVER_TYPICAL {
                faint_limit
            } else {
                FAINT_OVER_TYPICAL
            },
            sum: 0.0,
        }
    }

    /// Adds those about one mean.
    pub fn add(&mut self, squares: &Values, weights: &Values) {
        self.sum += squares
            .iter()
            .zip(weights)
            .fold(0.0, |sum, (square, weight)| sum + square * weight);
    }
}
