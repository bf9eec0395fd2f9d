//! Reference level and scale of each channel, from some frames. Sums of values relative to this
//! level are more precise in f32; the fit still has its own level and slope.

use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::significance::square_root;
use crate::source::{Overwritten, Values};

/// Maximum number of frames for a reference.
const FRAMES: usize = 32;
/// Minimum number of these frames for a level and a slope.
const FRAMES_FEWEST: usize = 8;
/// Minimum variance of a channel relative to its mean square, due to rounding.
const ROUNDING: f32 = 1e-12;

/// Reference of each channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    /// Mask of the channels that a frame must have.
    pub wanted: u16,
    /// Number of channels that are fitted.
    pub width: usize,
    /// Level at the window's centre.
    pub level: Values,
    /// Inverse scale; 0 for a channel that is not fitted.
    pub inverse: Values,
    /// Rounding variance of a value.
    pub rounding: Values,
}

/// Some frames of a window.
struct Sample {
    u: [f32; FRAMES],
    values: [Values; FRAMES],
    count: usize,
}

impl Sample {
    const EMPTY: Self = Self {
        u: [0.0; FRAMES],
        values: [[0.0; CHANNELS_MAX]; FRAMES],
        count: 0,
    };

    /// Takes every `every`th frame that has the wanted channels, as many as there is room for.
    fn take(&mut self, span: &mut FrameSpan, wanted: u16, every: u32) -> Result<(), Overwritten> {
        let (step, mut frame) = (2.0 / span.frames as f32, 0);
        self.count = 0;
        while frame < span.frames && self.count < FRAMES {
            span.visit_runs(frame..frame + 1, wanted, &mut |number, run| {
                if let ([values, ..], Some(place)) = (run, self.values.get_mut(self.count)) {
                    *place = *values;
                    self.u[self.count % FRAMES] = (number as f32 + 0.5) * step - 1.0;
                    self.count += 1;
                }
            })?;
            frame += every;
        }
        Ok(())
    }
}

impl Reference {
    /// The reference of a span.
    #[inline(never)]
    pub fn new(span: &mut FrameSpan) -> Result<Self, Overwritten> {
        let wanted = span.channels()?;
        let every = span.frames.div_ceil(FRAMES as u32).max(1);
        let mut sample = Sample::EMPTY;
        sample.take(span, wanted, every)?;
        if sample.count < FRAMES_FEWEST && every > 1 {
            sample.take(span, wanted, 1)?;
        }
        let mut reference = Self {
            wanted,
            ..Self::default()
        };
        let places = sample.u.get(..sample.count).unwrap_or_default();
        let n = sample.count.max(1) as f32;
        let mean = places.iter().sum::<f32>() / n;
        let squares: f32 = places.iter().map(|u| (u - mean) * (u - mean)).sum();
        let spread = squares.max(f32::MIN_POSITIVE);
        for group in 0..CHANNELS_MAX / 4 {
            let first = sample.values[0].as_chunks::<4>().0[group];
            let [mut sum, mut moment, mut square] = [[0.0; 4]; 3];
            for (values, u) in sample.values.iter().zip(places) {
                let (values, u) = (&values.as_chunks::<4>().0[group], u - mean);
                for k in 0..4 {
                    let value = values[k] - first[k];
                    sum[k] += value;
                    moment[k] += u * value;
                    square[k] += value * value;
                }
            }
            for k in 0..4 {
                let c = 4 * group + k;
                let slope = moment[k] / spread;
                let level = sum[k] / n - slope * mean;
                let left = square[k] - sum[k] * sum[k] / n - slope * slope * spread;
                let is_fitted = wanted >> c & 1 == 1 && square[k] > 0.0 && left.is_finite();
                if !is_fitted {
                    continue;
                }
                let scale = square_root((left / n).max(ROUNDING * square[k] / n));
                reference.level[c] = first[k] + level;
                reference.inverse[c] = 1.0 / scale;
                reference.rounding[c] = span.quantization_step * span.quantization_step / 12.0;
                reference.width += 1;
            }
        }
        Ok(reference)
    }

    /// Sets channels that are not fitted to 0.
    pub fn clear(&self, values: &mut Values) {
        for (value, inverse) in values.iter_mut().zip(&self.inverse) {
            if *inverse <= 0.0 {
                *value = 0.0;
            }
        }
    }
}
