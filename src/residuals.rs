//! What models leave of the channels, sample by sample.

use crate::levels::Levels;
use crate::moments::{BLOCK, Block, HARMONICS_MAX, Stretch};
use crate::settings::TAXELS;
use crate::waves::{Oscillator, Waves};
use crate::window::{FrameSource, Values};

/// What a channel's model is made of: offset, slope, and per harmonic the factors of cosine and sine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Model {
    /// Offset beyond [`Levels::offset`].
    pub offset: f32,
    /// Slope per unit of `u`.
    pub slope: f32,
    /// Factors of cos(h theta).
    pub cos: [f32; HARMONICS_MAX],
    /// Factors of sin(h theta).
    pub sin: [f32; HARMONICS_MAX],
}

/// Sums of squares of what models leave of each channel, taken sample by sample: the difference of
/// two sums of squares would drown a small residual in rounding. None if the frames were overwritten.
pub fn residuals<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
    models: &[Model; TAXELS],
) -> Option<Values> {
    let oscillator = Oscillator::new(stretch, nu, harmonics.clamp(1, HARMONICS_MAX));
    let mut waves = Waves::new();
    let mut sums = [0f32; TAXELS];
    stretch.blocks(|block| {
        oscillator.fill(&block, &mut waves);
        add_residuals(&block, &waves, levels, oscillator.harmonics, models, &mut sums);
    })?;
    Some(sums)
}

/// One block further; on its own, so that there is one copy of it for all kinds of sources.
#[inline(never)]
fn add_residuals(
    block: &Block,
    waves: &Waves,
    levels: &Levels,
    harmonics: usize,
    models: &[Model; TAXELS],
    sums: &mut Values,
) {
    for (c, model) in models.iter().enumerate() {
        if levels.usable & 1 << c == 0 {
            continue;
        }
        let zero = levels.offset[c] + model.offset;
        let mut rest = [0.0; BLOCK];
        for i in 0..BLOCK {
            rest[i] = block.values[i][c] - zero - model.slope * waves.u[i];
        }
        for h in 0..harmonics {
            let (cos, sin) = (model.cos[h], model.sin[h]);
            for i in 0..BLOCK {
                rest[i] -= cos * waves.cos[h][i] + sin * waves.sin[h][i];
            }
        }
        let mut part = 0.0;
        for i in 0..BLOCK {
            if block.valid[i] != 0 {
                part += rest[i] * rest[i];
            }
        }
        sums[c] += part;
    }
}
