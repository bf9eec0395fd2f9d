//! Memory that the steps share.

use crate::limits::{CHANNELS_MAX, POINTS_MAX};
use crate::matrix::Square;
use crate::neighbours::Neighbours;
use crate::normal::{EXPLAINED, Normal};
use crate::solve::Solution;
use crate::source::Values;

const ROWS: usize = rows(POINTS_MAX);

/// Rows of memory for what no step leaves to the next: what a model explains, or sums of transforms.
pub const fn rows(points: usize) -> usize {
    let explained = EXPLAINED.div_ceil(CHANNELS_MAX);
    let sums = (3 * points / 2).div_ceil(CHANNELS_MAX);
    if explained > sums { explained } else { sums }
}

/// Memory of the steps.
#[derive(Debug)]
pub struct Work {
    /// What no step leaves to the next: products of neighbours with the channels, what the model
    /// explains of a movement, or sums of transforms.
    pub memory: [Values; ROWS],
    /// Functions next to the lines.
    pub neighbours: Neighbours,
    /// The latest solution.
    pub solution: Solution,
    /// Equations of the movement; in the end its covariance.
    pub normal: Normal,
    /// Inverse covariance of the channels' noise.
    pub weights: Square<CHANNELS_MAX>,
    /// Score of the likeliest comb so far.
    pub score_of_best: f32,
    /// Inverse covariance of the noise next to its lines.
    pub weights_of_best: Square<CHANNELS_MAX>,
}

impl Work {
    /// All zeros.
    pub const fn new() -> Self {
        Self {
            memory: [[0.0; CHANNELS_MAX]; ROWS],
            neighbours: Neighbours::new(),
            solution: Solution::NONE,
            normal: Normal::NONE,
            weights: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
            score_of_best: 0.0,
            weights_of_best: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
        }
    }
}
