//! The highest line of the periodogram, summed over channels.
//!
//! Where channels share one frequency and the noise is the same in all of them, the maximum of the
//! summed periodogram is near the maximum of the likelihood (Rife and Boorstyn, "Single-tone
//! parameter estimation from discrete-time observations", IEEE Trans. Inf. Theory 20(5), 1974). The
//! transform is padded with zeros to the next power of two, no further: a line's distance to the
//! next is the error's limit.

use super::samples::{FRAMES_MAX, Frame, Scratch, centred};

/// Shortest transform, points.
const POINTS_MIN: usize = 16;

/// The line that stands highest, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let peak = Peak::find(values, channels, scratch)?;
    Some(peak.frequency(0.0))
}

/// The highest line and its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Its number; at least 1.
    line: usize,
    points: usize,
    /// Power of the line below, of the highest, and of the one above.
    pub power: [f32; 3],
}

impl Peak {
    /// Finds the peak of the first `channels` channels.
    pub(crate) fn find(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<Self> {
        let size = values.len().next_power_of_two().max(POINTS_MIN);
        let power = scratch.power.get_mut(..size / 2)?;
        power.fill(0.0);
        for channel in 0..channels {
            if centred(values, channel, &mut scratch.points).is_none() {
                continue;
            }
            let transform = scratch.points.get_mut(..size)?;
            transform.get_mut(values.len()..)?.fill(0.0);
            for (power, bin) in power.iter_mut().zip(lines(transform)?).skip(1) {
                *power += bin.re * bin.re + bin.im * bin.im;
            }
        }
        let (mut line, mut highest) = (0, 0.0);
        for (k, power) in power.iter().enumerate() {
            if *power > highest {
                (line, highest) = (k, *power);
            }
        }
        // Line 0 is the mean, which has been taken off.
        let below = *power.get(line.checked_sub(1)?)?;
        let above = power.get(line + 1).copied().unwrap_or(0.0);
        Some(Self {
            line,
            points: size,
            power: [below, highest, above],
        })
    }

    /// Frequency of a place `lines_above` lines above the highest, cycles per frame.
    pub fn frequency(&self, lines_above: f32) -> f32 {
        (self.line as f32 + lines_above) / self.points as f32
    }
}

/// Transforms in place. None if the length is not a transform's.
fn lines(points: &mut [f32]) -> Option<&[microfft::Complex32]> {
    macro_rules! transform {
        ($($length:literal $name:ident),*) => {
            match points.len() {
                $($length => Some(&*microfft::real::$name(points.try_into().ok()?)),)*
                _ => None,
            }
        };
    }
    const { assert!(FRAMES_MAX == 1024, "the longest transform") };
    transform!(16 rfft_16, 32 rfft_32, 64 rfft_64, 128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024)
}
