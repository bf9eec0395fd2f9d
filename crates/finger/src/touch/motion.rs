//! Motion detection: short means of the frames are compared with each other at several distances.
//!
//! Each comparison sums over the taxels in units of their noise, so under a still finger it is a
//! chi-square with a degree of freedom for each taxel. First differences see quick changes. Second
//! differences at longer distances see slow waves, but not the straight creep of a skin that was
//! just loaded.

pub use crate::touch::block::{BLOCK_FRAMES, Block};
use crate::touch::chi_square::{Apart, Limit, Taxels, along, distance, limit, root};
use crate::touch::noise::{KNOWN_BLOCKS, NOISE_BLOCKS, Noise};
use crate::touch::past::{EIGHTS, Past};
use crate::touch::values::{greater, length, lesser};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Distance of the short second difference, blocks: 33 ms.
const SHORT: usize = 2;
/// Distance of the long second difference, which is one of means of four blocks, blocks: 100 ms.
const LONG: usize = 6;
/// Blocks that the short comparison reaches back: 66 ms.
pub const SHORT_BLOCKS: u32 = 2 * SHORT as u32;
/// Blocks that the long comparison reaches back: 250 ms.
pub const LONG_BLOCKS: u32 = 2 * LONG as u32 + 3;
/// Blocks that the longest comparison reaches back: a second difference of means of eight blocks,
/// at a distance of two of them, once in eight blocks. 0.66 to 0.78 s. It finds a tone of 1 Hz that
/// is as weak as the noise.
pub const LONGEST_BLOCKS: u32 = 8 * EIGHTS as u32 + 7;
/// A motion whose long comparisons are never above this is weak: the long comparison may miss parts
/// of it. Eight times [`MOVING`].
const WEAK: Limit = limit(8.0, 360.0);
/// Blocks after which little of a block is left in the averages of the quick comparisons: 116 ms.
pub const FAINT_BLOCKS: u32 = 7;
/// Fraction of the latest block in these averages.
const FAINT_FRACTION: f32 = 0.2;
/// Weight of the comparison with the block before relative to that within a block, for the same
/// standard deviation. Together they find a tone of 35 to 50 Hz that is as weak as the noise; alone
/// neither does.
const BESIDE: f32 = 5.0;
/// An average above this is motion. The averages are of the comparison within blocks, of that
/// together with the comparison with the block before, and of the short one. An average has a ninth
/// of a block's variance, more where adjacent blocks share frames. The limit is the mean plus four
/// and a half standard deviations: a slide needs many such blocks. Averages find what is too weak
/// for one block, above all a tone near 60 Hz, which a mean of four frames hides.
const FAINT: [Limit; 3] = [limit(8.0, 42.0), limit(13.0, 62.0), limit(1.0, 14.0)];
/// A comparison above this is motion: 61 for 16 taxels, a chi-square's mean of 16 and eight of its
/// standard deviations of 5.7. A day has 5 million blocks.
const MOVING: Limit = limit(1.0, 45.0);
/// A block whose differences from frame to frame add up to more has jumped: mean 128, eight times 35.
const JUMPING: Limit = limit(8.0, 282.0);
/// Noise that is not white makes comparisons larger while nothing moves. Motion is this multiple of
/// the typical comparison; for an average of blocks, which varies less than one block, the second
/// multiple.
const OVER_TYPICAL: f32 = 4.0;
const FAINT_OVER_TYPICAL: f32 = 1.3;
/// Excess of the squares of averaged frames that is motion, in standard deviations; and that of an
/// average of these squares, whose standard deviation is a third.
const SWINGING: f32 = 8.0;
const SWINGING_FAINT: f32 = 1.5;
/// Fraction of the greatest long comparison below which a later one is the creep of the skin after
/// the motion, which bends by 3 % of it.
const CREEP_FRACTION: f32 = 1e-3;
/// Maximum square across the direction of the load relative to that along it while a finger only
/// presses more or less: the taxels' levels grow with powers of the load between 0.7 and 1.3.
const LOAD_SPREAD: f32 = 0.05;
/// Multiple of the limits of single blocks above which one block is reported as the first sign of a
/// motion: a motion that becomes a slide needs several blocks.
const ACROSS: f32 = 1.25;
/// Minimum number of loaded taxels if changes along the load are no motion: with only one or two, a
/// slide hardly shows otherwise.
const LOADED_MIN: f32 = 2.5;
/// The noise is learnt from every eighth block once it is known.
const LEARN_EVERY: u32 = 8;

/// A comparison of the latest block, and its average over the latest blocks.
#[derive(Clone, Debug)]
struct Comparison {
    value: f32,
    average: f32,
    /// Limits of the value and of the average in white noise, and as multiples of the typical
    /// value.
    white: [f32; 2],
    over_typical: [f32; 2],
    /// Value in still blocks, and the number of blocks it was learned from, at most [`NOISE_BLOCKS`].
    typical: f32,
    learned: f32,
}

impl Comparison {
    const fn new(taxels: Taxels, limit: Limit, faint: Limit) -> Self {
        Self {
            value: 0.0,
            average: 0.0,
            white: [taxels.limit(limit), taxels.limit(faint)],
            over_typical: [OVER_TYPICAL, FAINT_OVER_TYPICAL],
            typical: 0.0,
            learned: 0.0,
        }
    }

    fn limit(&self) -> f32 {
        greater(self.white[0], self.over_typical[0] * self.typical)
    }

    fn is_over(&self) -> bool {
        self.value > self.limit()
    }

    /// Value for an average, limited to that of a motion in a single block.
    fn capped(&self) -> f32 {
        lesser(self.value, self.limit())
    }

    /// Takes a block's value into the average. True if the average is motion.
    fn is_faint(&mut self, value: f32, typical: f32) -> bool {
        self.average += FAINT_FRACTION * (value - self.average);
        self.average > greater(self.white[1], self.over_typical[1] * typical)
    }

    fn restart(&mut self) {
        (self.value, self.average) = (0.0, 0.0);
    }

    /// Learns from a still block, unless there was nothing to compare.
    fn learn(&mut self) {
        if self.value > 0.0 {
            if self.learned < NOISE_BLOCKS {
                self.learned += 1.0;
            }
            self.typical += (self.value - self.typical) / self.learned;
        }
    }
}

/// Noise of the taxels and the recent past.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Number of taxels.
    pub taxels: Taxels,
    noise: Noise,
    /// Means of the latest blocks.
    pub past: Past,
    /// Direction that is ignored, codes; zero without one.
    load: Values,
    /// `load` times the weights: the product with a difference is its length along the load.
    pub pull: Values,
    /// The greatest long comparison since the last restart.
    max_bend: f32,
    /// Still blocks until the noise is learned again.
    until_learning: u32,
    /// Number of blocks from which nothing can be learned: some of their frames contain a drift.
    unfit: u32,
    /// The frame before the block under way, or a copy of the very first one; and the block's
    /// frames, `count` so far.
    frames: [Values; 1 + BLOCK_FRAMES as usize],
    count: usize,
    has_begun: bool,
    /// Squared changes from frame to frame in the latest block.
    squares: Values,
    /// Squares of the block's averaged frames about their means, which hide faster changes.
    /// Weighted as differences of the means are, so only the ratio to the typical value counts. In
    /// noise alone a chi-square with a degree of freedom for each frame but one of a mean, of each
    /// taxel.
    swung: f32,
    /// True if blocks are to be tested for motion across the direction of the load.
    pub seeks_across: bool,
    /// Changes from frame to frame, and from the block before, whose average is of both.
    within: Comparison,
    beside: Comparison,
    /// Second differences of blocks, of means of four and of means of eight.
    short: Comparison,
    long: Comparison,
    longest: Comparison,
    swing: Comparison,
    /// Blocks in a row without a quick change, since the last restart.
    pub still_quick: u32,
    /// Blocks in a row without any change but that of the longest comparison.
    pub still: u32,
    /// Blocks in a row without a change in the longest comparison.
    pub still_longest: u32,
}

impl Motion {
    /// The idle state, before the first frame.
    pub const fn new(plan: &Plan) -> Self {
        let taxels = Taxels::new(plan.channels());
        let freedom = (BLOCK_FRAMES * (plan.frames_averaged() - 1)) as f32 * plan.channels() as f32;
        // Standard deviation over mean.
        let is_averaged = freedom > 0.0;
        let spread = if is_averaged {
            root(2.0 / freedom)
        } else {
            0.0
        };
        let swing = greater(OVER_TYPICAL, 1.0 + SWINGING * spread);
        let swing_faint = greater(FAINT_OVER_TYPICAL, 1.0 + SWINGING_FAINT * spread);
        Self {
            taxels,
            noise: Noise::new(),
            past: Past::new(),
            load: [0.0; TAXELS],
            pull: [0.0; TAXELS],
            max_bend: 0.0,
            until_learning: 0,
            unfit: 0,
            frames: [[0.0; TAXELS]; 1 + BLOCK_FRAMES as usize],
            count: 0,
            has_begun: false,
            squares: [0.0; TAXELS],
            swung: 0.0,
            seeks_across: false,
            within: Comparison::new(taxels, JUMPING, FAINT[0]),
            beside: Comparison::new(taxels, MOVING, FAINT[1]),
            short: Comparison::new(taxels, MOVING, FAINT[2]),
            long: Comparison::new(taxels, MOVING, MOVING),
            longest: Comparison::new(taxels, MOVING, MOVING),
            // Nothing swings until the typical value is known.
            swing: Comparison {
                white: [f32::INFINITY; 2],
                over_typical: [swing, swing_faint],
                ..Comparison::new(taxels, MOVING, MOVING)
            },
            still_quick: 0,
            still: 0,
            still_longest: 0,
        }
    }

    /// Forgets the past but not the noise: the next block is compared with nothing.
    pub fn restart(&mut self) {
        (self.past.count_of_eights, self.still_longest) = (0, 0);
        self.longest.value = 0.0;
        self.restart_lately();
    }

    /// Begins again all comparisons but the longest one.
    pub fn restart_lately(&mut self) {
        (self.past.count, self.still_quick, self.still) = (0, 0, 0);
        self.within.average = 0.0;
        self.beside.restart();
        self.short.restart();
        self.long.restart();
        self.swing.restart();
        self.max_bend = 0.0;
    }

    /// Takes the next frame; for an average, with the squares of the frames about it. Returns the
    /// result of the block that ends with the frame.
    #[inline]
    pub fn push(&mut self, values: &Values, squares: Option<&Values>) -> Option<Block> {
        if let Some(squares) = squares {
            self.swung += along(&self.noise.weights, &[0.0; TAXELS], squares);
        }
        if !core::mem::replace(&mut self.has_begun, true) {
            self.frames[0] = *values;
        }
        self.frames[1 + self.count % BLOCK_FRAMES as usize] = *values;
        self.count += 1;
        if self.count < BLOCK_FRAMES as usize {
            return None;
        }
        self.count = 0;
        Some(self.evaluate())
    }

    fn evaluate(&mut self) -> Block {
        let [before, first, second, third, fourth] = &self.frames;
        let [latest, near, far] = [0, SHORT - 1, 2 * SHORT - 1].map(|back| self.past.back(back));
        // One loop: this is the costliest step of a frame.
        let mut within = 0.0;
        let (mut change, mut bend) = (Apart::NONE, Apart::NONE);
        let mean: Values = core::array::from_fn(|c| {
            let changes = [
                first[c] - before[c],
                second[c] - first[c],
                third[c] - second[c],
                fourth[c] - third[c],
            ];
            let [one, two, three, four] = changes.map(|change| change * change);
            let (weight, pull) = (self.noise.weights[c], self.pull[c]);
            self.squares[c] = one + two + three + four;
            within += self.squares[c] * weight;
            let mean = (first[c] + second[c] + third[c] + fourth[c]) * (1.0 / BLOCK_FRAMES as f32);
            change.add(mean - latest[c], weight, pull);
            bend.add(mean + far[c] - 2.0 * near[c], weight, pull);
            mean
        });
        let known = self.past.count;
        self.past.push(mean);
        // In units of the noise: a mean of four frames has a quarter of the variance of one, a
        // first difference of such means twice that, a second difference six times.
        let frames = BLOCK_FRAMES as f32;
        let of_change = if known >= 1 { frames / 2.0 } else { 0.0 };
        let is_bend = known >= 2 * SHORT;
        let of_bend = if is_bend { frames / 6.0 } else { 0.0 };
        self.within.value = within;
        self.beside.value = change.square() * of_change;
        self.short.value = bend.square() * of_bend;
        self.swing.value = core::mem::take(&mut self.swung);
        // Means of four blocks change slowly: every other one is compared.
        if known < LONG_BLOCKS as usize {
            self.long.value = 0.0;
        } else if self.past.pair_is_new {
            self.long.value = self.long_bend() * (4.0 * frames / 6.0);
        }
        if self.past.count_of_eights < EIGHTS {
            self.longest.value = 0.0;
        } else if self.past.eight_is_new {
            self.longest.value = self.longest_bend() * (8.0 * frames / 6.0);
        }
        self.max_bend = greater(self.max_bend, self.long.value);
        let creep = CREEP_FRACTION * self.max_bend;
        // Wandering noise is twice as large in means of eight blocks as in means of four.
        let wander = OVER_TYPICAL * (2.0 * self.long.typical - self.taxels.count);
        let [within, beside, short, swing] = [
            &mut self.within,
            &mut self.beside,
            &mut self.short,
            &mut self.swing,
        ];
        let both = within.capped() + BESIDE * beside.capped();
        let typical = within.typical + BESIDE * beside.typical;
        let faint = within.is_faint(within.capped(), within.typical)
            | beside.is_faint(both, typical)
            | short.is_faint(short.capped(), short.typical)
            | swing.is_faint(swing.capped(), swing.typical);
        let now = within.is_over() || beside.is_over() || swing.is_over();
        let quick = now || short.is_over();
        let limits = [&*within, beside, short].map(|one| ACROSS * one.limit());
        let across = quick && self.seeks_across && {
            let changes = [
                self.steps_across(),
                across(change, 0.0) * of_change,
                across(bend, 4.0 * change.along_square()) * of_bend,
            ];
            changes
                .iter()
                .zip(limits)
                .any(|(change, limit)| *change > limit)
        };
        let block = Block {
            now,
            quick,
            slow: self.long.value > greater(self.long.limit(), creep),
            faint,
            longest: self.longest.value > greater(greater(self.longest.limit(), wander), creep),
            across,
        };
        self.frames[0] = *self.latest();
        for (still, moves) in [
            (&mut self.still_quick, block.quick),
            (&mut self.still_longest, block.longest),
            (&mut self.still, block.moves_lately()),
        ] {
            *still = if moves { 0 } else { still.saturating_add(1) };
        }
        block
    }

    /// Length of a difference.
    #[inline(always)]
    fn apart(&self, off: impl Fn(usize) -> f32) -> Apart {
        let mut apart = Apart::NONE;
        for c in 0..TAXELS {
            apart.add(off(c), self.noise.weights[c], self.pull[c]);
        }
        apart
    }

    /// Squared changes from frame to frame in the block under way, without what the load explains.
    fn steps_across(&self) -> f32 {
        let step = |k: usize| self.apart(|c| self.frames[k + 1][c] - self.frames[k][c]);
        (0..BLOCK_FRAMES as usize).fold(0.0, |sum, k| sum + across(step(k), 0.0))
    }

    /// Squared deviation from a straight line of the mean of the latest four blocks, and two before
    /// it at a distance of [`LONG`].
    fn long_bend(&self) -> f32 {
        const FAR: usize = LONG / 2;
        let [a, b, c, d, e, f] =
            [0, 1, FAR, FAR + 1, 2 * FAR, 2 * FAR + 1].map(|back| self.past.pair(back));
        let off = |k: usize| a[k] + b[k] + e[k] + f[k] - 2.0 * (c[k] + d[k]);
        self.apart(off).square() * (1.0 / 16.0)
    }

    /// Squared deviation of means of eight blocks from a straight line: the latest one, and two
    /// before it at a distance of two.
    fn longest_bend(&self) -> f32 {
        let [near, middle, far] = [0, 2, 4].map(|back| self.past.eight(back));
        let bend = self.apart(|c| near[c] + far[c] - 2.0 * middle[c]);
        bend.square() * (1.0 / 64.0)
    }

    /// True if the motion since the last restart is so weak that the long comparison may miss parts
    /// of it.
    pub fn is_weak(&self) -> bool {
        self.max_bend < self.taxels.limit(WEAK)
    }

    /// Learns the noise from the latest block, which was still.
    pub fn learn(&mut self) {
        if self.unfit > 0 {
            self.unfit -= 1;
            return;
        }
        // A level that is well known needs only one block of eight.
        let until = self.until_learning.checked_sub(1);
        self.until_learning = until.unwrap_or(LEARN_EVERY - 1);
        if self.until_learning > 0 && self.within.learned >= NOISE_BLOCKS {
            return;
        }
        self.noise.learn(&self.past, &self.squares);
        self.aim();
        if self.noise.learned >= KNOWN_BLOCKS {
            self.each(Comparison::learn);
            if self.swing.learned >= KNOWN_BLOCKS {
                self.swing.white = [0.0; 2];
            }
        }
    }

    fn each(&mut self, change: fn(&mut Comparison)) {
        let Self {
            within,
            beside,
            short,
            long,
            longest,
            swing,
            ..
        } = self;
        [within, beside, short, long, longest, swing]
            .into_iter()
            .for_each(change);
    }

    /// Learns the typical values anew, and soon the noise: a drift by `slope` in each block was
    /// taken for noise until now, or a drift has ended.
    pub fn forget(&mut self, slope: Option<&Values>) {
        self.restart();
        self.each(|one| one.learned = 0.0);
        (self.swing.white, self.unfit) = ([f32::INFINITY; 2], 2);
        self.noise.forget(slope);
    }

    /// Ignores changes along this direction from now on, if it is not zero: the finger presses more
    /// or less, or its skin creeps.
    pub fn ignore(&mut self, load: Values) {
        self.load = load;
        self.aim();
    }

    /// Scales the ignored direction to length one, in units of the noise.
    fn aim(&mut self) {
        let (weights, load) = (&self.noise.weights, &self.load);
        let (mut square, mut fourth) = (0.0, 0.0);
        for c in 0..TAXELS {
            let one = load[c] * load[c] * weights[c];
            (square, fourth) = (square + one, fourth + one * one);
        }
        let is_wide = square * square > LOADED_MIN * fourth;
        let length = ridgetone_tone::sqrt(square);
        let fraction = if is_wide { 1.0 / length } else { 0.0 };
        self.pull = core::array::from_fn(|c| load[c] * weights[c] * fraction);
    }

    /// The latest frame of the latest block.
    pub const fn latest(&self) -> &Values {
        &self.frames[BLOCK_FRAMES as usize]
    }

    /// Squared distance of two levels, in units of one frame's noise.
    pub fn distance(&self, a: &Values, b: &Values) -> f32 {
        distance(&self.noise.weights, a, b)
    }

    /// Distance from one level to another along the ignored direction, in units of one frame's
    /// noise.
    pub fn along(&self, from: &Values, to: &Values) -> f32 {
        along(&self.pull, from, to)
    }

    /// Converts a distance in codes along the ignored direction to units of one frame's noise.
    pub fn in_noise(&self, codes: f32) -> f32 {
        let square = distance(&self.noise.weights, &self.load, &[0.0; TAXELS]);
        codes * ridgetone_tone::sqrt(square) / greater(length(&self.load), 1.0)
    }

    /// Ratio of slow comparisons to those in white noise, at least one.
    pub fn wander(&self) -> f32 {
        greater(
            1.0,
            greater(self.beside.typical, self.long.typical) / self.taxels.count,
        )
    }

    /// One over the variance of each taxel's frames.
    pub const fn weights(&self) -> &Values {
        &self.noise.weights
    }
}

/// Square of a difference beyond what a change of the load explains. `pressed` is another such change,
/// whose own second difference may be small.
fn across(apart: Apart, pressed: f32) -> f32 {
    apart.square() - LOAD_SPREAD * (apart.along_square() + pressed)
}
