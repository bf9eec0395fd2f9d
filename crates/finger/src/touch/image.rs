//! The static image: what a hold does to every taxel.

use crate::touch::held::HeldLevel;
use heapless::Vec;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Image, Pressed};
use ridgetone_tone::Values;

/// A taxel whose frames vary by less than this has no noise, squared codes: a tenth more than
/// rounding makes of any (1/12), which is the least that the detector takes for noise.
const DEAD_VARIANCE: f32 = 1.1 / 12.0;

/// Whether a taxel has neither changed since the touch began nor any noise, by its codes above the
/// level before, and by the variance of its frames.
fn is_dead(pressed: f32, variance: f32) -> bool {
    pressed.abs() < 1.0 && variance < DEAD_VARIANCE
}

/// A hold whose mean is taken.
pub struct HoldMean<'a> {
    pub level: &'a HeldLevel,
    pub frames: u32,
    /// Device time at which the mean began, microseconds.
    pub start_us: u64,
    /// Device time at which the mean ended, microseconds.
    pub end_us: u64,
}

/// The level before a touch.
pub struct IdleMean<'a> {
    pub values: &'a Values,
    /// Number of frames that it is the mean of.
    pub frames: f32,
}

/// The image of a hold, relative to the level before the touch. `weights` are one over the variance
/// of each taxel's frames.
pub fn image(
    hold: HoldMean<'_>,
    idle: IdleMean<'_>,
    weights: &Values,
    volts_per_code: f32,
) -> Image {
    let HoldMean {
        level: held,
        frames,
        start_us,
        end_us,
    } = hold;
    let IdleMean {
        values: idle,
        frames: idle_frames,
    } = idle;
    let of_mean = 1.0 / held.frames() as f32 + 1.0 / idle_frames;
    let mut taxels = Vec::new();
    for c in 0..TAXELS {
        let (pressed, variance) = (held.level[c] - idle[c], 1.0 / weights[c]);
        if held.good >> c & 1 == 1 && !is_dead(pressed, variance) {
            let sigma_v = libm::sqrtf(variance * of_mean) * volts_per_code;
            // There is space for every taxel.
            let _ = taxels.push(Pressed {
                taxel: c as u8,
                level_v: pressed * volts_per_code,
                sigma_v,
            });
        }
    }
    Image {
        start_us,
        end_us,
        frames,
        hold: held.hold,
        taxels,
    }
}
