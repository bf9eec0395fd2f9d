//! A channel's samples, less their mean.

pub const CHANNELS: usize = 16;

/// One frame's values, codes: whole numbers up to 2^24, offsets included.
pub type Frame = [f32; CHANNELS];

/// Most frames of a window, and points of the longest transform.
pub const FRAMES_MAX: usize = 1024;

#[derive(Clone, Debug)]
pub struct Scratch {
    /// A channel's samples, or their transform.
    pub points: [f32; FRAMES_MAX],
    /// A second channel's samples.
    pub second: [f32; FRAMES_MAX],
    /// The periodogram, summed over channels.
    pub power: [f32; FRAMES_MAX / 2],
}

impl Scratch {
    pub const EMPTY: Self = Self {
        points: [0.0; FRAMES_MAX],
        second: [0.0; FRAMES_MAX],
        power: [0.0; FRAMES_MAX / 2],
    };
}

/// Fewest frames of a window: below four a sine with an offset is not determined.
const FRAMES_MIN: usize = 4;

/// Writes the samples of a channel, less their mean, to the front of `points` and gives them.
///
/// None if the channel does not vary, if a value is not finite, or if there are too few or too many
/// frames.
pub fn centred<'a>(
    values: &[Frame],
    channel: usize,
    points: &'a mut [f32],
) -> Option<&'a mut [f32]> {
    if !(FRAMES_MIN..=FRAMES_MAX).contains(&values.len()) {
        return None;
    }
    // Codes are whole numbers: their differences are exact where their sum would not be.
    let first = *values.first()?.get(channel)?;
    let points = points.get_mut(..values.len())?;
    let mut sum = 0.0;
    for (point, frame) in points.iter_mut().zip(values) {
        *point = *frame.get(channel)? - first;
        sum += *point;
    }
    let mean = sum / values.len() as f32;
    let mut power = 0.0;
    for point in points.iter_mut() {
        *point -= mean;
        power += *point * *point;
    }
    (power > 0.0 && power.is_finite()).then_some(points)
}
