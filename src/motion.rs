//! Is anything moving? Short means of the frames compared with each other at several distances.
//!
//! Each comparison sums over the taxels in units of their noise, so under a still finger it is a
//! chi-square with sixteen degrees of freedom. First differences see quick changes; second
//! differences at longer distances see slow waves but not the straight creep of a skin that was
//! just loaded.

use crate::settings::TAXELS;
use crate::window::Values;

/// Frames of a short mean: 16.6 ms at 241 Hz.
pub const BLOCK_FRAMES: u32 = 4;
/// Distance of the short second difference, blocks: 33 ms.
const SHORT: usize = 2;
/// Distance of the long second difference, blocks: 133 ms.
const LONG: usize = 8;
/// Blocks that the short comparison reaches back: 66 ms.
pub const SHORT_BLOCKS: u32 = 2 * SHORT as u32;
/// Blocks that the long comparison reaches back: 267 ms.
pub const LONG_BLOCKS: u32 = 2 * LONG as u32;
/// Blocks that are remembered.
const HISTORY: usize = 2 * LONG + 1;
/// Blocks over which the noise is averaged, once there are so many: 0.5 s.
const LEARN_BLOCKS: f32 = 32.0;
/// A comparison of sixteen taxels above this is motion: a chi-square's mean of 16 and eight of its
/// standard deviations of 5.7. A day has 5 million blocks.
const MOVING: f32 = 61.0;
/// The same for the differences from frame to frame over a block: mean 128, eight times 35.
const JUMPING: f32 = 410.0;
/// Noise that is not white makes a comparison larger while nothing moves; motion is this many times
/// what it was then.
const OVER_TYPICAL: f32 = 4.0;

/// What one block of frames says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Mean of its frames.
    pub mean: Values,
    /// It differs within itself or from the block before: something moves right now.
    pub now: bool,
    /// That, or it differs from the course of the last [`SHORT_BLOCKS`].
    pub quick: bool,
    /// It differs from the course of the last [`LONG_BLOCKS`].
    pub slow: bool,
}

/// Noise of the taxels and the recent past.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Variance of each taxel's frames: the greater of the two below.
    variance: Values,
    /// By the differences from frame to frame: right for white noise.
    quick_variance: Values,
    /// By the differences from block to block: larger where neighbouring frames share their noise, as
    /// those of a recording that was interpolated do.
    slow_variance: Values,
    learned: f32,
    typical: [f32; 4],
    previous: Option<Values>,
    sum: Values,
    squares: Values,
    count: u32,
    history: [Values; HISTORY],
    blocks: usize,
    /// The comparisons of the block that is being dealt with.
    compared: [f32; 4],
}

impl Motion {
    /// At rest, having seen nothing.
    pub const fn new() -> Self {
        Self {
            variance: [1.0; TAXELS],
            quick_variance: [1.0; TAXELS],
            slow_variance: [0.0; TAXELS],
            learned: 0.0,
            typical: [0.0; 4],
            previous: None,
            sum: [0.0; TAXELS],
            squares: [0.0; TAXELS],
            count: 0,
            history: [[0.0; TAXELS]; HISTORY],
            blocks: 0,
            compared: [0.0; 4],
        }
    }

    /// Forgets the past but not the noise: what follows is compared with itself only.
    pub fn restart(&mut self) {
        self.blocks = 0;
        // What was compared with the past goes with it; what was within the block stays.
        let [_, past @ ..] = &mut self.compared;
        *past = [0.0; 3];
    }

    /// Takes the next frame; gives a block when it was the last of one.
    pub fn push(&mut self, values: &Values) -> Option<Block> {
        let previous = self.previous.replace(*values).unwrap_or(*values);
        for c in 0..TAXELS {
            let change = values[c] - previous[c];
            self.sum[c] += values[c];
            self.squares[c] += change * change;
        }
        self.count += 1;
        if self.count < BLOCK_FRAMES {
            return None;
        }
        let mean = self.sum.map(|sum| sum / BLOCK_FRAMES as f32);
        self.compared = self.compare(&mean);
        let [within, before, short, long] = self.compared;
        let over = |value: f32, limit: f32, typical: f32| value > limit.max(OVER_TYPICAL * typical);
        let now = over(within, JUMPING, self.typical[0]) || over(before, MOVING, self.typical[1]);
        let block = Block {
            mean,
            now,
            quick: now || over(short, MOVING, self.typical[2]),
            slow: over(long, MOVING, self.typical[3]),
        };
        self.history[self.blocks % HISTORY] = mean;
        self.blocks = if self.blocks + 1 == 2 * HISTORY { HISTORY } else { self.blocks + 1 };
        Some(block)
    }

    /// Ends the block that [`Self::push`] gave; a still one teaches what the noise is.
    pub fn next_block(&mut self, still: bool) {
        if still {
            self.learned = (self.learned + 1.0).min(LEARN_BLOCKS);
            let share = 1.0 / self.learned;
            let mean = self.sum.map(|sum| sum / BLOCK_FRAMES as f32);
            for (typical, value) in self.typical.iter_mut().zip(self.compared) {
                *typical += share * (value - *typical);
            }
            let before = self.back(2).copied().unwrap_or(mean);
            for c in 0..TAXELS {
                // Two neighbours' difference has twice the variance of one; a mean of four frames has a
                // quarter of that of one.
                let quick = self.squares[c] / (2 * BLOCK_FRAMES) as f32;
                let off = mean[c] - before[c];
                let slow = off * off * BLOCK_FRAMES as f32 / 2.0;
                // A code is an integer: less than 1/12 of its square is not noise but luck.
                self.quick_variance[c] += share * (quick.max(1.0 / 12.0) - self.quick_variance[c]);
                self.slow_variance[c] += share * (slow - self.slow_variance[c]);
                self.variance[c] = self.quick_variance[c].max(self.slow_variance[c]);
            }
        }
        self.sum = [0.0; TAXELS];
        self.squares = [0.0; TAXELS];
        self.count = 0;
    }

    /// Mean of the `count` latest blocks but the `skip` very latest, as far as they are remembered.
    /// None if there is not one.
    pub fn recent_mean(&self, skip: usize, count: usize) -> Option<Values> {
        let mut sum = [0.0; TAXELS];
        let mut found = 0.0;
        for back in skip + 1..=skip + count {
            if let Some(block) = self.back(back) {
                for c in 0..TAXELS {
                    sum[c] += block[c];
                }
                found += 1.0;
            }
        }
        (found > 0.0).then(|| sum.map(|sum| sum / found))
    }

    /// Standard deviation of one taxel's noise, frame by frame, codes.
    pub fn sigma(&self, taxel: usize) -> f32 {
        libm::sqrtf(self.variance[taxel])
    }

    /// Squared distance of two levels in units of one frame's noise.
    pub fn distance(&self, a: &Values, b: &Values) -> f32 {
        let mut sum = 0.0;
        for c in 0..TAXELS {
            let off = a[c] - b[c];
            sum += off * off / self.variance[c];
        }
        sum
    }

    /// The block `back` blocks ago, 1 being the latest.
    fn back(&self, back: usize) -> Option<&Values> {
        (back >= 1 && back <= self.blocks.min(HISTORY)).then(|| &self.history[(self.blocks - back) % HISTORY])
    }

    /// The four comparisons of a block: within itself, and with those before it, zero where the past is
    /// too short.
    fn compare(&self, mean: &Values) -> [f32; 4] {
        let within = (0..TAXELS).map(|c| self.squares[c] / self.variance[c]).sum();
        let frames = BLOCK_FRAMES as f32;
        let before = match self.back(1) {
            Some(before) => self.distance(mean, before) * frames / 2.0,
            None => 0.0,
        };
        let second = |distance: usize| match (self.back(distance), self.back(2 * distance)) {
            (Some(near), Some(far)) => {
                let mut bend = [0.0; TAXELS];
                for c in 0..TAXELS {
                    bend[c] = 2.0 * near[c] - far[c];
                }
                self.distance(mean, &bend) * frames / 6.0
            }
            _ => 0.0,
        };
        [within, before, second(SHORT), second(LONG)]
    }
}

impl Default for Motion {
    fn default() -> Self {
        Self::new()
    }
}
