//! Is anything moving? Short means of the frames compared with each other at several distances.
//!
//! Each comparison sums over the taxels in units of their noise, so under a still finger it is a
//! chi-square with a degree of freedom for each taxel. First differences see quick changes. Second
//! differences at longer distances see slow waves, but not the straight creep of a skin that was
//! just loaded.

pub use crate::touch::block::{BLOCK_FRAMES, Block};
use crate::touch::chi_square::{Apart, Limit, Taxels, along, distance, limit};
use crate::touch::noise::{KNOWN_BLOCKS, NOISE_BLOCKS, Noise};
use crate::touch::past::{EIGHTS, Past};
use crate::touch::swing::{FAINT_OVER_TYPICAL, OVER_TYPICAL, Swing};
use crate::touch::values::{greater, length};
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
/// A motion of which no long comparison was above this is a weak one: the long one may miss parts
/// of it. Eight times [`MOVING`].
const WEAK: Limit = limit(8.0, 360.0);
/// Blocks after which little is left of one in the averages of the quick comparisons: 116 ms.
pub const FAINT_BLOCKS: u32 = 7;
/// Share of the latest block in these averages.
const FAINT_SHARE: f32 = 0.2;
/// Weight of the comparison with the block before, beside that within a block: they have the same
/// standard deviation then. Together they find a tone of 35 to 50 Hz that is as weak as the noise;
/// alone neither does.
const BESIDE: f32 = 5.0;
/// An average above this is motion. The averages are of the comparison within blocks, of that
/// together with the comparison with the block before, and of the short one. An average has a ninth
/// of a block's variance, more where neighbours share frames. The limit is the mean and four and a
/// half standard deviations: a slide needs many such blocks. Averages find what is too weak for one
/// block, above all a tone near 60 Hz: a mean of four frames has none of it.
const FAINT: [Limit; 3] = [limit(8.0, 42.0), limit(13.0, 62.0), limit(1.0, 14.0)];
/// A comparison above this is motion: 61 for 16 taxels, a chi-square's mean of 16 and eight of its
/// standard deviations of 5.7. A day has 5 million blocks.
const MOVING: Limit = limit(1.0, 45.0);
/// A block whose differences from frame to frame add up to more has jumped: mean 128, eight times 35.
const JUMPING: Limit = limit(8.0, 282.0);
/// Share of the greatest long comparison below which a later one is the creep of the skin after the
/// motion, which bends by 3 % of it.
const CREEP_SHARE: f32 = 1e-3;
/// Square across the direction of the load over that along it, at most, where a finger only presses
/// more or less: the taxels' levels grow with powers of the load between 0.7 and 1.3.
const LOAD_SPREAD: f32 = 0.05;
/// Multiple of the limits of single blocks above which one block is reported as the first sign of a
/// motion: a motion that becomes a slide needs several blocks.
const ACROSS: f32 = 1.25;
/// Taxels that bear a load, at least, if nothing along it is motion: one or two alone show a slide
/// hardly otherwise.
const LOADED_MIN: f32 = 2.5;
/// The noise is learnt from every eighth block once it is known.
const LEARN_EVERY: u32 = 8;

/// Comparisons: within a block, with the one before, short, long, of what averaged frames hide, and
/// the longest.
const COMPARISONS: usize = 6;
const LONG_BEND: usize = 3;
const LONGEST: usize = 5;
/// Averages of them.
const AVERAGES: usize = 4;

/// Noise of the taxels and the recent past.
#[derive(Clone, Debug)]
pub struct Motion {
    /// How many taxels there are.
    pub taxels: Taxels,
    /// Squares of averaged frames about their means.
    swing: Swing,
    noise: Noise,
    past: Past,
    /// Direction that is ignored, codes, and whether there is one.
    load: Values,
    has_load: bool,
    /// `load` times the weights: a product with it is the length along the load.
    pull: Values,
    /// The greatest long comparison since the last restart.
    greatest_bend: f32,
    /// Still blocks until the noise is learned again.
    until_learning: u32,
    /// Blocks that nothing can be learned from: a part of their frames is with a drift.
    unfit: u32,
    /// Frames of the block under way.
    frames: [Values; BLOCK_FRAMES as usize],
    count: usize,
    /// The frame before that block, if there was one.
    before: Option<Values>,
    /// Squared changes from frame to frame in the latest block.
    squares: Values,
    /// Whether blocks are to say if they show a motion across the direction of the load.
    pub seeks_across: bool,
    /// The comparisons of the latest block.
    compared: [f32; COMPARISONS],
    /// Those of still blocks.
    typical: [f32; COMPARISONS],
    /// Still blocks that these were learned from, at most [`NOISE_BLOCKS`].
    learned: [f32; COMPARISONS],
    /// Averages over the latest blocks: of the first, of the first two together, of the third, and
    /// of the fifth.
    faint: [f32; AVERAGES],
    /// Blocks in a row without a quick change, since the last restart.
    pub still_quick: u32,
    /// Blocks in a row without any but that of the longest comparison.
    pub still: u32,
    /// Blocks in a row without that.
    pub still_longest: u32,
}

impl Motion {
    /// At rest, before the first frame.
    pub const fn new(plan: &Plan) -> Self {
        Self {
            taxels: Taxels::new(plan.channels()),
            swing: Swing::new(plan),
            noise: Noise::new(),
            past: Past::new(),
            load: [0.0; TAXELS],
            has_load: false,
            pull: [0.0; TAXELS],
            greatest_bend: 0.0,
            until_learning: 0,
            unfit: 0,
            frames: [[0.0; TAXELS]; BLOCK_FRAMES as usize],
            count: 0,
            before: None,
            squares: [0.0; TAXELS],
            seeks_across: false,
            compared: [0.0; COMPARISONS],
            typical: [0.0; COMPARISONS],
            learned: [0.0; COMPARISONS],
            faint: [0.0; AVERAGES],
            still_quick: 0,
            still: 0,
            still_longest: 0,
        }
    }

    /// Forgets the past but not the noise: the next block is compared with nothing.
    pub fn restart(&mut self) {
        (
            self.past.count_of_eights,
            self.still_longest,
            self.compared[LONGEST],
        ) = (0, 0, 0.0);
        self.restart_lately();
    }

    /// Begins again all comparisons but the longest one.
    pub fn restart_lately(&mut self) {
        (self.past.count, self.still_quick, self.still) = (0, 0, 0);
        self.compared[1..LONGEST].fill(0.0);
        self.faint = [0.0; AVERAGES];
        self.greatest_bend = 0.0;
    }

    /// Takes the next frame, and where it is a mean the squares of frames about it. Gives what the
    /// block shows that it ends.
    #[inline]
    pub fn push(&mut self, values: &Values, squares: Option<&Values>) -> Option<Block> {
        if let Some(squares) = squares {
            self.swing.add(squares, &self.noise.weights);
        }
        self.frames[self.count % BLOCK_FRAMES as usize] = *values;
        self.count += 1;
        if self.count < BLOCK_FRAMES as usize {
            return None;
        }
        self.count = 0;
        Some(self.evaluate())
    }

    fn evaluate(&mut self) -> Block {
        let [first, second, third, fourth] = &self.frames;
        let before = self.before.as_ref().unwrap_or(first);
        let [latest, near, far] = [0, SHORT - 1, 2 * SHORT - 1].map(|back| self.past.back(back));
        // One loop: it is the dearest step of a frame.
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
        // In units of the noise: a mean of four frames has a quarter of the variance of one, a
        // first difference of such means twice that, a second difference six times.
        let known = self.past.count;
        let frames = BLOCK_FRAMES as f32;
        let if_known = |blocks: usize, apart: f32| if known >= blocks { apart } else { 0.0 };
        self.past.push(mean);
        // Means of four blocks change slowly: every other one is compared.
        let long = if known < LONG_BLOCKS as usize {
            0.0
        } else if self.past.pair_is_new {
            self.long_bend() * (4.0 * frames / 6.0)
        } else {
            self.compared[LONG_BEND]
        };
        let longest = match self.past.count_of_eights {
            EIGHTS if self.past.eight_is_new => self.longest_bend() * (8.0 * frames / 6.0),
            EIGHTS => self.compared[LONGEST],
            _ => 0.0,
        };
        self.compared = [
            within,
            if_known(1, change.square()) * (frames / 2.0),
            if_known(2 * SHORT, bend.square()) * (frames / 6.0),
            long,
            core::mem::take(&mut self.swing.sum),
            longest,
        ];
        let taxels = self.taxels;
        let (jumping, moving) = (taxels.limit(JUMPING), taxels.limit(MOVING));
        // Until it is known what is typical nothing swings.
        let typical_swing = if self.learned[4] >= KNOWN_BLOCKS {
            self.typical[4]
        } else {
            f32::INFINITY
        };
        let limits = [
            jumping,
            moving,
            moving,
            moving,
            self.swing.limit * typical_swing,
            moving,
        ];
        self.greatest_bend = greater(self.greatest_bend, long);
        let limit = |which: usize| {
            let limit = greater(limits[which], OVER_TYPICAL * self.typical[which]);
            // Noise that wanders makes twice as much of means of eight blocks as of four.
            let of_wander = OVER_TYPICAL * (2.0 * self.typical[LONG_BEND] - taxels.count);
            let limit = if which == LONGEST {
                greater(limit, of_wander)
            } else {
                limit
            };
            if which == LONG_BEND || which == LONGEST {
                greater(limit, CREEP_SHARE * self.greatest_bend)
            } else {
                limit
            }
        };
        let over = |which: usize| self.compared[which] > limit(which);
        // One block counts no more than a motion that it shows alone.
        let most = |which: usize| {
            if over(which) {
                limit(which)
            } else {
                self.compared[which]
            }
        };
        let latest = [most(0), most(0) + BESIDE * most(1), most(2), most(4)];
        let [within, beside, short, _, swing, _] = self.typical;
        let typical = [within, within + BESIDE * beside, short, swing];
        let [one, both, third] = FAINT.map(|limit| taxels.limit(limit));
        let limits = [one, both, third, self.swing.faint_limit * typical_swing];
        let mut faint = false;
        for which in 0..AVERAGES {
            self.faint[which] += FAINT_SHARE * (latest[which] - self.faint[which]);
            faint |=
                self.faint[which] > greater(limits[which], FAINT_OVER_TYPICAL * typical[which]);
        }
        let now = over(0) || over(1) || over(4);
        let quick = now || over(2);
        // Seldom needed, so not part of the loop.
        let across = quick && self.seeks_across && {
            let changes = [
                self.steps_across(),
                if_known(1, across(change, 0.0)) * (frames / 2.0),
                if_known(2 * SHORT, across(bend, 4.0 * change.along_square())) * (frames / 6.0),
            ];
            (0..changes.len()).any(|which| changes[which] > ACROSS * limit(which))
        };
        let block = Block {
            now,
            quick,
            slow: over(3),
            faint,
            longest: over(LONGEST),
            across,
        };
        self.before = Some(self.frames[BLOCK_FRAMES as usize - 1]);
        self.still_quick = if block.quick {
            0
        } else {
            self.still_quick.saturating_add(1)
        };
        self.still_longest = if block.longest {
            0
        } else {
            self.still_longest.saturating_add(1)
        };
        self.still = if block.moves_lately() {
            0
        } else {
            self.still.saturating_add(1)
        };
        block
    }

    /// Squared changes from frame to frame in the block under way, without what the load explains.
    fn steps_across(&self) -> f32 {
        let mut before = self.before.as_ref().unwrap_or(&self.frames[0]);
        let mut sum = 0.0;
        for frame in &self.frames {
            let mut step = Apart::NONE;
            for c in 0..TAXELS {
                step.add(frame[c] - before[c], self.noise.weights[c], self.pull[c]);
            }
            sum += across(step, 0.0);
            before = frame;
        }
        sum
    }

    /// How far the mean of the latest four blocks, and two before it at a distance of [`LONG`], are
    /// off a straight course.
    #[inline]
    fn long_bend(&self) -> f32 {
        const FAR: usize = LONG / 2;
        let [a, b, c, d, e, f] =
            [0, 1, FAR, FAR + 1, 2 * FAR, 2 * FAR + 1].map(|back| self.past.pair(back));
        let mut bend = Apart::NONE;
        for taxel in 0..TAXELS {
            let off = a[taxel] + b[taxel] + e[taxel] + f[taxel] - 2.0 * (c[taxel] + d[taxel]);
            bend.add(off, self.noise.weights[taxel], self.pull[taxel]);
        }
        bend.square() * (1.0 / 16.0)
    }

    /// How far means of eight blocks are off a straight course: the latest one, and two before it
    /// at a distance of two.
    fn longest_bend(&self) -> f32 {
        let [near, middle, far] = [0, 2, 4].map(|back| self.past.eight(back));
        let mut bend = Apart::NONE;
        for taxel in 0..TAXELS {
            let off = near[taxel] + far[taxel] - 2.0 * middle[taxel];
            bend.add(off, self.noise.weights[taxel], self.pull[taxel]);
        }
        bend.square() * (1.0 / 64.0)
    }

    /// Whether the motion since the last restart is so weak that the long comparison may miss parts
    /// of it.
    pub fn is_weak(&self) -> bool {
        self.greatest_bend < self.taxels.limit(WEAK)
    }

    /// The latest block was a still one: learns the noise from it.
    pub fn learn(&mut self) {
        if self.unfit > 0 {
            self.unfit -= 1;
            return;
        }
        // What is known well needs only one block of eight.
        self.until_learning = if self.until_learning > 0 {
            self.until_learning - 1
        } else {
            LEARN_EVERY - 1
        };
        if self.until_learning > 0 && self.learned[0] >= NOISE_BLOCKS {
            return;
        }
        self.noise.learn(&self.past, &self.squares);
        if self.has_load {
            self.aim();
        }
        if self.noise.learned < KNOWN_BLOCKS {
            return;
        }
        // A comparison with nothing says nothing.
        for ((compared, learned), typical) in self
            .compared
            .iter()
            .zip(&mut self.learned)
            .zip(&mut self.typical)
        {
            if *compared > 0.0 {
                average(*compared, learned, typical);
            }
        }
    }

    /// What is typical is to be learned anew, and the noise soon: a drift by `slope` in each block
    /// was taken for noise until now, or there is none any more.
    pub fn forget(&mut self, slope: Option<&Values>) {
        self.restart();
        (self.learned, self.unfit) = ([0.0; COMPARISONS], 2);
        self.noise.forget(slope);
    }

    /// Changes along this direction, if there is one, are no motion from now on: the finger presses
    /// more or less, or its skin creeps.
    pub fn ignore(&mut self, load: Option<Values>) {
        (self.load, self.has_load) = (load.unwrap_or([0.0; TAXELS]), load.is_some());
        self.aim();
    }

    /// Brings the direction that is ignored to length one, in units of the noise.
    fn aim(&mut self) {
        let (weights, load) = (&self.noise.weights, &self.load);
        let (mut square, mut fourth) = (0.0, 0.0);
        for c in 0..TAXELS {
            let one = load[c] * load[c] * weights[c];
            (square, fourth) = (square + one, fourth + one * one);
        }
        let is_wide = square * square > LOADED_MIN * fourth;
        let share = if is_wide {
            1.0 / libm::sqrtf(square)
        } else {
            0.0
        };
        for c in 0..TAXELS {
            self.pull[c] = load[c] * weights[c] * share;
        }
    }

    /// The latest frame of the latest block.
    pub const fn latest(&self) -> &Values {
        &self.frames[BLOCK_FRAMES as usize - 1]
    }

    /// Means of the latest blocks.
    pub const fn past(&self) -> &Past {
        &self.past
    }

    /// Squared distance of two levels, in units of one frame's noise.
    pub fn distance(&self, a: &Values, b: &Values) -> f32 {
        distance(&self.noise.weights, a, b)
    }

    /// How far it is from one level to another along the direction that is ignored, in units of one
    /// frame's noise.
    pub fn along(&self, from: &Values, to: &Values) -> f32 {
        along(&self.pull, from, to)
    }

    /// A distance of `codes` codes along that direction, in the same units.
    pub fn in_noise(&self, codes: f32) -> f32 {
        let square = distance(&self.noise.weights, &self.load, &[0.0; TAXELS]);
        codes * libm::sqrtf(square) / greater(length(&self.load), 1.0)
    }

    /// How much more slow comparisons are than in white noise, at least one.
    pub fn wander(&self) -> f32 {
        greater(
            1.0,
            greater(self.typical[1], self.typical[3]) / self.taxels.count,
        )
    }

    /// What a product with a difference gives its length along the direction that is ignored.
    pub const fn pull(&self) -> &Values {
        &self.pull
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

/// Takes one more into an average of at most [`NOISE_BLOCKS`].
fn average(value: f32, averaged: &mut f32, mean: &mut f32) {
    *averaged += if *averaged < NOISE_BLOCKS { 1.0 } else { 0.0 };
    *mean += (value - *mean) / *averaged;
}
