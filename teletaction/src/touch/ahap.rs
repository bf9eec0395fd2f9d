//! A haptic pattern for Apple's devices (*Representing haptic patterns in AHAP files*): it has
//! intensities and sharpnesses, and no waveform.

use super::hand::Hand;
use super::render::{RATE_HZ, Rendered};
use ridgetone_stimulus::Texture;
use serde_json::{Value, json};

/// Length of an event, seconds: a gap of this length is not felt yet (Okamoto et al., section I: 40
/// to 60 ms).
const EVENT_S: f64 = 0.05;

/// Frequencies of the sharpnesses 0 and 1, hertz. Apple's documents say only "dull" and "sharp":
/// this is a choice.
const SHARPNESS_HZ: (f64, f64) = (80.0, 230.0);

/// Events of 50 ms: the mean amplitude is the intensity, the hand's mean speed over the period is
/// the sharpness.
pub fn pattern(rendered: &Rendered, texture: &Texture, hand: &Hand, delay_s: f64) -> Value {
    let length = (EVENT_S * f64::from(RATE_HZ)) as usize;
    let events = rendered.amplitudes.chunks_exact(length).enumerate().map(|(n, amplitudes)| {
        let begins_s = n as f64 * EVENT_S;
        let place_mm = |t_s: f64| hand.place_mm((t_s - delay_s).max(0.0));
        let speed_mm_s = (place_mm(begins_s + EVENT_S) - place_mm(begins_s)).abs() / EVENT_S;
        let hz = speed_mm_s / f64::from(texture.period_mm);
        let (dull, sharp) = SHARPNESS_HZ;
        let intensity = amplitudes.iter().map(|amplitude| f64::from(*amplitude)).sum::<f64>() / length as f64;
        let parameter = |name: &str, value: f64| {
            json!({"ParameterID": name, "ParameterValue": (1e3 * value.clamp(0.0, 1.0)).round() / 1e3})
        };
        json!({"Event": {
            "Time": (1e3 * begins_s).round() / 1e3,
            "EventType": "HapticContinuous",
            "EventDuration": EVENT_S,
            "EventParameters": [
                parameter("HapticIntensity", intensity),
                parameter("HapticSharpness", (hz - dull) / (sharp - dull)),
            ],
        }})
    });
    json!({"Version": 1.0, "Pattern": events.collect::<Vec<_>>()})
}
