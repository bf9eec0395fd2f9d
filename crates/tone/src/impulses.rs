//! Impulses: single values far off what is next to them. Squares weigh one of twenty standard
//! deviations as four hundred others, so where there are some they are replaced by the model and
//! the window is fitted anew.
//!
//! One step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd
//! edition, 2009), section 4.8.

use crate::data::Data;
use crate::frame::Frame;
use crate::limits::{CHANNELS_MAX, IMPULSES_MAX};
use crate::phase_course::Course;
use crate::residual::Model;
use crate::significance::Sum;
use crate::solve::Solution;
use crate::source::Values;

/// Deviate of one value among some thousands.
const Z_IMPULSE: f32 = 4.8;
/// A step from a value to the one next to it has twice the noise: nearly the root of 2.
const STEP: f32 = 1.41;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// Channels of a frame in a place.
const CHANNELS: u32 = CHANNELS_MAX as u32;
/// Most of a window's values that may be impulses.
const SHARE_MAX: f32 = 0.1;

/// A value that is far off, and by how much.
#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    /// Sixteen times the frame's number, and the channel.
    place: u32,
    /// Values that are subtracted.
    off: f32,
}

/// Values that are far off, in the order of their places.
#[derive(Debug)]
pub struct Impulses {
    list: [Impulse; IMPULSES_MAX],
    count: usize,
}

/// Outliers that are ahead on a pass through the frames.
pub struct Ahead<'i>(&'i [Impulse]);

impl Ahead<'_> {
    /// Subtracts those of a frame.
    #[inline]
    pub fn subtract(&mut self, frame: &mut Frame) {
        while let Some((first, others)) = self.0.split_first() {
            if first.place / CHANNELS > frame.number {
                break;
            }
            if first.place / CHANNELS == frame.number {
                frame.values[(first.place % CHANNELS) as usize] -= first.off;
            }
            self.0 = others;
        }
    }
}

impl Impulses {
    /// Empty; all zeros.
    pub const fn new() -> Self {
        Self {
            list: [Impulse { place: 0, off: 0.0 }; IMPULSES_MAX],
            count: 0,
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Goes through them frame by frame.
    pub fn iter(&self) -> Ahead<'_> {
        Ahead(self.list.get(..self.count).unwrap_or_default())
    }

    /// Adds one behind those of the same and of earlier places.
    fn add(&mut self, place: u32, off: f32) {
        let list = self.list.get_mut(..=self.count).unwrap_or_default();
        let mut before = list.iter_mut().rev();
        let Some(mut free) = before.next() else {
            return;
        };
        for other in before.take_while(|other| other.place > place) {
            *free = *other;
            free = other;
        }
        *free = Impulse { place, off };
        self.count += 1;
    }
}

/// Visits the residuals of a window, frame after frame, each with those beside it.
fn residuals(data: &mut Data, model: &Model, visit: &mut dyn FnMut(u32, &[Values; 3])) {
    let mut last = [[0.0; CHANNELS_MAX]; 3];
    let (mut count, mut numbers) = (0u32, [0; 2]);
    data.visit_beside(Some(model), |frame| {
        last = [last[1], last[2], frame.values];
        numbers = [numbers[1], frame.number];
        count += 1;
        if count == 2 {
            // The first frame has one next to it, twice.
            visit(numbers[0], &[last[2], last[1], last[2]]);
        } else if count > 2 {
            visit(numbers[0], &last);
        }
    });
    if count > 1 {
        visit(numbers[1], &[last[1], last[2], last[1]]);
    }
}

/// Residuals that are beyond their channel's limit, and as far from those before and after: channel
/// and value.
fn far_off<'v>(
    [before, values, after]: &'v [Values; 3],
    limits: &'v Values,
) -> impl Iterator<Item = (u32, f32)> {
    let beside = before.iter().zip(after);
    let channels = values.iter().zip(limits).zip(beside).zip(0..);
    channels.filter_map(|(((value, limit), (before, after)), channel)| {
        let sign = 1f32.copysign(*value);
        let least = ((value - before) * sign).min((value - after) * sign);
        let is_far = value.abs() > *limit && least > STEP * limit && *limit > 0.0;
        is_far.then_some((channel, *value))
    })
}

/// Replaces what a solution leaves of single values; how many there are. Its memory holds nothing.
#[inline(never)]
pub fn replace(data: &mut Data, solution: &Solution, course: &Course, memory: &mut [f32]) -> usize {
    let model = Model {
        solution,
        motion: None,
        course: *course,
    };
    let width = data.width();
    // The first limit is by all magnitudes, which impulses raise; the second by those below it.
    let mut limits = [f32::INFINITY; CHANNELS_MAX];
    for round in 0..2 {
        let (mut magnitudes, mut most) = ([Sum::default(); CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        data.visit_beside(Some(&model), |frame| {
            for (k, value) in frame.values.iter().enumerate().take(width) {
                let magnitude = value.abs();
                if magnitude > most[k] {
                    most[k] = magnitude;
                }
                if magnitude < limits[k] {
                    magnitudes[k].add(magnitude);
                }
            }
        });
        limits = magnitudes.map(|sum| Z_IMPULSE / MEAN_MAGNITUDE * sum.mean());
        let mut pairs = most.iter().zip(&limits);
        if round == 0 && pairs.all(|(most, limit)| most <= limit) {
            return 0;
        }
    }
    let (mut found, mut all) = (0, 0);
    residuals(data, &model, &mut |_, values| {
        all += width;
        found += far_off(values, &limits).count();
    });
    if found as f32 > SHARE_MAX * all as f32
        || found > IMPULSES_MAX - data.impulses.count
        || 2 * found > memory.len()
    {
        return 0;
    }
    let mut pairs = memory.as_chunks_mut::<2>().0.iter_mut();
    residuals(data, &model, &mut |number, values| {
        for ((channel, value), pair) in far_off(values, &limits).zip(&mut pairs) {
            *pair = [(number * CHANNELS + channel) as f32, value];
        }
    });
    for [place, off] in memory.as_chunks::<2>().0.iter().take(found) {
        data.impulses.add(*place as u32, *off);
    }
    found
}
