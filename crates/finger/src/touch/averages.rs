//! Frames for touch detection: averages of a fast plan's frames, so that any plan has some 241 a
//! second.
//!
//! A mean hides faster changes, so the squares of the frames about their means go with it.

use crate::ring::Ring;
use crate::scan::taxels;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::scan::TAXELS;
use ridgetone_tone::Values;

/// Position of the means in the ring. Means are numbered, as frames are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Frames per mean.
    pub frames: u32,
    /// Number of a mean, and of its first frame.
    number: u32,
    first: u32,
}

impl Grid {
    /// First frame of a mean.
    #[inline(always)]
    pub const fn first_frame(&self, number: u32) -> u32 {
        self.first
            .wrapping_sub(self.number.wrapping_sub(number).wrapping_mul(self.frames))
    }
}

/// Means of frames in the ring.
#[derive(Clone, Copy, Debug)]
pub struct Averages<'a> {
    ring: &'a Ring,
    grid: Grid,
}

impl<'a> Averages<'a> {
    /// Evenly spaced means.
    pub const fn new(ring: &'a Ring, grid: Grid) -> Self {
        Self { ring, grid }
    }

    /// A mean, if one of its frames is present with a valid value; it may be in `buffer`.
    #[inline(always)]
    pub fn frame<'b>(&self, number: u32, buffer: &'b mut Values) -> Option<&'b Values>
    where
        'a: 'b,
    {
        if self.grid.frames == 1 {
            return self.ring.frame(number, buffer).map(|(values, _)| values);
        }
        self.ring
            .mean(self.grid.first_frame(number), self.grid.frames, buffer)
            .then_some(&*buffer)
    }
}

/// Means and squares of the latest frames.
#[derive(Clone, Debug)]
pub struct Averager {
    grid: Grid,
    /// Sums over the frames of the mean under way, and their number.
    sums: Values,
    squares: Values,
    count: u32,
    /// The latest mean. If it has just ended, `squares` are those of its frames about it.
    mean: Values,
    has_ended: bool,
}

impl Averager {
    /// An averager before the first frame.
    pub const fn new(plan: &Plan) -> Self {
        Self {
            grid: Grid {
                frames: plan.frames_averaged(),
                number: 0,
                first: 0,
            },
            sums: [0.0; TAXELS],
            squares: [0.0; TAXELS],
            count: 0,
            mean: [0.0; TAXELS],
            has_ended: false,
        }
    }

    /// Starts again with frame `first`.
    pub fn restart(&mut self, first: u32) {
        if self.grid.frames == 1 {
            self.grid.number = first;
        }
        self.grid.first = first;
        self.begin();
        self.mean = [0.0; TAXELS];
    }

    fn begin(&mut self) {
        (self.sums, self.squares) = ([0.0; TAXELS], [0.0; TAXELS]);
        (self.count, self.has_ended) = (0, false);
    }

    /// Position of the means in the ring.
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Number of the mean that is under way.
    pub const fn next(&self) -> u32 {
        self.grid.number
    }

    /// Takes a frame with values of some taxels, if they are valid. Returns the number of the mean
    /// that ends with the frame.
    #[inline(always)]
    pub fn push(
        &mut self,
        number: u32,
        values: &Values,
        inputs: u16,
        is_valid: bool,
    ) -> Option<u32> {
        if self.grid.frames == 1 {
            (self.grid.number, self.grid.first) = (number.wrapping_add(1), number.wrapping_add(1));
            return is_valid.then_some(number);
        }
        self.add(number, is_valid.then_some(values), inputs)
    }

    fn add(&mut self, number: u32, values: Option<&Values>, inputs: u16) -> Option<u32> {
        let frames = self.grid.frames.max(1);
        let beyond = number.wrapping_sub(self.grid.first);
        // The last frames of a mean may be missing.
        if self.has_ended || beyond >= frames {
            self.begin();
        }
        self.skip(beyond / frames);
        if let Some(values) = values {
            self.count += 1;
            for c in taxels(inputs) {
                // Relative to the latest mean, since squares of large numbers would be rounded.
                let off = values[c] - self.mean[c];
                self.sums[c] += off;
                self.squares[c] += off * off;
            }
        }
        if beyond % frames + 1 < frames {
            return None;
        }
        let ended = self.grid.number;
        self.skip(1);
        self.has_ended = self.count > 0;
        if !self.has_ended {
            return None;
        }
        let fraction = 1.0 / self.count as f32;
        // Missing frames are taken to have the squares of the others.
        let times = frames as f32 * fraction;
        for c in taxels(inputs) {
            let off = self.sums[c] * fraction;
            self.squares[c] = (self.squares[c] - self.sums[c] * off) * times;
            self.mean[c] += off;
        }
        Some(ended)
    }

    fn skip(&mut self, means: u32) {
        let Grid {
            frames,
            number,
            first,
        } = &mut self.grid;
        *number = number.wrapping_add(means);
        *first = first.wrapping_add(means.wrapping_mul(*frames));
    }

    /// The mean that has just ended, and the squares of its frames about it, if frames are
    /// averaged.
    #[inline(always)]
    pub fn latest(&self) -> Option<(&Values, &Values)> {
        (self.grid.frames != 1).then_some((&self.mean, &self.squares))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::boxed::Box;
    use std::vec::Vec;

    /// Against sums in f64, with gaps; and the ring gives the same means.
    #[test]
    fn means_and_squares_are_those_of_the_frames() {
        let plan = Plan::TEXTURE;
        let (inputs, frames) = (plan.inputs, plan.frames_averaged());
        let (mut averager, mut ring) = (Averager::new(&plan), Box::new(Ring::new()));
        let first = u32::MAX - 100;
        ring.change(&plan, first);
        averager.restart(first);
        let value =
            |n: u32, c: usize| 3e6 + c as f32 * 1e5 + (n.wrapping_mul(2_654_435_761) >> 20) as f32;
        let is_missing = |n: u32| (300..310).contains(&n) || n % 53 == 7 || (455..560).contains(&n);
        let mut ended = Vec::new();
        for n in 0..900 {
            let number = first.wrapping_add(n);
            let values = core::array::from_fn(|c| value(n, c));
            ring.push(&values, if is_missing(n) { 0 } else { inputs }, n);
            if is_missing(n) && n % 53 != 7 {
                continue;
            }
            let Some(mean) = averager.push(number, &values, inputs, !is_missing(n)) else {
                continue;
            };
            ended.push(mean);
            let there = (mean * frames..(mean + 1) * frames).filter(|n| !is_missing(*n));
            let (means, about) = averager.latest().unwrap();
            let mut buffer = [0.0; TAXELS];
            let averages = Averages::new(&ring, averager.grid());
            let of_ring = averages.frame(mean, &mut buffer).unwrap();
            for c in taxels(inputs) {
                let values: Vec<f64> = there.clone().map(|n| value(n, c).into()).collect();
                let count = values.len() as f64;
                let expected = values.iter().sum::<f64>() / count;
                let squares = values
                    .iter()
                    .map(|value| (value - expected).powi(2))
                    .sum::<f64>();
                let squares = squares * f64::from(frames) / count;
                assert!((f64::from(means[c]) - expected).abs() < 1.0, "{mean}");
                assert!((f64::from(of_ring[c]) - expected).abs() < 3.0, "{mean}");
                // The first mean is far from zero, from which its squares are taken.
                let off = f64::from(about[c]) / squares - 1.0;
                assert!(mean == 0 || off.abs() < 1e-3, "{mean}: {off}");
            }
        }
        let wanted: Vec<u32> = (0..37).filter(|mean| !(18..23).contains(mean)).collect();
        let third = averager.grid().first_frame(3);
        assert_eq!((ended, third), (wanted, first.wrapping_add(3 * frames)));
    }
}
