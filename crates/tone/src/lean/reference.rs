//! Level, slope and scale of each channel from some frames: what values are taken against, so that
//! sums in f32 keep their digits. The fit has its own level and slope.

use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::source::{Overwritten, Values};

/// Frames that are looked at.
const FRAMES: u32 = 32;
/// Fewest of them that tell a level and a slope.
const FRAMES_FEWEST: f32 = 8.0;
/// Least variance of a channel over its mean square: rounding.
const ROUNDING: f32 = 1e-12;

/// What values are taken against, by channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    /// Mask of the channels that a frame must have.
    pub wanted: u16,
    /// Number of channels that are fitted.
    pub width: usize,
    /// Level at the window's centre.
    pub level: Values,
    /// Slope by `u`.
    pub slope: Values,
    /// One over the scale; 0 of a channel that is not fitted.
    pub inverse: Values,
    /// Variance of a value's rounding, in units of the scale.
    pub rounding: Values,
}

/// Sums over frames.
#[derive(Clone, Copy, Default)]
struct Sums {
    first: Values,
    values: Values,
    with_u: Values,
    squares: Values,
    n: f32,
    u: f32,
    uu: f32,
}

impl Sums {
    fn add(&mut self, u: f32, values: &Values) {
        if self.n == 0.0 {
            self.first = *values;
        }
        (self.n, self.u, self.uu) = (self.n + 1.0, self.u + u, self.uu + u * u);
        for c in 0..CHANNELS_MAX {
            let value = values[c] - self.first[c];
            self.values[c] += value;
            self.with_u[c] += u * value;
            self.squares[c] += value * value;
        }
    }
}

impl Reference {
    /// The reference of a span.
    pub fn new(span: &mut FrameSpan) -> Result<Self, Overwritten> {
        let wanted = span.channels()?;
        let place = *span.domain();
        let mut sums = Sums::default();
        let every = (span.frames / FRAMES).max(1);
        for every in [every, 1] {
            sums = Sums::default();
            span.visit_some(every, wanted, &mut |number, values| {
                sums.add(place.u(number), values);
            })?;
            if sums.n >= FRAMES_FEWEST {
                break;
            }
        }
        let n = sums.n.max(1.0);
        let spread = (sums.uu - sums.u * sums.u / n).max(f32::MIN_POSITIVE);
        let mut reference = Self {
            wanted,
            ..Self::default()
        };
        for c in 0..CHANNELS_MAX {
            if wanted >> c & 1 == 0 {
                continue;
            }
            let (sum, squares) = (sums.values[c], sums.squares[c]);
            let slope = (sums.with_u[c] - sums.u / n * sum) / spread;
            let level = (sum - slope * sums.u) / n;
            let variance = (squares - sum * sum / n - slope * slope * spread) / n;
            if !(squares > 0.0 && variance.is_finite()) {
                continue;
            }
            let scale = libm::sqrtf(variance.max(ROUNDING * squares / n));
            let step = span.quantization_step / scale;
            reference.level[c] = sums.first[c] + level;
            reference.slope[c] = slope;
            reference.inverse[c] = 1.0 / scale;
            reference.rounding[c] = step * step / 12.0;
            reference.width += 1;
        }
        Ok(reference)
    }

    /// A frame whose channels are finite where they are not fitted.
    #[inline(always)]
    pub fn clean<'f>(&self, values: &'f Values, memory: &'f mut Values) -> &'f Values {
        if self.width == CHANNELS_MAX {
            return values;
        }
        for c in 0..CHANNELS_MAX {
            memory[c] = if self.inverse[c] > 0.0 {
                values[c]
            } else {
                0.0
            };
        }
        memory
    }
}
