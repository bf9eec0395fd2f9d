//! Pressure map of a hold.

use crate::touch::change::HoldMean;
use heapless::Vec;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Image, Pressed};

/// Variance of a taxel's frames below which it has no noise, squared codes: a tenth more than that
/// of rounding (1/12), which is the minimum that the detector takes for noise.
const DEAD_VARIANCE: f32 = 1.1 / 12.0;

/// True if a taxel has neither changed since the touch began (`pressed`, codes above the level
/// before) nor any noise (`variance` of its frames).
fn is_dead(pressed: f32, variance: f32) -> bool {
    pressed.abs() < 1.0 && variance < DEAD_VARIANCE
}

/// Pressure map of a hold, relative to the level before the touch. The mean of the hold began and
/// ended at these device times, microseconds.
pub fn image(hold: &HoldMean<'_>, start_us: u64, end_us: u64, volts_per_code: f32) -> Image {
    let of_mean = 1.0 / hold.frames as f32 + 1.0 / hold.idle_frames;
    let mut taxels = Vec::new();
    for c in 0..TAXELS {
        let pressed = hold.held.level[c] - hold.idle[c];
        let variance = 1.0 / hold.weights[c];
        if hold.held.good >> c & 1 == 1 && !is_dead(pressed, variance) {
            // There is space for every taxel.
            let _ = taxels.push(Pressed {
                taxel: c as u8,
                level_v: pressed * volts_per_code,
                sigma_v: ridgetone_tone::sqrt(variance * of_mean) * volts_per_code,
            });
        }
    }
    Image {
        start_us,
        end_us,
        frames: hold.frames,
        hold: hold.held.hold,
        taxels,
    }
}
