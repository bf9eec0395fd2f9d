//! Impulses: single values far off what is beside them. Squares weigh one of twenty standard
//! deviations as four hundred others, so where there are some they are replaced by the model and
//! the window is fitted anew.
//!
//! One step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd
//! edition, 2009), section 4.8.

use crate::limits::CHANNELS_MAX;
use crate::phase_course::Course;
use crate::residual::{Model, Motion};
use crate::solve::Solution;
use crate::source::{Overwritten, Values};
use crate::statistics::Data;
use crate::tests::Sum;

/// Deviate of one value among some thousands.
const Z_IMPULSE: f32 = 4.8;
/// A step from a value to the one beside it has twice the noise: nearly the root of 2.
const STEP: f32 = 1.41;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// Most of a window's values that may be impulses.
const SHARE_MAX: f32 = 0.1;

/// Most impulses of a window.
const IMPULSES_MAX: usize = 192;

/// Values to be replaced, in the order of their frames.
#[derive(Debug)]
pub struct Impulses {
    frames: [u32; IMPULSES_MAX],
    channels: [u8; IMPULSES_MAX],
    /// What is added to the centred and scaled value.
    changes: [f32; IMPULSES_MAX],
    count: usize,
}

impl Impulses {
    /// None; all zeros.
    pub const NONE: Self = Self {
        frames: [0; IMPULSES_MAX],
        channels: [0; IMPULSES_MAX],
        changes: [0.0; IMPULSES_MAX],
        count: 0,
    };

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// How many are replaced.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether there is room for one more.
    pub fn has_room(&self) -> bool {
        self.count < IMPULSES_MAX
    }

    /// Adds one; a value that is replaced already is changed further.
    pub fn add(&mut self, frame: u32, channel: usize, change: f32) {
        let found = (0..self.count)
            .find(|i| self.frames[*i] == frame && usize::from(self.channels[*i]) == channel);
        if let Some(i) = found {
            self.changes[i] += change;
            return;
        }
        if self.has_room() {
            let mut i = self.count;
            while i > 0 && self.frames[i - 1] > frame {
                self.frames[i] = self.frames[i - 1];
                self.channels[i] = self.channels[i - 1];
                self.changes[i] = self.changes[i - 1];
                i -= 1;
            }
            self.frames[i] = frame;
            self.channels[i] = channel as u8;
            self.changes[i] = change;
            self.count += 1;
        }
    }

    /// Adds those of another window's pass.
    pub fn merge(&mut self, other: &Self) {
        for i in 0..other.count {
            self.add(
                other.frames[i],
                usize::from(other.channels[i]),
                other.changes[i],
            );
        }
    }

    /// Replaces those of a frame; `next` is the place of the next one in a pass.
    pub fn replace(&self, frame: u32, next: &mut usize, values: &mut [f32; CHANNELS_MAX]) {
        while *next < self.count && self.frames[*next] <= frame {
            if self.frames[*next] == frame {
                values[usize::from(self.channels[*next]) % CHANNELS_MAX] += self.changes[*next];
            }
            *next += 1;
        }
    }
}

/// The residuals of a window, frame after frame, each with those beside it.
fn residuals(
    data: &mut Data,
    model: &Model,
    visit: &mut dyn FnMut(u32, &[Values; 3]),
) -> Result<(), Overwritten> {
    let mut last = [[0.0; CHANNELS_MAX]; 3];
    let (mut count, mut numbers) = (0u32, [0; 2]);
    data.visit(&mut |frame| {
        last = [last[1], last[2], model.residual(frame)];
        numbers = [numbers[1], frame.number];
        count += 1;
        if count == 2 {
            // The first frame has one frame beside it, twice.
            visit(numbers[0], &[last[2], last[1], last[2]]);
        } else if count > 2 {
            visit(numbers[0], &last);
        }
    })?;
    if count > 1 {
        visit(numbers[1], &[last[1], last[2], last[1]]);
    }
    Ok(())
}

/// Impulses that a solution leaves beside those that are replaced already.
#[inline(never)]
pub fn find(
    data: &mut Data,
    solution: &Solution,
    course: &Course,
) -> Result<Impulses, Overwritten> {
    let model = Model {
        shape: solution.shape,
        coefficients: solution.coefficients,
        motion: Motion::NONE,
        course: *course,
    };
    let width = data.statistics.width;
    let frames = data.statistics.frames as f32;
    // The first limit is by all magnitudes, which impulses raise; the second by those below it.
    let (mut limits, mut found) = ([f32::INFINITY; CHANNELS_MAX], Impulses::NONE);
    for round in 0..2 {
        let (mut magnitudes, mut most) = ([Sum::default(); CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        residuals(data, &model, &mut |_, [_, values, _]| {
            for (k, value) in values.iter().enumerate().take(width) {
                most[k] = f32::max(most[k], value.abs());
                if value.abs() < limits[k] {
                    magnitudes[k].add(value.abs());
                }
            }
        })?;
        limits = magnitudes.map(|sum| Z_IMPULSE / MEAN_MAGNITUDE * sum.mean());
        if round == 0 && (0..width).all(|k| most[k] <= limits[k]) {
            return Ok(found);
        }
    }
    let mut all = 0;
    residuals(data, &model, &mut |frame, [before, values, after]| {
        for (k, value) in values.iter().enumerate().take(width) {
            let sign = 1f32.copysign(*value);
            let least = ((value - before[k]) * sign).min((value - after[k]) * sign);
            if value.abs() > limits[k] && least > STEP * limits[k] && limits[k] > 0.0 {
                found.add(frame, k, -value);
                all += 1;
            }
        }
    })?;
    if all > found.count() || all as f32 > SHARE_MAX * frames * width as f32 {
        found.clear();
    }
    Ok(found)
}
