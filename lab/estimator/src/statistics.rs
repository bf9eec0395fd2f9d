//! First passes: level, slope and scale of each channel, and the products of the channels without
//! their lines.

use crate::frame_span::FrameSpan;
use crate::hum::Hum;
use crate::impulses::Impulses;
use crate::limits::CHANNELS_MAX;
use crate::matrix::Square;
use crate::source::{Overwritten, Values};

/// A channel that is at its highest or lowest value in more than this share of the frames is
/// clipped.
const CLIPPED_SHARE: f32 = 0.25;

/// Share of a channel's power that is rounding of f32 sums.
const ROUNDING: f32 = 3e-7;

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
    /// What is subtracted as an interferer's.
    pub hum: Option<Hum>,
}

/// Sums of one channel, of values less its first one.
#[derive(Clone, Copy, Default)]
struct Sums {
    first: f32,
    sum: f32,
    sum_u: f32,
    squares: f32,
    most: f32,
    least: f32,
    at_most: u32,
    at_least: u32,
}

impl Sums {
    fn add(&mut self, u: f32, value: f32) {
        let value = value - self.first;
        self.sum += value;
        self.sum_u += u * value;
        self.squares += value * value;
        if value > self.most {
            (self.most, self.at_most) = (value, 0);
        }
        if value < self.least {
            (self.least, self.at_least) = (value, 0);
        }
        self.at_most += u32::from(value == self.most);
        self.at_least += u32::from(value == self.least);
    }

    fn is_clipped(&self, frames: u32) -> bool {
        self.at_most.max(self.at_least) as f32 > CLIPPED_SHARE * frames as f32
    }
}

impl Statistics {
    /// Reads the span once for levels and slopes, and once for scales.
    pub fn collect(span: &mut FrameSpan) -> Result<Self, Overwritten> {
        let wanted = span.channels()?;
        let (mut sums, mut frames) = ([Sums::default(); CHANNELS_MAX], 0);
        let (mut sum_u, mut sum_uu) = (0.0, 0.0);
        let place = *span.abscissa();
        span.visit(wanted, &mut |frame, values| {
            let u = place.u(frame);
            for (sums, value) in sums.iter_mut().zip(values) {
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
            hum: None,
        };
        let n = frames.max(1) as f32;
        let (mean_u, spread) = (
            sum_u / n,
            (sum_uu - sum_u * sum_u / n).max(f32::MIN_POSITIVE),
        );
        let mut clear = true;
        for _ in 0..2 {
            for (c, sums) in sums.iter().enumerate() {
                let is_used = wanted >> c & 1 == 1 && sums.most > sums.least;
                if !is_used || clear && sums.is_clipped(frames) {
                    continue;
                }
                let k = statistics.width;
                let slope = (sums.sum_u - mean_u * sums.sum) / spread;
                statistics.order[k] = c as u8;
                statistics.slope[k] = slope;
                statistics.level[k] = sums.first + sums.sum / n - slope * mean_u;
                statistics.width += 1;
            }
            if statistics.width > 0 {
                break;
            }
            clear = false;
        }
        statistics.scales(span)?;
        Ok(statistics)
    }

    /// Standard deviations about the lines; a channel that is its line is left out.
    fn scales(&mut self, span: &mut FrameSpan) -> Result<(), Overwritten> {
        let (mut squares, mut levels) = ([0.0; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        self.visit(span, &Impulses::NONE, &mut |frame| {
            for (k, value) in frame.values.iter().enumerate() {
                squares[k] += value * value;
                levels[k] += value;
            }
        })?;
        let mut width = 0;
        let n = self.frames.max(1) as f32;
        for k in 0..self.width {
            let scale = libm::sqrtf(squares[k] / n);
            let rounding = f32::EPSILON * (self.level[k].abs() + self.slope[k].abs());
            if scale > rounding && scale.is_finite() {
                self.order[width] = self.order[k];
                // What rounding of large sums has left.
                self.level[width] = self.level[k] + levels[k] / n;
                self.slope[width] = self.slope[k];
                self.scale[width] = scale;
                width += 1;
            }
        }
        self.width = width;
        Ok(())
    }

    /// Takes level and slope out of what replaced impulses leave.
    pub fn centre(&mut self, span: &mut FrameSpan, impulses: &Impulses) -> Result<(), Overwritten> {
        let (mut sums, mut slopes) = ([0.0; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        let [mut sum_u, mut sum_uu] = [0.0; 2];
        self.visit(span, impulses, &mut |frame| {
            sum_u += frame.u;
            sum_uu += frame.u * frame.u;
            for (k, value) in frame.values.iter().enumerate() {
                sums[k] += value;
                slopes[k] += frame.u * value;
            }
        })?;
        let n = self.frames.max(1) as f32;
        let spread = (sum_uu - sum_u * sum_u / n).max(f32::MIN_POSITIVE);
        for k in 0..self.width {
            let slope = (slopes[k] - sum_u / n * sums[k]) / spread;
            self.slope[k] += self.scale[k] * slope;
            self.level[k] += self.scale[k] * (sums[k] - slope * sum_u) / n;
        }
        Ok(())
    }

    /// Visits all frames, centred and scaled.
    pub fn visit(
        &self,
        span: &mut FrameSpan,
        impulses: &Impulses,
        visit: &mut dyn FnMut(&Frame),
    ) -> Result<(), Overwritten> {
        let place = *span.abscissa();
        let mut next = 0;
        let inverse = self.scale.map(|scale| 1.0 / scale);
        span.visit(self.wanted, &mut |number, values| {
            let u = place.u(number);
            let mut frame = Frame {
                number,
                u,
                values: [0.0; CHANNELS_MAX],
            };
            for k in 0..self.width.min(CHANNELS_MAX) {
                let value = values[self.order[k] as usize % CHANNELS_MAX];
                frame.values[k] = (value - self.level[k] - self.slope[k] * u) * inverse[k];
            }
            if let Some(hum) = &self.hum {
                hum.subtract(&mut frame);
            }
            impulses.replace(number, &mut next, &mut frame.values);
            visit(&frame);
        })
    }

    /// Products of the channels, summed over the frames.
    #[inline(never)]
    pub fn products(
        &self,
        span: &mut FrameSpan,
        impulses: &Impulses,
    ) -> Result<Products, Overwritten> {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        self.visit(span, impulses, &mut |frame| {
            for (k, row) in products.iter_mut().enumerate().take(self.width) {
                for (product, value) in row.iter_mut().zip(&frame.values).take(k + 1) {
                    *product += frame.values[k] * value;
                }
            }
        })?;
        for k in 0..self.width {
            for l in 0..k {
                products[l][k] = products[k][l];
            }
        }
        let frames = self.frames as f32;
        let step = span.quantization_step;
        let rounding = self
            .scale
            .map(|scale| step * step / (12.0 * scale * scale) + ROUNDING);
        Ok(Products {
            matrix: products,
            least: rounding.map(|variance| frames * variance),
        })
    }
}

/// Products of the channels.
#[derive(Clone, Debug)]
pub struct Products {
    /// Summed over the frames.
    pub matrix: Square<CHANNELS_MAX>,
    /// Least square sums of residuals: rounding, of the values and of sums.
    pub least: Values,
}

/// A frame, centred and scaled.
pub struct Frame {
    /// Its number in the span.
    pub number: u32,
    /// Its place.
    pub u: f32,
    /// Values by place in [`Statistics::order`].
    pub values: Values,
}

/// A window's frames as all passes read them.
pub struct Data<'d, 's> {
    /// The frames.
    pub span: &'d mut FrameSpan<'s>,
    /// Levels and scales.
    pub statistics: &'d Statistics,
    /// What is replaced.
    pub impulses: &'d Impulses,
}

impl Data<'_, '_> {
    /// Visits all frames.
    pub fn visit(&mut self, visit: &mut dyn FnMut(&Frame)) -> Result<(), Overwritten> {
        self.statistics.visit(self.span, self.impulses, visit)
    }

    /// Place of a frame in a transform of the window: along a path by where it is.
    pub fn slot(&self) -> impl Fn(&Frame) -> usize + use<> {
        let (frames, in_time) = (self.span.frames as f32, self.span.is_in_time());
        move |frame| {
            if in_time {
                frame.number as usize
            } else {
                (0.5 * (frame.u + 1.0) * frames) as usize
            }
        }
    }

    /// Cycles a window of half the frame rate.
    pub fn cycles_max(&self) -> f32 {
        0.5 * self.span.effective_frames()
    }
}
