//! The residuals of a solution, sample by sample.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX, NUISANCES_MAX};
use crate::nuisance::{Columns, Nuisances};
use crate::solution::Solution;
use crate::source::{Overwritten, Values};
use crate::waves::{Oscillator, Waves};

/// Residual sums of squares of each channel, sample by sample: the difference of two sums of squares would lose a small
/// residual in rounding.
pub fn residual_sums_of_squares(
    span: &mut FrameSpan,
    levels: &Levels,
    nuisances: &Nuisances,
    solution: &Solution,
) -> Result<Values, Overwritten> {
    let oscillator = Oscillator::new(span, solution.nu, solution.shape.harmonics);
    let (mut waves, mut columns) = (Waves::new(), [[0.0; NUISANCES_MAX]; BLOCK]);
    let mut sums = [0f32; CHANNELS_MAX];
    span.blocks(&levels.offset, &mut |block| {
        oscillator.fill(&block, &mut waves);
        nuisances.fill(&block, &waves.u, &mut columns);
        for c in 0..CHANNELS_MAX {
            if levels.usable & 1 << c != 0 {
                sums[c] += of_channel(&block, c, levels.offset[c], solution, &waves, &columns);
            }
        }
    })?;
    Ok(sums)
}

/// Of one channel in one block.
#[inline(never)]
fn of_channel(block: &Block, c: usize, level: f32, solution: &Solution, waves: &Waves, columns: &Columns) -> f32 {
    let shape = &solution.shape;
    let unknown = |index: usize| solution.unknowns[index][c];
    let (zero, slope) = (level + unknown(0), if shape.slope { unknown(1) } else { 0.0 });
    // Frame by frame: it is seldom needed, and unrolled it would take a kilobyte of flash.
    let mut sum = 0.0;
    for i in (0..BLOCK).filter(|i| block.valid[*i] != 0) {
        let mut residual = block.values[i][c] - zero - slope * waves.u[i];
        for k in 0..shape.nuisances.min(NUISANCES_MAX) {
            residual -= unknown(1 + shape.slope as usize + k) * columns[i][k];
        }
        for h in 0..shape.harmonics.min(HARMONICS_MAX) {
            let (cos, sin) = solution.harmonic(h);
            residual -= cos[c] * waves.cos[h][i] + sin[c] * waves.sin[h][i];
        }
        sum += residual * residual;
    }
    sum
}
