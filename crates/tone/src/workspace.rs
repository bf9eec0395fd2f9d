//! Memory shared by the steps of a fit.

use crate::limits::{
    CHANNELS_MAX, IMPULSES_MAX, NOISE_BINS_COMB, NOISE_BINS_MAX, POINTS_CHIP, POINTS_MAX,
};
use crate::matrix::Square;
use crate::noise_bins::NoiseBins;
use crate::normal::{MOVEMENT_MAX, Normal};
use crate::solve::Solution;
use crate::source::Values;
use crate::spectrum::Sums;

const ROWS: usize = rows(POINTS_MAX);

/// Number of rows of scratch memory. On a PC the transform sums need the most; on the chip a third
/// of these sums is kept in the memory of the normal equations.
pub const fn rows(points: usize) -> usize {
    if points > POINTS_CHIP {
        (3 * points / 2).div_ceil(CHANNELS_MAX)
    } else {
        NOISE_BINS_MAX
    }
}
/// First row of the kept weights, beyond the rows that combs and impulses use.
const KEPT: usize = ROWS - CHANNELS_MAX;
const _: () = assert!(KEPT >= NOISE_BINS_COMB && KEPT * CHANNELS_MAX >= 2 * IMPULSES_MAX);
const _: () = assert!(rows(POINTS_CHIP) * CHANNELS_MAX >= POINTS_CHIP);
const _: () = assert!(size_of::<Square<MOVEMENT_MAX>>() / 4 >= POINTS_CHIP / 2);

/// Memory for the steps of a fit.
#[derive(Debug)]
pub struct Workspace {
    /// Scratch memory: products of noise bins with the channels, sums over blocks for the normal
    /// equations, or sums of transforms.
    pub memory: [Values; ROWS],
    pub noise_bins: NoiseBins,
    pub solution: Solution,
    /// Normal equations of the modulation; finally its covariance.
    pub normal: Normal,
    /// Inverse covariance of the channels' noise.
    pub weights: Square<CHANNELS_MAX>,
    /// Score of the likeliest comb so far.
    pub score_of_best: f32,
}

impl Workspace {
    pub const fn new() -> Self {
        Self {
            memory: [[0.0; CHANNELS_MAX]; ROWS],
            noise_bins: NoiseBins::new(),
            solution: Solution::NONE,
            normal: Normal::NONE,
            weights: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
            score_of_best: 0.0,
        }
    }

    /// Keeps the weights of the likeliest comb so far, in the memory's last rows.
    pub fn keep_weights(&mut self) {
        self.memory[KEPT..].copy_from_slice(&self.weights);
    }

    pub fn restore_weights(&mut self) {
        self.weights.copy_from_slice(&self.memory[KEPT..]);
    }

    /// Memory for the sums of a transform, shared with the normal equations.
    pub fn sums(&mut self) -> Sums<'_> {
        Sums {
            memory: self.memory.as_flattened_mut(),
            more: self.normal.matrix.as_flattened_mut(),
        }
    }
}
