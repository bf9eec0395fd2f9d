//! What a solution leaves of the channels, sample by sample.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::levels::Levels;
use crate::moments::HARMONICS_MAX;
use crate::nuisance::{Columns, NUISANCES_MAX, Nuisances};
use crate::solve::Solution;
use crate::source::CHANNELS_MAX;
use crate::source::Values;
use crate::waves::{Oscillator, Waves};

/// Sums of squares of what a solution leaves of each channel, taken sample by sample: the difference of
/// two sums of squares would drown a small residual in rounding. None if the frames were overwritten.
pub fn residuals(span: &mut FrameSpan, levels: &Levels, nuisances: &Nuisances, solution: &Solution) -> Option<Values> {
    let oscillator = Oscillator::new(span, solution.nu, solution.shape.harmonics);
    let (mut waves, mut columns) = (Waves::new(), [[0.0; NUISANCES_MAX]; BLOCK]);
    let mut sums = [0f32; CHANNELS_MAX];
    span.blocks(&levels.offset, &mut |block| {
        oscillator.fill(&block, &mut waves);
        nuisances.fill(&block, &waves.u, &mut columns);
        for c in 0..CHANNELS_MAX {
            if levels.usable & 1 << c != 0 {
                sums[c] += left(&block, c, levels.offset[c], solution, &waves, &columns);
            }
        }
    })?;
    Some(sums)
}

/// Of one channel in one block.
#[inline(never)]
fn left(block: &Block, c: usize, level: f32, solution: &Solution, waves: &Waves, columns: &Columns) -> f32 {
    let shape = &solution.shape;
    let unknown = |index: usize| solution.unknowns[index][c];
    let (zero, slope) = (level + unknown(0), if shape.slope { unknown(1) } else { 0.0 });
    // Frame by frame: it is seldom asked for, and unrolled it would take a kilobyte of flash.
    let mut sum = 0.0;
    for i in (0..BLOCK).filter(|i| block.valid[*i] != 0) {
        let mut residual_sum_of_squares = block.values[i][c] - zero - slope * waves.u[i];
        for k in 0..shape.nuisances.min(NUISANCES_MAX) {
            residual_sum_of_squares -= unknown(1 + shape.slope as usize + k) * columns[i][k];
        }
        for h in 0..shape.harmonics.min(HARMONICS_MAX) {
            let (cos, sin) = solution.harmonic(h);
            residual_sum_of_squares -= cos[c] * waves.cos[h][i] + sin[c] * waves.sin[h][i];
        }
        sum += residual_sum_of_squares * residual_sum_of_squares;
    }
    sum
}
