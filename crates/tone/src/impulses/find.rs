//! Search for impulses in the residuals of a solution.

use super::CHANNELS;
use crate::limits::{CHANNELS_MAX, IMPULSES_MAX};
use crate::residual::Model;
use crate::significance::Sum;
use crate::solve::Solution;
use crate::source::Values;
use crate::trajectory::Trajectory;
use crate::window_frames::WindowFrames;

/// Threshold for an impulse among some thousands of values, standard deviations.
pub const Z_IMPULSE: f32 = 4.8;
/// Threshold for a step between adjacent values, relative to that for a value: about the root of 2,
/// as a step has the noise of two values.
const STEP: f32 = 1.41;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// Maximum fraction of a window's values that may be impulses.
const IMPULSE_FRACTION_MAX: f32 = 0.1;

/// Visits the residuals of each frame together with those of the frames before and after.
fn residuals(window: &mut WindowFrames, model: &Model, visit: &mut dyn FnMut(u32, &[Values; 3])) {
    let mut last = [[0.0; CHANNELS_MAX]; 3];
    let (mut count, mut numbers) = (0u32, [0; 2]);
    window.visit_residuals(Some(model), |frame| {
        last = [last[1], last[2], frame.values];
        numbers = [numbers[1], frame.number];
        count += 1;
        if count == 2 {
            // The first frame has one neighbour, which is passed twice.
            visit(numbers[0], &[last[2], last[1], last[2]]);
        } else if count > 2 {
            visit(numbers[0], &last);
        }
    });
    if count > 1 {
        visit(numbers[1], &[last[1], last[2], last[1]]);
    }
}

/// Returns channel and value of the residuals that exceed their channel's limit and also stand out
/// from the frames before and after.
fn far_off<'v>(
    [before, values, after]: &'v [Values; 3],
    limits: &'v Values,
) -> impl Iterator<Item = (u32, f32)> {
    let beside = before.iter().zip(after);
    let channels = values.iter().zip(limits).zip(beside).zip(0..);
    channels.filter_map(|(((value, limit), (before, after)), channel)| {
        let sign = 1f32.copysign(*value);
        let min = ((value - before) * sign).min((value - after) * sign);
        let is_far = value.abs() > *limit && min > STEP * limit && *limit > 0.0;
        is_far.then_some((channel, *value))
    })
}

/// Finds impulses in the residuals of a solution, which later visits subtract. Returns their
/// number; `memory` is scratch.
#[inline(never)]
pub fn replace(
    window: &mut WindowFrames,
    solution: &Solution,
    trajectory: &Trajectory,
    memory: &mut [f32],
) -> usize {
    let model = Model {
        solution,
        motion: None,
        trajectory: *trajectory,
    };
    let width = window.width();
    // The first limit comes from all magnitudes, so impulses raise it; the second from those below
    // the first.
    let mut limits = [f32::INFINITY; CHANNELS_MAX];
    for round in 0..2 {
        let (mut magnitudes, mut max) = ([Sum::default(); CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        window.visit_residuals(Some(&model), |frame| {
            for (k, value) in frame.values.iter().enumerate().take(width) {
                let magnitude = value.abs();
                if magnitude > max[k] {
                    max[k] = magnitude;
                }
                if magnitude < limits[k] {
                    magnitudes[k].add(magnitude);
                }
            }
        });
        limits = magnitudes.map(|sum| Z_IMPULSE / MEAN_MAGNITUDE * sum.mean());
        let mut pairs = max.iter().zip(&limits);
        if round == 0 && pairs.all(|(max, limit)| max <= limit) {
            return 0;
        }
    }
    let (mut found, mut all) = (0, 0);
    residuals(window, &model, &mut |_, values| {
        all += width;
        found += far_off(values, &limits).count();
    });
    if found as f32 > IMPULSE_FRACTION_MAX * all as f32
        || found > IMPULSES_MAX - window.impulses.count
        || 2 * found > memory.len()
    {
        return 0;
    }
    let mut pairs = memory.as_chunks_mut::<2>().0.iter_mut();
    residuals(window, &model, &mut |number, values| {
        for ((channel, value), pair) in far_off(values, &limits).zip(&mut pairs) {
            *pair = [(number * CHANNELS + channel) as f32, value];
        }
    });
    for [place, off] in memory.as_chunks::<2>().0.iter().take(found) {
        window.impulses.add(*place as u32, *off);
    }
    found
}
