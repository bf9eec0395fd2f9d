//! First passes: level, slope and scale of each channel; then the products of the channels.

use crate::covariance::{ROUNDING, add_product, add_products};
use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::matrix::Square;
use crate::source::{Overwritten, Values};

/// A channel that is at its highest or lowest value in more than this fraction of the frames is
/// clipped.
const CLIPPED_SHARE: f32 = 0.25;
/// Where a line leaves less of a channel's square, sums do not tell what it leaves.
const LEFT_MIN: f32 = 1e-3;

/// Level, slope and scale of the channels that are used.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Frames that count.
    pub frames: u32,
    /// Mask of the channels that a frame must have.
    pub wanted: u16,
    /// Channels that are fitted.
    pub width: usize,
    /// Their numbers.
    pub order: [u8; CHANNELS_MAX],
    /// Level at the window's centre, by place in `order`.
    pub level: Values,
    /// Slope by `u`.
    pub slope: Values,
    /// Standard deviation about the line.
    pub scale: Values,
}

/// Sums of one channel, of values less its first one.
#[derive(Clone, Copy, Default)]
struct Sums {
    first: f32,
    sum: f32,
    sum_u: f32,
    squares: f32,
    max: f32,
    min: f32,
    at_max: u32,
    at_min: u32,
}

impl Sums {
    fn add(&mut self, u: f32, value: f32) {
        let value = value - self.first;
        self.sum += value;
        self.sum_u += u * value;
        self.squares += value * value;
        if value >= self.max {
            if value > self.max {
                (self.max, self.at_max) = (value, 0);
            }
            self.at_max += 1;
        }
        if value <= self.min {
            if value < self.min {
                (self.min, self.at_min) = (value, 0);
            }
            self.at_min += 1;
        }
    }

    fn is_clipped(&self, frames: u32) -> bool {
        self.at_max.max(self.at_min) as f32 > CLIPPED_SHARE * frames as f32
    }
}

impl Statistics {
    /// Reads the span for levels and slopes, and once more where sums do not tell the scales.
    #[inline(never)]
    pub fn collect(span: &mut FrameSpan) -> Result<Self, Overwritten> {
        let wanted = span.channels()?;
        let (mut sums, mut frames) = ([Sums::default(); CHANNELS_MAX], 0);
        let (mut sum_u, mut sum_uu) = (0.0, 0.0);
        let domain = *span.domain();
        let used = (u16::BITS - wanted.leading_zeros()) as usize;
        span.visit(wanted, &mut |frame, values| {
            let u = domain.u(frame);
            for (sums, value) in sums.iter_mut().zip(values).take(used) {
                if frames == 0 {
                    sums.first = *value;
                }
                sums.add(u, *value);
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
        };
        let n = frames.max(1) as f32;
        let (mean_u, spread) = (
            sum_u / n,
            (sum_uu - sum_u * sum_u / n).max(f32::MIN_POSITIVE),
        );
        let (mut clear, mut is_exact, mut ranges) = (true, true, [1.0; CHANNELS_MAX]);
        for _ in 0..2 {
            for (c, sums) in sums.iter().enumerate() {
                let is_used = wanted >> c & 1 == 1 && sums.max > sums.min;
                if !is_used || clear && sums.is_clipped(frames) {
                    continue;
                }
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
                ranges[k] = 0.5 * (sums.max - sums.min);
                statistics.width += 1;
            }
            if statistics.width > 0 {
                break;
            }
            clear = false;
        }
        if !is_exact {
            statistics.scale = ranges;
            statistics.scales(span)?;
        }
        Ok(statistics)
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

    /// Standard deviations about the lines; a channel that is its line is left out.
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
                // Rounding error of large sums.
                self.level[place] = self.level[k] + self.scale[k] * levels[k] / n;
                self.slope[place] = self.slope[k];
                self.scale[place] = scale;
                width += 1;
            }
        }
        self.width = width;
        Ok(())
    }

    /// Variance of a value's rounding in each channel, where values are rounded to multiples of
    /// `step`.
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
    /// Minimum square sums of residuals: rounding, of the values and of sums.
    pub squares_min: Values,
    /// Frames that count.
    pub count: f32,
    /// True if there are any between channels.
    pub may_share: bool,
    /// A frame that waits for a second one.
    pending: Option<Values>,
}

impl Products {
    /// No products yet, of channels that may share noise or of each with itself alone; values are
    /// rounded to multiples of `step`.
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

    /// Adds a frame.
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

    /// The sums of all frames that were added.
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

    /// What rounding may have of the power of a line in the first `width` channels, by their weights.
    /// Without other noise it may have all of its power in one line; noise spreads it by the square
    /// of its characteristic function (B. Widrow, I. Kollar, M.-C. Liu, "Statistical theory of
    /// quantization", IEEE Transactions on Instrumentation and Measurement 45, 1996, 353-361).
    pub fn rounding(&self, weights: &Square<CHANNELS_MAX>, width: usize) -> f32 {
        // A step is the root of 12 standard deviations of rounding.
        const SPREAD: f32 = core::f32::consts::PI * core::f32::consts::PI / 3.0;
        let of_channel = |k: usize| {
            let power = weights[k][k] * self.squares_min[k];
            let noise = (self.count / power.max(f32::MIN_POSITIVE) - 1.0).max(0.0);
            power * libm::expf(-SPREAD * noise)
        };
        (0..width.min(CHANNELS_MAX)).map(of_channel).sum()
    }
}
