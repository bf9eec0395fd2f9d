//! Frames of a window, centred and scaled, with hum, delays and impulses subtracted. Each pass
//! reads the frames from their source.

use crate::domain::Domain;
use crate::frame::Frame;
use crate::frame_span::FrameSpan;
use crate::hum::Hum;
use crate::impulses::Impulses;
use crate::late::Late;
use crate::limits::{CHANNELS_MAX, POINTS_CHIP, POINTS_MAX};
use crate::nyquist::Nyquist;
use crate::residual::Model;
use crate::source::Values;
use crate::statistics::Statistics;
use core::ops::Range;

/// Maximum rounding error of a level, as a fraction of the channel's standard deviation.
const COARSE: f32 = 1e-5;

/// Channel numbers, levels, slopes and inverse scales of a group of four channels; unused channels
/// yield zeros.
#[derive(Clone, Copy, Default)]
struct Units {
    from: [u8; 4],
    /// Large levels, subtracted before the slope; zero for other channels. Rounding the sum of a
    /// large level and the slope would cause steps that repeat over the window.
    coarse: [f32; 4],
    level: [f32; 4],
    slope: [f32; 4],
    inverse: [f32; 4],
}

impl Units {
    /// Units of all groups of four channels.
    fn of_groups(statistics: &Statistics) -> [Self; CHANNELS_MAX / 4] {
        let unused = Self {
            from: [statistics.order[0]; 4],
            ..Self::default()
        };
        let mut groups = [unused; CHANNELS_MAX / 4];
        for k in 0..statistics.width.min(CHANNELS_MAX) {
            let group = &mut groups[k / 4];
            group.from[k % 4] = statistics.order[k];
            let (level, scale) = (statistics.level[k], statistics.scale[k]);
            if f32::EPSILON * level.abs() > COARSE * scale {
                group.coarse[k % 4] = level;
            } else {
                group.level[k % 4] = level;
            }
            group.slope[k % 4] = statistics.slope[k];
            group.inverse[k % 4] = 1.0 / statistics.scale[k];
        }
        groups
    }

    #[inline(always)]
    fn change(&self, u: f32, values: &Values) -> [f32; 4] {
        core::array::from_fn(|k| {
            let value = values[usize::from(self.from[k]) % CHANNELS_MAX];
            let value = value - self.coarse[k];
            (value - (self.level[k] + self.slope[k] * u)) * self.inverse[k]
        })
    }
}

pub struct WindowFrames<'d, 's> {
    pub span: &'d mut FrameSpan<'s>,
    pub statistics: Statistics,
    pub domain: Domain<'s>,
    pub impulses: &'d mut Impulses,
    pub hum: Option<Hum>,
    /// Corrections for multiplexing delay.
    pub late: Option<Late>,
    /// True if frames were overwritten during the fit.
    pub is_lost: bool,
}

impl WindowFrames<'_, '_> {
    pub fn width(&self) -> usize {
        self.statistics.width.min(CHANNELS_MAX)
    }

    /// Number of frames of the window, missing ones included.
    pub fn count(&self) -> u32 {
        self.span.frames
    }

    /// Half the frame rate, cycles per window.
    pub fn cycles_max(&self) -> f32 {
        match self.domain {
            Domain::Time { .. } => 0.5 * self.count() as f32,
            Domain::Position { .. } => 0.5 * self.span.effective_frames(),
        }
    }

    pub fn nyquist(&self) -> Nyquist {
        Nyquist {
            max: self.cycles_max(),
            aliases: matches!(self.domain, Domain::Time { .. }),
        }
    }

    /// Frames per point of a transform that is zero-padded to twice its length.
    pub fn frames_each(&self) -> u32 {
        let max = if self.count() as usize <= POINTS_CHIP {
            POINTS_CHIP / 2
        } else {
            POINTS_MAX / 2
        };
        self.count().div_ceil(max as u32).max(1)
    }

    pub fn visit(&mut self, mut visit: impl FnMut(&Frame)) {
        self.visit_channels(0..self.width(), &mut visit);
    }

    /// Visits the frames, with at least the values of `channels` filled in.
    #[inline(never)]
    pub fn visit_channels(&mut self, channels: Range<usize>, visit: &mut dyn FnMut(&Frame)) {
        let groups = channels.start / 4..channels.end.div_ceil(4);
        let wanted = self.statistics.wanted;
        let units = Units::of_groups(&self.statistics);
        let units = units.get(groups.clone()).unwrap_or_default();
        let (domain, hum, late) = (&self.domain, &self.hum, &self.late);
        let mut impulses = self.impulses.iter();
        let mut frame = Frame {
            number: 0,
            u: 0.0,
            values: [0.0; CHANNELS_MAX],
        };
        let read = self.span.visit(wanted, &mut |number, values| {
            let u = domain.u(number);
            (frame.number, frame.u) = (number, u);
            let places = frame.values.as_chunks_mut::<4>().0.iter_mut();
            for (place, units) in places.skip(groups.start).zip(units) {
                *place = units.change(u, values);
            }
            if let Some(hum) = hum {
                hum.subtract(&mut frame);
            }
            if let Some(late) = late {
                late.subtract(domain, &mut frame);
            }
            impulses.subtract(&mut frame);
            visit(&frame);
        });
        self.is_lost |= read.is_err();
    }

    /// Visits the frames, or their residuals after subtracting a model.
    pub fn visit_residuals(&mut self, model: Option<&Model>, mut visit: impl FnMut(&Frame)) {
        let width = self.width();
        self.visit(|frame| match model {
            Some(model) => {
                let values = model.residual(frame, 0..width);
                visit(&Frame { values, ..*frame });
            }
            None => visit(frame),
        });
    }

    /// Updates levels and slopes after values were corrected.
    pub fn centre(&mut self) {
        let (mut sums, mut slopes) = ([0.0; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        let [mut n, mut sum_u, mut sum_uu] = [0.0; 3];
        self.visit(|frame| {
            n += 1.0;
            sum_u += frame.u;
            sum_uu += frame.u * frame.u;
            for (k, value) in frame.values.iter().enumerate() {
                sums[k] += value;
                slopes[k] += frame.u * value;
            }
        });
        let spread = (sum_uu - sum_u * sum_u / n).max(f32::MIN_POSITIVE);
        for k in 0..CHANNELS_MAX {
            slopes[k] = (slopes[k] - sum_u / n * sums[k]) / spread;
            sums[k] = (sums[k] - slopes[k] * sum_u) / n;
        }
        let statistics = &mut self.statistics;
        for k in 0..CHANNELS_MAX {
            statistics.level[k] += statistics.scale[k] * sums[k];
            statistics.slope[k] += statistics.scale[k] * slopes[k];
        }
    }
}
