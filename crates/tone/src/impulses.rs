//! Impulses: single values far off what is around them. Squares weigh one of twenty standard
//! deviations as four hundred others, so where there are some they are replaced and the window is
//! fitted anew.
//!
//! It is one step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics"
//! (2nd edition, 2009), section 4.8.

use crate::cleaned::Impulses;
use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::limits::CHANNELS_MAX;
use crate::solve::Solution;
use crate::source::Overwritten;
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;

/// Most of a window's values that may be impulses.
const SHARE_MAX: f32 = 0.03;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// An impulse is five standard deviations off, by the mean magnitude: white noise is in one of two
/// million values.
const SIGMAS: f32 = 5.0;
/// More values than this, so close to each other, are no impulses.
const TOGETHER: u32 = 2;
const CLOSE: usize = 2;

impl Impulses {
    /// Those that a solution leaves.
    #[inline(never)]
    pub fn find(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        channels: &Channels,
        solution: &Solution,
        at: (f32, Option<f32>),
    ) -> Result<(), Overwritten> {
        let (abscissa, frames) = (span.abscissa(), span.frames);
        let mut waves = Waves::new(span, statistics, solution, at);
        // By the root mean square at first, which impulses raise: one in a hundred of twenty
        // standard deviations makes it twice as large.
        let mut limits = solution
            .residual_squares
            .map(|square| SIGMAS * libm::sqrtf(square / solution.frames));
        let mut magnitudes = [0.0; CHANNELS_MAX];
        for _ in 0..2 {
            self.begin(frames);
            span.blocks(&statistics.offset, &mut |block| {
                waves.go(abscissa.block(block.first, frames));
                let there = block
                    .valid
                    .iter()
                    .rev()
                    .fold(0, |there, valid| there << 1 | (*valid != 0) as u16);
                for ((k, c), limit) in channels.list().iter().enumerate().zip(&limits) {
                    let c = *c as usize % CHANNELS_MAX;
                    let (residuals, mut far) = (waves.residuals(block.values, c, k), 0);
                    for (i, (residual, valid)) in residuals.iter().zip(block.valid).enumerate() {
                        let magnitude = if *valid != 0 { residual.abs() } else { 0.0 };
                        magnitudes[k % CHANNELS_MAX] += magnitude;
                        far |= ((magnitude > *limit) as u16) << i;
                    }
                    if far != 0 {
                        self.add(&block, c, &residuals, [far, there], statistics.scale[c]);
                    }
                }
            })?;
            if self.count() as f32 > SHARE_MAX * solution.frames * channels.width as f32 {
                // That is too many for impulses.
                self.begin(frames);
            }
            if !self.are_found() {
                break;
            }
            limits =
                magnitudes.map(|magnitude| SIGMAS / MEAN_MAGNITUDE * magnitude / solution.frames);
        }
        Ok(())
    }

    /// Adds a channel's impulses in a block, of which some frames are far off, and some are there.
    #[inline(never)]
    fn add(
        &mut self,
        block: &Block,
        c: usize,
        residuals: &[f32; BLOCK],
        [far, there]: [u16; 2],
        scale: f32,
    ) {
        for i in (0..BLOCK).filter(|i| far & 1 << i != 0) {
            let close = ((1u32 << (i + CLOSE + 1)) - (1 << i.saturating_sub(CLOSE))) as u16 & there;
            if (close & far).count_ones() > TOGETHER {
                continue;
            }
            let others = close & !far;
            let beside = residuals
                .iter()
                .enumerate()
                .filter(|(i, _)| others & 1 << i != 0)
                .map(|(_, beside)| beside);
            let off =
                residuals[i % BLOCK] - beside.sum::<f32>() / others.count_ones().max(1) as f32;
            self.push(
                block.first as usize + i,
                c,
                block.values[i % BLOCK][c % CHANNELS_MAX] - off / scale,
            );
        }
    }
}
