//! Is anything moving? Short means of the frames compared with each other at several distances.
//!
//! Each comparison sums over the taxels in units of their noise, so under a still finger it is a
//! chi-square with sixteen degrees of freedom. First differences see quick changes; second
//! differences at longer distances see slow waves but not the straight creep of a skin that was
//! just loaded.
//!
//! A block is evaluated while the next one comes, a share of the taxels with each of its frames, so that
//! no frame's work is much more than another's.

mod noise;
mod past;
mod share;

use noise::Noise;
use past::{HISTORY, Past};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;
use share::greater;
pub use share::{SHARE, SHARES, distance, put, share, share_mut};

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
/// Most blocks that a mean of four can leave out.
pub const SKIP_MAX: usize = HISTORY - 5;
/// Least distance of two means of four blocks that tells a creep, blocks: less and they share some.
const CREEP_BLOCKS: usize = 4;
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
    /// It differs within itself or from the block before: something moves right now.
    pub now: bool,
    /// That, or it differs from the course of the last [`SHORT_BLOCKS`].
    pub quick: bool,
    /// It differs from the course of the last [`LONG_BLOCKS`].
    pub slow: bool,
    /// Squared distance from the idle level, in units of one frame's noise: of the block's mean or, if that was asked
    /// for, of the mean of the last [`LONG_BLOCKS`].
    pub off: f32,
    /// That of the other level, if one was given.
    pub other: f32,
}

/// Noise of the taxels and the recent past.
#[derive(Clone, Debug)]
pub struct Motion {
    noise: Noise,
    /// The comparisons of still blocks.
    typical: [f32; 4],
    /// The block under way and the one before it, in turns.
    frames: [[Values; BLOCK_FRAMES as usize]; 2],
    /// Which of the two is under way.
    under_way: usize,
    /// Its frames so far.
    count: usize,
    /// Whether the other one is being evaluated.
    whole: bool,
    /// Whether there has been a frame.
    begun: bool,
    /// Squared changes from frame to frame in the latest block that was evaluated.
    squares: Values,
    past: Past,
    /// Blocks of the past that the block in evaluation is compared with.
    known: usize,
    /// The comparisons of the block in evaluation, so far.
    compared: [f32; 4],
    off: f32,
    other: f32,
}

impl Motion {
    /// At rest, having seen nothing.
    pub const fn new() -> Self {
        Self {
            noise: Noise::new(),
            typical: [0.0; 4],
            frames: [[[0.0; TAXELS]; BLOCK_FRAMES as usize]; 2],
            under_way: 0,
            count: 0,
            whole: false,
            begun: false,
            squares: [0.0; TAXELS],
            past: Past::new(),
            known: 0,
            compared: [0.0; 4],
            off: 0.0,
            other: 0.0,
        }
    }

    /// Forgets the past but not the noise: what follows is compared with itself only.
    pub fn restart(&mut self) {
        self.past.count = 0;
        // What was compared with the past goes with it; what was within the block stays.
        let [_, past @ ..] = &mut self.compared;
        *past = [0.0; 3];
    }

    /// Frames of the block under way, 0 to 3: the next share of the block before it.
    pub const fn turn(&self) -> usize {
        self.count
    }

    /// Takes the next frame, once the share of this turn is evaluated; true if it ends a block.
    pub fn push(&mut self, values: &Values) -> bool {
        if !self.begun {
            self.begun = true;
            // Nothing before it that it could differ from. Of the block before it only this is ever looked at.
            let [.., before] = &mut self.frames[(self.under_way ^ 1) % 2];
            *before = *values;
        }
        self.frames[self.under_way % 2][self.count % SHARES] = *values;
        self.count += 1;
        if self.count < BLOCK_FRAMES as usize {
            return false;
        }
        self.count = 0;
        self.under_way ^= 1;
        self.whole = true;
        true
    }

    /// Evaluates one share of the block that has ended; says what it says with the last share.
    #[inline(always)]
    pub fn evaluate(&mut self, turn: usize, idle: &Values, other: Option<&Values>, of_late: bool) -> Option<Block> {
        if !self.whole {
            return None;
        }
        if turn == 0 {
            let lesson = self.noise.begin();
            for (typical, value) in self.typical.iter_mut().zip(self.compared) {
                *typical += lesson * (value - *typical);
            }
            self.known = self.past.count;
            self.compared = [0.0; 4];
            (self.off, self.other) = (0.0, 0.0);
        }
        self.noise.learn_share(turn, &self.past, &self.squares);
        self.evaluate_share(turn, idle, other, of_late);
        if turn + 1 < BLOCK_FRAMES as usize {
            return None;
        }
        self.whole = false;
        // A restart in the middle of it: it belongs to what is forgotten.
        let forgotten = self.past.count < self.known;
        self.past.latest = self.past.next();
        self.past.count = if forgotten { 0 } else { (self.known + 1).min(HISTORY - 1) };
        // In units of the noise: a mean has that of one frame, over the frames of a block; a first difference
        // twice and a second one six times that.
        let frames = BLOCK_FRAMES as f32;
        let [within, before, short, long] = self.compared;
        self.compared = match forgotten {
            true => [within, 0.0, 0.0, 0.0],
            false => [within, before * (frames / 2.0), short * (frames / 6.0), long * (frames / 6.0)],
        };
        let over = |which: usize, limit: f32| self.compared[which] > greater(limit, OVER_TYPICAL * self.typical[which]);
        let now = over(0, JUMPING) || over(1, MOVING);
        Some(Block { now, quick: now || over(2, MOVING), slow: over(3, MOVING), off: self.off, other: self.other })
    }

    #[inline(always)]
    fn evaluate_share(&mut self, turn: usize, idle: &Values, other: Option<&Values>, of_late: bool) {
        let [one, other_one] = &self.frames;
        let (block, [.., before]) = if self.under_way == 0 { (other_one, one) } else { (one, other_one) };
        let weights = *share(&self.noise.weights, turn);
        let [before, first, second, third, fourth] =
            [before, &block[0], &block[1], &block[2], &block[3]].map(|frame| *share(frame, turn));
        let (mut sum, mut squares) = ([0.0; SHARE], [0.0; SHARE]);
        // Frame after frame in one line: around a loop the compiler copies them.
        for c in 0..SHARE {
            let changes = [first[c] - before[c], second[c] - first[c], third[c] - second[c], fourth[c] - third[c]];
            sum[c] = first[c] + second[c] + third[c] + fourth[c];
            squares[c] =
                changes[0] * changes[0] + changes[1] * changes[1] + changes[2] * changes[2] + changes[3] * changes[3];
        }
        let mean = sum.map(|sum| sum * (1.0 / BLOCK_FRAMES as f32));
        let back = |back: usize| *share(self.past.back(back), turn);
        let mut within = 0.0;
        for c in 0..SHARE {
            within += squares[c] * weights[c];
        }
        // Sum of the latest blocks, which begins anew where the past does.
        let (mut sum, mut before, mut short, mut long) = (mean, 0.0, 0.0, 0.0);
        if self.known > 0 {
            before = distance(&weights, &mean, &back(0));
            let earlier = share(&self.past.sum, turn);
            for c in 0..SHARE {
                sum[c] += earlier[c];
            }
        }
        let second = |distance_blocks: usize| {
            let (near, far) = (back(distance_blocks - 1), back(2 * distance_blocks - 1));
            // From twice the near one to the sum of the others: what a channel is off a straight course.
            let (mut outer, mut inner) = ([0.0; SHARE], [0.0; SHARE]);
            for c in 0..SHARE {
                (outer[c], inner[c]) = (mean[c] + far[c], 2.0 * near[c]);
            }
            distance(&weights, &outer, &inner)
        };
        if self.known >= 2 * SHORT {
            short = second(SHORT);
        }
        if self.known >= 2 * LONG {
            long = second(LONG);
            let oldest = back(LONG_BLOCKS as usize - 1);
            for c in 0..SHARE {
                sum[c] -= oldest[c];
            }
        }
        for (compared, share) in self.compared.iter_mut().zip([within, before, short, long]) {
            *compared += share;
        }
        let idle = *share(idle, turn);
        let of_late = if of_late {
            let one = 1.0 / (self.known + 1).min(LONG_BLOCKS as usize) as f32;
            sum.map(|sum| sum * one)
        } else {
            mean
        };
        self.off += distance(&weights, &of_late, &idle);
        if let Some(other) = other {
            self.other += distance(&weights, share(other, turn), &idle);
        }
        put(&mut self.squares, turn, squares);
        put(&mut self.past.sum, turn, sum);
        put(self.past.next_mut(), turn, mean);
    }

    /// The latest block was a still one and teaches what the noise is.
    pub fn learn(&mut self) {
        // Share by share, each before the next block's is evaluated.
        self.noise.teaches = true;
    }

    /// Moves one share of a level by so much of the way to the mean of a block, the `skip` latest left out.
    pub fn approach(&self, level: &mut Values, turn: usize, by: f32, skip: usize) {
        let (mut moved, mean) = (*share(level, turn), share(self.past.back(skip), turn));
        for c in 0..SHARE {
            moved[c] += by * (mean[c] - moved[c]);
        }
        put(level, turn, moved);
    }

    /// Mean of the latest block.
    pub fn mean(&self) -> &Values {
        self.past.back(0)
    }

    /// Blocks since the last restart, as far as they are remembered.
    pub const fn known(&self) -> usize {
        self.past.count
    }

    /// Sets one share of a level to the mean of four blocks, the `skip` latest left out, and gives the squared
    /// distance of that share from another level. Blocks from before a restart count too.
    pub fn settle(&self, level: &mut Values, from: &Values, turn: usize, skip: usize) -> f32 {
        let mean = self.past.mean_of_four(turn, skip);
        put(level, turn, mean);
        distance(share(&self.noise.weights, turn), &mean, share(from, turn))
    }

    /// Sets one share of `creep` to what the blocks say it is: from the mean of four blocks, the `skip` latest left
    /// out, to `later`, that of the four latest, divided by the blocks between them. Gives the earlier mean to `level`.
    /// Too few blocks tell nothing: then the level stays.
    pub fn creep(&self, level: &mut Values, creep: &mut Values, later: &Values, turn: usize, skip: usize) {
        let (earlier, later) = (self.past.mean_of_four(turn, skip), share(later, turn));
        put(level, turn, earlier);
        let per_block = if skip < CREEP_BLOCKS { 0.0 } else { 1.0 / skip as f32 };
        let mut rise = [0.0; SHARE];
        for c in 0..SHARE {
            rise[c] = (later[c] - earlier[c]) * per_block;
        }
        put(creep, turn, rise);
    }

    /// One over the variance of each taxel's frames.
    pub const fn weights(&self) -> &Values {
        &self.noise.weights
    }
}

impl Default for Motion {
    fn default() -> Self {
        Self::new()
    }
}
