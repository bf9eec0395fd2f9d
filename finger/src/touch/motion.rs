//! Is anything moving? Short means of the frames compared with each other at several distances.
//!
//! Each comparison sums over the taxels in units of their noise, so under a still finger it is a chi-square with a degree
//! of freedom for each taxel. First differences see quick changes. Second differences at longer distances see slow waves,
//! but not the straight creep of a skin that was just loaded.

use crate::touch::chi_square::{distance, limit};
use crate::touch::noise::{Noise, greater};
pub use crate::touch::past::BLOCK_FRAMES;
use crate::touch::past::Past;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Distance of the short second difference, blocks: 33 ms.
const SHORT: usize = 2;
/// Distance of the long second difference, blocks: 133 ms.
const LONG: usize = 8;
/// Blocks that the short comparison reaches back: 66 ms.
pub const SHORT_BLOCKS: u32 = 2 * SHORT as u32;
/// Blocks that the long comparison reaches back: 267 ms.
pub const LONG_BLOCKS: u32 = 2 * LONG as u32;
/// A comparison above this is motion: 61 for 16 taxels, a chi-square's mean of 16 and eight of its standard deviations of
/// 5.7. A day has 5 million blocks.
const MOVING: f32 = limit(1.0, 45.0);
/// The same for the differences from frame to frame over a block: mean 128, eight times 35.
const JUMPING: f32 = limit(8.0, 282.0);
/// Noise that is not white makes a comparison larger while nothing moves. Motion is this many times what it was then.
const OVER_TYPICAL: f32 = 4.0;

/// What one block of frames shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// It differs within itself or from the block before: something moves right now.
    pub now: bool,
    /// That, or it differs from the course of the last [`SHORT_BLOCKS`].
    pub quick: bool,
    /// It differs from the course of the last [`LONG_BLOCKS`].
    pub slow: bool,
}

impl Block {
    /// Whether it shows any change.
    pub const fn moves(&self) -> bool {
        self.quick || self.slow
    }
}

/// Noise of the taxels and the recent past.
#[derive(Clone, Debug)]
pub struct Motion {
    noise: Noise,
    past: Past,
    /// Sum of the latest blocks since the last restart, at most [`LONG_BLOCKS`].
    recent_sum: Values,
    /// Frames of the block under way.
    frames: [Values; BLOCK_FRAMES as usize],
    count: usize,
    /// The frame before that block, if there was one.
    before: Option<Values>,
    /// Squared changes from frame to frame in the latest block.
    squares: Values,
    /// The comparisons of the latest block: within it, with the one before, short and long.
    compared: [f32; 4],
    /// Those of still blocks.
    typical: [f32; 4],
}

impl Motion {
    /// At rest, before the first frame.
    pub const fn new() -> Self {
        Self {
            noise: Noise::new(),
            past: Past::new(),
            recent_sum: [0.0; TAXELS],
            frames: [[0.0; TAXELS]; BLOCK_FRAMES as usize],
            count: 0,
            before: None,
            squares: [0.0; TAXELS],
            compared: [0.0; 4],
            typical: [0.0; 4],
        }
    }

    /// Forgets the past but not the noise: the next block is compared with nothing.
    pub fn restart(&mut self) {
        self.past.count = 0;
        let [_, with_past @ ..] = &mut self.compared;
        *with_past = [0.0; 3];
    }

    /// Takes the next frame. Gives what the block shows that it ends.
    #[inline]
    pub fn push(&mut self, values: &Values) -> Option<Block> {
        self.frames[self.count % BLOCK_FRAMES as usize] = *values;
        self.count += 1;
        if self.count < BLOCK_FRAMES as usize {
            return None;
        }
        self.count = 0;
        Some(self.evaluate())
    }

    #[inline(never)]
    fn evaluate(&mut self) -> Block {
        let [first, second, third, fourth] = &self.frames;
        let before = self.before.as_ref().unwrap_or(first);
        let mut mean = [0.0; TAXELS];
        let mut within = 0.0;
        for c in 0..TAXELS {
            let changes = [first[c] - before[c], second[c] - first[c], third[c] - second[c], fourth[c] - third[c]];
            let [one, two, three, four] = changes.map(|change| change * change);
            self.squares[c] = one + two + three + four;
            within += self.squares[c] * self.noise.weights[c];
            mean[c] = (first[c] + second[c] + third[c] + fourth[c]) * (1.0 / BLOCK_FRAMES as f32);
        }
        self.before = Some(*fourth);
        // In units of the noise: a mean of four frames has a quarter of the variance of one, a first difference of such
        // means twice that, a second difference six times.
        let known = self.past.count;
        let frames = BLOCK_FRAMES as f32;
        self.compared = [
            within,
            if known > 0 { self.distance(&mean, self.past.back(0)) * (frames / 2.0) } else { 0.0 },
            if known >= 2 * SHORT { self.bend(&mean, SHORT) * (frames / 6.0) } else { 0.0 },
            if known >= 2 * LONG { self.bend(&mean, LONG) * (frames / 6.0) } else { 0.0 },
        ];
        self.add_recent(&mean);
        self.past.push(mean);
        let over = |which: usize, limit: f32| self.compared[which] > greater(limit, OVER_TYPICAL * self.typical[which]);
        let now = over(0, JUMPING) || over(1, MOVING);
        Block { now, quick: now || over(2, MOVING), slow: over(3, MOVING) }
    }

    /// How far this block and two before it, `distance_blocks` and twice that, are off a straight course.
    #[inline]
    fn bend(&self, mean: &Values, distance_blocks: usize) -> f32 {
        let (near, far) = (self.past.back(distance_blocks - 1), self.past.back(2 * distance_blocks - 1));
        let mut sum = 0.0;
        for c in 0..TAXELS {
            let off = mean[c] + far[c] - 2.0 * near[c];
            sum += off * off * self.noise.weights[c];
        }
        sum
    }

    /// Adds the next block to the sum of the latest ones, and takes the oldest out.
    #[inline]
    fn add_recent(&mut self, mean: &Values) {
        if self.past.count == 0 {
            self.recent_sum = [0.0; TAXELS];
        }
        for c in 0..TAXELS {
            self.recent_sum[c] += mean[c];
        }
        if self.past.count >= 2 * LONG {
            let oldest = self.past.back(2 * LONG - 1);
            for c in 0..TAXELS {
                self.recent_sum[c] -= oldest[c];
            }
        }
    }

    /// The latest block was a still one: learns the noise from it.
    pub fn learn(&mut self) {
        let share = self.noise.learn(&self.past, &self.squares);
        for (typical, compared) in self.typical.iter_mut().zip(self.compared) {
            *typical += share * (compared - *typical);
        }
    }

    /// Means of the latest blocks.
    pub const fn past(&self) -> &Past {
        &self.past
    }

    /// Mean of the last [`LONG_BLOCKS`], or of those since a restart.
    pub fn recent_mean(&self) -> Values {
        let share = 1.0 / self.past.count.clamp(1, 2 * LONG) as f32;
        self.recent_sum.map(|sum| sum * share)
    }

    /// Squared distance of two levels, in units of one frame's noise.
    pub fn distance(&self, a: &Values, b: &Values) -> f32 {
        distance(&self.noise.weights, a, b)
    }

    /// One over the variance of each taxel's frames.
    pub const fn weights(&self) -> &Values {
        &self.noise.weights
    }
}

/// Moves a level by a share of its way to another one.
pub fn approach(level: &mut Values, to: &Values, share: f32) {
    for (level, to) in level.iter_mut().zip(to) {
        *level += share * (to - *level);
    }
}
