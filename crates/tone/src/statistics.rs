//! First passes over the frames: level, slope and scale of each channel, then the products of the
//! channels.

use crate::covariance::{ROUNDING, add_product, add_products};
use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::matrix::Square;
use crate::source::{Overwritten, Values};

/// A channel at its highest or lowest value in more than this fraction of the frames is left out,
/// unless a tone clips it. A tone clips once per period, so that no run of clipped frames and no
/// gap between them is longer than this.
const STAYS: f32 = 0.25;
/// Maximum ratio of a rounded, unclipped sine's counts at its extreme value and at the next one.
/// The time spent within h of the extreme is proportional to the root of h.
const AT_END: f32 = 1.0 + core::f32::consts::SQRT_2;
/// Minimum variance about level and slope, relative to the mean square, that the sums resolve.
const LEFT_MIN: f32 = 1e-3;

/// Level, slope and scale of the channels that are used.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Number of valid frames.
    pub frames: u32,
    /// Mask of the channels that a frame must have.
    pub wanted: u16,
    /// Number of channels that are fitted.
    pub width: usize,
    /// Numbers of the fitted channels.
    pub order: [u8; CHANNELS_MAX],
    /// Level at the window's centre, in the order of `order`.
    pub level: Values,
    /// Slope per `u`.
    pub slope: Values,
    /// Standard deviation about level and slope.
    pub scale: Values,
    /// Fraction of the frames in which the channel is clipped.
    pub clipped: Values,
    /// True if a channel stays at an end of its range.
    pub stay: bool,
}

/// True if `count` is more than the fraction [`STAYS`] of the frames.
fn is_long(count: f32, frames: u32) -> bool {
    count > STAYS * frames as f32
}

/// Sums of one channel's values relative to the first.
#[derive(Clone, Copy)]
struct Sums {
    first: f32,
    sum: f32,
    sum_u: f32,
    squares: f32,
    highest: End,
    /// Lowest value, negated.
    lowest: End,
}

impl Sums {
    const NONE: Self = Self {
        first: 0.0,
        sum: 0.0,
        sum_u: 0.0,
        squares: 0.0,
        highest: End::NONE,
        lowest: End::NONE,
    };

    fn add(&mut self, frame: u32, u: f32, value: f32) {
        let value = value - self.first;
        self.sum += value;
        self.sum_u += u * value;
        self.squares += value * value;
        self.highest.add(frame, value);
        self.lowest.add(frame, -value);
    }

    /// True if the channel stays at an end of its range.
    fn stays(&self, frames: u32) -> bool {
        self.ends().any(|end| is_long(end.run_max as f32, frames))
    }

    /// True if the channel is clipped because of its level, or takes only a few values.
    fn is_left_out(&self, frames: u32) -> bool {
        self.ends().any(|end| {
            let gap = end.gap_max.max(frames - end.latest);
            let [count, longest] = [end.outer_count, gap.max(end.run_max)].map(|n| n as f32);
            let is_by_tone = is_long(end.clipped(), frames) && !is_long(longest, frames);
            is_long(count, frames) && !is_by_tone
        })
    }

    fn ends(&self) -> impl Iterator<Item = &End> {
        [&self.highest, &self.lowest].into_iter()
    }

    /// Difference of the highest and the lowest value.
    fn range(&self) -> f32 {
        self.highest.outer + self.lowest.outer
    }
}

/// The two outermost values at one end of a channel's range, and the number of frames at each.
#[derive(Clone, Copy)]
struct End {
    outer: f32,
    outer_count: u32,
    next: f32,
    next_count: u32,
    /// Latest frame at the outermost value.
    latest: u32,
    /// Length of the latest run of frames at the outermost value.
    run: u32,
    run_max: u32,
    /// Longest distance between frames at the outermost value, or from the window's start.
    gap_max: u32,
}

impl End {
    /// State before the first value. Values are relative to the first, so the outermost is 0.
    const NONE: Self = Self {
        outer: 0.0,
        outer_count: 0,
        next: f32::NEG_INFINITY,
        next_count: 0,
        latest: 0,
        run: 0,
        run_max: 0,
        gap_max: 0,
    };

    fn add(&mut self, frame: u32, value: f32) {
        if value < self.next {
            return;
        }
        if value > self.outer {
            (self.next, self.next_count) = (self.outer, self.outer_count);
            (self.outer, self.outer_count) = (value, 1);
            (self.run, self.run_max) = (1, 1);
            (self.latest, self.gap_max) = (frame, frame);
        } else if value == self.outer {
            self.outer_count += 1;
            let gap = frame - self.latest;
            self.run = if gap == 1 { self.run + 1 } else { 1 };
            self.run_max = self.run_max.max(self.run);
            (self.latest, self.gap_max) = (frame, self.gap_max.max(gap));
        } else if value > self.next {
            (self.next, self.next_count) = (value, 1);
        } else {
            self.next_count += 1;
        }
    }

    /// Number of frames at the outermost value, in excess of an unclipped sine.
    fn clipped(&self) -> f32 {
        (self.outer_count as f32 - AT_END * self.next_count as f32).max(0.0)
    }
}

impl Statistics {
    /// Reads the span to measure levels, slopes and scales, and again if the sums do not resolve
    /// the scales.
    #[inline(never)]
    pub fn collect(span: &mut FrameSpan) -> Result<Self, Overwritten> {
        let wanted = span.channels()?;
        let (mut sums, mut frames) = ([Sums::NONE; CHANNELS_MAX], 0);
        let (mut sum_u, mut sum_uu) = (0.0, 0.0);
        let domain = *span.domain();
        let used = (u16::BITS - wanted.leading_zeros()) as usize;
        span.visit(wanted, &mut |frame, values| {
            let u = domain.u(frame);
            for (sums, value) in sums.iter_mut().zip(values).take(used) {
                if frames == 0 {
                    sums.first = *value;
                }
                sums.add(frames, u, *value);
            }
            frames += 1;
            sum_u += u;
            sum_uu += u * u;
        })?;
        let mut statistics = Self {
            frames,
            wanted,
            width: 0,
            order: [0; CHANNELS_MAX],
            level: [0.0; CHANNELS_MAX],
            slope: [0.0; CHANNELS_MAX],
            scale: [1.0; CHANNELS_MAX],
            clipped: [0.0; CHANNELS_MAX],
            stay: false,
        };
        let n = frames.max(1) as f32;
        let (mean_u, spread) = (
            sum_u / n,
            (sum_uu - sum_u * sum_u / n).max(f32::MIN_POSITIVE),
        );
        let (mut is_exact, mut ranges) = (true, [1.0; CHANNELS_MAX]);
        for are_all in [false, true] {
            for (c, sums) in sums.iter().enumerate() {
                let is_used = wanted >> c & 1 == 1 && sums.range() > 0.0;
                if !is_used || !are_all && sums.is_left_out(frames) {
                    continue;
                }
                statistics.stay |= sums.stays(frames);
                let k = statistics.width.min(CHANNELS_MAX - 1);
                let slope = (sums.sum_u - mean_u * sums.sum) / spread;
                statistics.order[k] = c as u8;
                statistics.slope[k] = slope;
                statistics.level[k] = sums.first + sums.sum / n - slope * mean_u;
                let square = sums.squares / n;
                let mean = sums.sum / n;
                let variance = square - mean * mean - slope * slope * spread / n;
                is_exact &= variance > LEFT_MIN * square;
                statistics.scale[k] = crate::sqrt(variance.max(0.0));
                statistics.clipped[k] = (sums.highest.clipped() + sums.lowest.clipped()) / n;
                ranges[k] = 0.5 * sums.range();
                statistics.width += 1;
            }
            if statistics.width > 0 {
                break;
            }
        }
        if !is_exact {
            statistics.scale = ranges;
            statistics.scales(span)?;
        }
        Ok(statistics)
    }

    /// True if no channel is clipped.
    pub fn is_plain(&self) -> bool {
        !self.stay && self.clipped == [0.0; CHANNELS_MAX]
    }

    /// Mask of the channels that are fitted.
    pub fn usable(&self) -> u16 {
        let order = self.order.iter().take(self.width);
        order.fold(0, |mask, channel| mask | 1 << channel)
    }

    /// Visits the frames, centred and scaled.
    fn visit(
        &self,
        span: &mut FrameSpan,
        visit: &mut dyn FnMut(u32, &Values),
    ) -> Result<(), Overwritten> {
        let domain = *span.domain();
        let inverse = self.scale.map(|scale| 1.0 / scale);
        span.visit(self.wanted, &mut |number, values| {
            let u = domain.u(number);
            let mut centred = [0.0; CHANNELS_MAX];
            for k in 0..self.width.min(CHANNELS_MAX) {
                let value = values[self.order[k] as usize % CHANNELS_MAX];
                centred[k] = (value - self.level[k] - self.slope[k] * u) * inverse[k];
            }
            visit(number, &centred);
        })
    }

    /// Measures standard deviations about level and slope; drops channels without residuals.
    fn scales(&mut self, span: &mut FrameSpan) -> Result<(), Overwritten> {
        let (mut squares, mut levels) = ([0.0; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        self.visit(span, &mut |_, values| {
            for (k, value) in values.iter().enumerate() {
                squares[k] += value * value;
                levels[k] += value;
            }
        })?;
        let mut width = 0;
        let n = self.frames.max(1) as f32;
        for k in 0..self.width.min(CHANNELS_MAX) {
            let scale = self.scale[k] * crate::sqrt(squares[k] / n);
            let rounding = f32::EPSILON * (self.level[k].abs() + self.slope[k].abs());
            if scale > rounding && scale.is_finite() {
                let place = width.min(k);
                self.order[place] = self.order[k];
                // Corrects the rounding error of large sums.
                self.level[place] = self.level[k] + self.scale[k] * levels[k] / n;
                self.slope[place] = self.slope[k];
                self.clipped[place] = self.clipped[k];
                self.scale[place] = scale;
                width += 1;
            }
        }
        self.width = width;
        Ok(())
    }

    /// Rounding variance of each channel, for values rounded to multiples of `step`.
    fn rounding(&self, step: f32) -> Values {
        self.scale.map(|scale| {
            let steps = step / scale;
            steps * steps / 12.0 + ROUNDING
        })
    }
}

/// Products of the channels.
#[derive(Clone, Debug)]
pub struct Products {
    /// Summed over the frames, on and below the diagonal.
    pub matrix: Square<CHANNELS_MAX>,
    /// Sums of squares, while frames are added.
    squares: Values,
    /// Minimum sums of squared residuals, due to rounding of the values and the sums.
    pub squares_min: Values,
    /// Number of valid frames.
    pub count: f32,
    /// True if products between channels are summed.
    pub may_share: bool,
    /// Frame waiting to be added together with the next one.
    pending: Option<Values>,
}

impl Products {
    /// Creates empty products, including those between channels if `may_share`; values are rounded
    /// to multiples of `step`.
    pub fn new(statistics: &Statistics, step: f32, may_share: bool) -> Self {
        Self {
            matrix: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
            squares: [0.0; CHANNELS_MAX],
            squares_min: statistics.rounding(step),
            count: 0.0,
            may_share,
            pending: None,
        }
    }

    #[inline]
    pub fn add(&mut self, values: &Values, width: usize) {
        self.count += 1.0;
        let groups = self.squares.as_chunks_mut::<4>().0.iter_mut();
        let groups = groups.zip(values.as_chunks::<4>().0);
        for (squares, values) in groups.take(width.div_ceil(4)) {
            for k in 0..4 {
                squares[k] += values[k] * values[k];
            }
        }
        if self.may_share {
            match self.pending.take() {
                Some(before) => {
                    let rows = self.matrix.get_mut(..width).unwrap_or_default();
                    add_products(rows, [&before, values]);
                }
                None => self.pending = Some(*values),
            }
        }
    }

    /// Completes the sums of all frames that were added.
    pub fn finish(mut self) -> Self {
        if let Some(last) = self.pending.take() {
            add_product(&mut self.matrix, 1.0, &last);
        }
        for (k, square) in self.squares.iter().enumerate() {
            self.matrix[k][k] = *square;
        }
        self.squares_min = self.squares_min.map(|variance| self.count * variance);
        self
    }

    /// Weighted power that rounding may add to a line in the first `width` channels. Without other
    /// noise, all of this power may fall into one line; noise reduces it by the square of the
    /// noise's characteristic function (B. Widrow, I. Kollar, M.-C. Liu, "Statistical theory of
    /// quantization", IEEE Transactions on Instrumentation and Measurement 45, 1996, 353-361).
    pub fn rounding(&self, weights: &Square<CHANNELS_MAX>, width: usize) -> f32 {
        // A step is sqrt(12) standard deviations of the rounding error.
        const SPREAD: f32 = core::f32::consts::PI * core::f32::consts::PI / 3.0;
        let of_channel = |k: usize| {
            let power = weights[k][k] * self.squares_min[k];
            let noise = (self.count / power.max(f32::MIN_POSITIVE) - 1.0).max(0.0);
            power * libm::expf(-SPREAD * noise)
        };
        (0..width.min(CHANNELS_MAX)).map(of_channel).sum()
    }
}
