//! Dating of events: the frame at which the taxels left a level, or arrived at one.
//!
//! A motion is detected a few blocks late. The ring still holds its frames.

use crate::ring::reached;
use crate::touch::averages::Averages;
use crate::touch::block::BLOCK_FRAMES;
use crate::touch::chi_square::{Apart, Limit, along, limit};
use crate::touch::condition::Condition;
use crate::touch::motion::Motion;
use crate::touch::values::{add, greater, lesser, scale};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Squared distance above which a frame is not at a level: 42 for 16 taxels, a chi-square's mean of
/// 16 and 4.5 times its standard deviation of 5.7.
const DEPARTED: Limit = limit(1.0, 26.0);
/// Squared distance at which a still level, with a mean of 16, is as likely as a motion, with a
/// mean of 32 (noise and a tone as strong as the noise).
const BETWEEN: Limit = limit(1.0, 7.0);
/// [`BETWEEN`] for means of four frames, to which the uncertainty of a level of sixteen adds a
/// quarter.
const BETWEEN_MEANS: Limit = limit(1.25, 18.0);
/// A motion with frames this far off begins or ends abruptly; and the limit for its frames in place
/// of [`BETWEEN`]. Smaller distances after a strong motion may be the curve of a skin's creep.
const SHARP_START: (Limit, Limit) = (limit(90.0, 0.0), DEPARTED);
const SHARP_END: (Limit, Limit) = (limit(600.0, 0.0), limit(10.0, 0.0));
/// Maximum count of one frame, in units of the limit: a knock is not a motion that goes on.
const MAX: f32 = 3.0;
/// Distance of a sum over frames from its maximum or minimum beyond which the sum will not come
/// back: 50 ms of noise. For the start of a motion a sum over means of four needs half as much.
const PAST: Limit = limit(5.0, 20.0);
/// Frames that are searched for the moment of a release: 0.66 s.
pub const SEARCH_FRAMES: u32 = 160;
/// Fraction of the way to a level that is a fall: the skin creeps by about a quarter of it until
/// the fall is noticed.
const FALL_FRACTION: f32 = 0.75;
/// Frames that are searched for the start of a motion before the block that showed it, and after.
const START_FRAMES: (u32, u32) = (44, 16);
/// Maximum number of frames that are searched for the end of a motion: 0.25 s.
pub const END_FRAMES: u32 = 60;
/// Frames of a hold between a slide and the release that show its level: 33 ms.
const PLATEAU_FRAMES: u32 = 8;
/// Frames before a release that may belong to it.
const LIFTING_FRAMES: u32 = 4;

/// Frames in the ring, and the units of distances.
#[derive(Clone, Copy, Debug)]
pub struct Frames<'a> {
    pub ring: Averages<'a>,
    pub condition: &'a Condition,
    pub motion: &'a Motion,
}

/// Level of the taxels while nothing moves.
#[derive(Clone, Copy)]
pub struct StillLevel<'a> {
    pub level: &'a Values,
    /// Creep of the skin: rise of the level per frame.
    pub creep: Option<&'a Values>,
}

impl<'a> StillLevel<'a> {
    pub const fn new(level: &'a Values) -> Self {
        Self { level, creep: None }
    }
}

/// Frames to search, backwards from `last`.
struct Search {
    last: u32,
    frames: u32,
    stride: u32,
    /// True if the limits are those of a motion's start, or of its end.
    for_start: bool,
}

/// Evidence from frames and from means of four; and from frames by a greater limit, if a motion
/// begins or ends abruptly: the curve of a skin's creep is no motion.
struct Evidence {
    single: Sum,
    mean: Sum,
    sharp: Option<Sum>,
}

/// Sum of the evidence in frames, latest first, and its maximum. Evidence is a squared distance
/// less the limit `between` a still level and a motion, or the limit less the distance.
#[derive(Clone, Copy)]
struct Sum {
    between: f32,
    /// See [`PAST`].
    past: f32,
    sum: f32,
    max: f32,
    max_from: u32,
}

impl Sum {
    const fn new(between: f32, past: f32, last: u32) -> Self {
        Self {
            between,
            past,
            sum: 0.0,
            max: 0.0,
            max_from: last,
        }
    }

    /// True if the search is far past the maximum.
    fn is_past(&self) -> bool {
        self.max - self.sum > self.past
    }

    /// Adds the evidence in a squared distance, whose mean in noise alone is the number of taxels.
    fn add(&mut self, apart: f32, sign: f32, frame: u32) {
        let apart = lesser(apart, MAX * self.between);
        self.sum += sign * (apart - self.between);
        if self.sum > self.max {
            (self.max, self.max_from) = (self.sum, frame);
        }
    }
}

impl Frames<'_> {
    /// A frame without hum and drift, if present. [`Self::search`], the costliest, has this inlined.
    pub fn values<'a>(&'a self, frame: u32, buffer: &'a mut Values) -> Option<&'a Values> {
        self.condition.frame(self.ring, frame, buffer)
    }

    fn is_off(&self, level: &Values, frame: u32) -> bool {
        let (motion, mut buffer) = (self.motion, [0.0; TAXELS]);
        let values = self.values(frame, &mut buffer);
        values.is_some_and(|values| motion.distance(values, level) > motion.taxels.limit(DEPARTED))
    }

    /// Looks back from frame `last` and adds up the evidence for motion away from a still level, or
    /// against it, ignoring changes along the load. Returns the frames from which on it is the most.
    /// Means of four frames show a slow motion earlier than single frames do, and a motion near
    /// 60 Hz not at all.
    fn search(&self, still: StillLevel<'_>, search: Search) -> Evidence {
        let StillLevel { level, creep } = still;
        let Search { last, .. } = search;
        let (weights, pull) = (self.motion.weights(), &self.motion.pull);
        let of = |limit| self.motion.taxels.limit(limit);
        let (sign, past_of_means, (is_sharp, between_sharp)) = if search.for_start {
            (1.0, 0.5, SHARP_START)
        } else {
            (-1.0, 1.0, SHARP_END)
        };
        let mut single = Sum::new(of(BETWEEN), of(PAST), last);
        let mut sharp = Sum::new(of(between_sharp), of(PAST), last);
        let mut mean = Sum::new(of(BETWEEN_MEANS), past_of_means * of(PAST), last);
        let (mut peak, mut buffer) = (0.0, [0.0; TAXELS]);
        let fraction = 1.0 / self.motion.wander();
        // Side by side, so that they are read together.
        let mut taxels: [[f32; 4]; TAXELS] =
            core::array::from_fn(|c| [level[c], weights[c], pull[c], 0.0]);
        for back in 0..search.frames {
            let frame = last.wrapping_sub(back * search.stride);
            let mut apart = Apart::NONE;
            if let Some(values) = self.condition.frame(self.ring, frame, &mut buffer) {
                // Four at a time: the loop took a quarter of the instructions of one taxel.
                let fours = taxels.as_chunks_mut::<4>().0.iter_mut();
                for (values, taxels) in values.as_chunks::<4>().0.iter().zip(fours) {
                    for (value, [level, weight, pull, four]) in values.iter().zip(taxels) {
                        let off = value - *level;
                        *four += off;
                        apart.add(off, *weight, *pull);
                    }
                }
            }
            if let Some(creep) = creep {
                for ([level, ..], creep) in taxels.iter_mut().zip(creep) {
                    *level -= creep;
                }
            }
            let square = apart.square() * fraction;
            peak = greater(peak, square);
            single.add(square, sign, frame);
            sharp.add(square, sign, frame);
            if back % BLOCK_FRAMES == BLOCK_FRAMES - 1 {
                apart = Apart::NONE;
                for [_, weight, pull, four] in &mut taxels {
                    apart.add(core::mem::take(four), *weight, *pull);
                }
                let square = apart.square() * fraction * (1.0 / BLOCK_FRAMES as f32);
                mean.add(square, sign, frame);
                if single.is_past() && mean.is_past() && sharp.is_past() {
                    break;
                }
            }
        }
        let sharp = (peak > of(is_sharp)).then_some(sharp);
        Evidence {
            single,
            mean,
            sharp,
        }
    }

    /// The first frame of a motion away from `level` that block `since` showed, `earliest` or
    /// later.
    pub fn departure(&self, level: &Values, since: u32, earliest: u32) -> u32 {
        let (before, behind) = START_FRAMES;
        let (last, latest) = (since.wrapping_add(behind), self.condition.latest());
        let last = if reached(last, latest) { latest } else { last };
        let search = Search {
            last,
            frames: last.wrapping_sub(earliest).min(before + behind),
            stride: 1,
            for_start: true,
        };
        let found = self.search(StillLevel::new(level), search);
        let Evidence { single, mean, .. } = found;
        if let Some(sharp) = found.sharp {
            return sharp.max_from;
        }
        // A mean may be off its level by its last frame alone.
        let mean_from = mean.max_from.wrapping_add(BLOCK_FRAMES - 1);
        match (single.max > 0.0, mean.max > 0.0) {
            (true, false) => single.max_from,
            (true, true) if reached(mean_from, single.max_from) => single.max_from,
            (_, true) => mean_from,
            (false, false) => since,
        }
    }

    /// The first of the frames up to `last` that are at `level` without a break. A single frame off
    /// the level may be noise.
    pub fn arrival(&self, level: &Values, last: u32) -> u32 {
        let mut was_off = false;
        // One more than is searched: a border is known by the frame before it.
        for frame in (0..=SEARCH_FRAMES).map(|back| last.wrapping_sub(back)) {
            let is_off = self.is_off(level, frame);
            if is_off && was_off {
                return frame.wrapping_add(2);
            }
            was_off = is_off;
        }
        last
    }

    /// The first of the frames up to `last` that have gone most of the way from one level to
    /// another along the load. The creep of a skin after the load is less.
    pub fn fall(&self, from: &Values, to: &Values, last: u32) -> u32 {
        let (pull, mut buffer) = (&self.motion.pull, [0.0; TAXELS]);
        let max = FALL_FRACTION * along(pull, from, to);
        for frame in (0..=SEARCH_FRAMES).map(|back| last.wrapping_sub(back)) {
            let values = self.values(frame, &mut buffer);
            if values.is_some_and(|values| along(pull, from, values) > max) {
                return frame.wrapping_add(1);
            }
        }
        last
    }

    /// The first still frame after a motion that is over in frame `last`: from there on the
    /// evidence against a motion is the most. No earlier than `earliest`. Looks at one frame of
    /// `stride`.
    pub fn motion_end(&self, still: StillLevel<'_>, last: u32, earliest: u32, stride: u32) -> u32 {
        let search = Search {
            last,
            frames: (last.wrapping_sub(earliest) / stride).min(END_FRAMES),
            stride,
            for_start: false,
        };
        let found = self.search(still, search);
        if let Some(sharp) = found.sharp {
            return sharp.max_from;
        }
        let (single_from, mean_from) = (found.single.max_from, found.mean.max_from);
        let mean_from = mean_from.wrapping_sub(stride * (BLOCK_FRAMES - 1));
        match mean_from.wrapping_sub(single_from) {
            _ if reached(single_from, mean_from) => single_from,
            // One mean more may be noise.
            later if later <= stride * BLOCK_FRAMES => single_from.wrapping_add(later / 2),
            _ => mean_from,
        }
    }

    /// The mean of the `frames` frames up to `last`.
    pub fn mean(&self, last: u32, frames: u32) -> Values {
        let (mut sum, mut count, mut buffer) = ([0.0; TAXELS], 0.0, [0.0; TAXELS]);
        for frame in (0..frames).map(|back| last.wrapping_sub(back)) {
            if let Some(values) = self.values(frame, &mut buffer) {
                add(&mut sum, values);
                count += 1.0;
            }
        }
        scale(&mut sum, 1.0 / greater(count, 1.0));
        sum
    }

    /// The first frame of a hold that a release at frame `lifted` ended; `lifted` if there was no
    /// hold.
    pub fn hold_before(&self, lifted: u32, earliest: u32) -> u32 {
        let last = lifted.wrapping_sub(LIFTING_FRAMES);
        let level = self.mean(last, PLATEAU_FRAMES);
        let held = self.motion_end(StillLevel::new(&level), last, earliest, 2);
        let is_short = last.wrapping_sub(held) < PLATEAU_FRAMES;
        if is_short { lifted } else { held }
    }
}
