//! The line through the times of the zero crossings, by channel; the median of the channels.
//!
//! Friedman, "A zero crossing algorithm for the estimation of the frequency of a single sinusoid in
//! white noise", IEEE Trans. Signal Process. 42(6), 1994: crossings between two samples by linear
//! interpolation, the period by least squares through all of them. Noise makes several crossings
//! where there is one: they count as one, in their middle, until the signal has left the hysteresis
//! at the other side.

use super::samples::{CHANNELS, Frame, Scratch, centred, rms};

/// Hysteresis to either side of zero, in root mean squares of the channel: half a sine's amplitude.
/// With less of it the noise crosses too often at 10 dB, with more the overtones hide crossings.
const HYSTERESIS: f32 = 0.7;

/// The frequency, cycles per frame: the median of the channels that have two crossings at least.
/// The mean would be at the mercy of the weakest channel, whose noise makes crossings of its own.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let (mut half_periods, mut count) = ([0.0; CHANNELS], 0);
    for channel in 0..channels {
        let Some(points) = centred(values, channel, &mut scratch.points) else {
            continue;
        };
        if let (Some(found), Some(place)) = (half_period(points), half_periods.get_mut(count)) {
            *place = found;
            count += 1;
        }
    }
    let found = half_periods.get_mut(..count)?;
    found.sort_unstable_by(f32::total_cmp);
    let (below, above) = (found.get(count.checked_sub(1)? / 2)?, found.get(count / 2)?);
    Some(1.0 / (below + above))
}

/// From one crossing to the next, frames.
fn half_period(points: &[f32]) -> Option<f32> {
    let level = HYSTERESIS * rms(points);
    let mut lines = [CrossingSums::default(); 2];
    let mut both = CrossingSums::default();
    let mut number = 0;
    // Where the signal was when it was last beyond the hysteresis.
    let mut was_above = None;
    let (mut before, mut first, mut last) = (0.0, None, 0.0);
    for (k, &point) in points.iter().enumerate() {
        if k > 0 && (point < 0.0) != (before < 0.0) {
            last = k as f32 - point / (point - before);
            first = first.or(Some(last));
        }
        before = point;
        if point.abs() < level {
            continue;
        }
        let above = point > 0.0;
        if let Some(first) = first.take()
            && was_above == Some(!above)
        {
            let at = 0.5 * (first + last);
            both.add(number as f32, at);
            if let Some(line) = lines.get_mut(number % 2) {
                line.add(number as f32, at);
            }
            number += 1;
        }
        was_above = Some(above);
    }
    // Where a wave is longer above zero than below, rising and falling crossings are two parallel
    // lines.
    let [rising, falling] = lines.map(CrossingSums::spread);
    let (square, product) = (rising.0 + falling.0, rising.1 + falling.1);
    let (square, product) = if square > 0.0 {
        (square, product)
    } else {
        both.spread()
    };
    (square > 0.0 && product > 0.0).then(|| product / square)
}

/// Sums over crossings: of ones, numbers, times, squares and products.
#[derive(Clone, Copy, Debug, Default)]
struct CrossingSums {
    count: f32,
    number: f32,
    time: f32,
    square: f32,
    product: f32,
}

impl CrossingSums {
    fn add(&mut self, number: f32, time: f32) {
        self.count += 1.0;
        self.number += number;
        self.time += time;
        self.square += number * number;
        self.product += number * time;
    }

    /// Square of the numbers' spread about their mean, and product of theirs and the times'.
    fn spread(self) -> (f32, f32) {
        let mean = if self.count > 0.0 {
            self.number / self.count
        } else {
            0.0
        };
        (
            self.square - mean * self.number,
            self.product - mean * self.time,
        )
    }
}
