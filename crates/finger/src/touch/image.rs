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

/// The image of a hold, beside the level before the touch and the frames that this level is the
/// mean of. `weights` are one over the variance of each taxel's frames. The mean over the hold
/// began and ended at `span_us`, device time in microseconds, and has `frames` frames.
pub fn image(
    (held, frames): (&HeldLevel, u32),
    (idle, idle_frames): (&Values, f32),
    weights: &Values,
    volts_per_code: f32,
    (start_us, end_us): (u64, u64),
) -> Image {
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
