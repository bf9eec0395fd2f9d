//! Cosine and sine at every frame of a window by rotation: four multiplications each.

use ridgetone_tone::phase::{cos_sin, from_turns};

/// A window's frames seen at one frequency, time counted from the middle of the window.
///
/// Its error grows by a rounding per frame: 3e-5 after 241 frames, 1e-4 after 1024.
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    first: (f32, f32),
    step: (f32, f32),
}

impl Rotation {
    /// At `frequency`, cycles per frame, over `frames` frames.
    pub fn new(frequency: f32, frames: usize) -> Self {
        Self::delayed(frequency, frames, 0.0)
    }

    /// Later by `cycles` cycles than [`Self::new`].
    pub fn delayed(frequency: f32, frames: usize, cycles: f32) -> Self {
        let step = from_turns(frequency);
        // In whole numbers: a product of floats would be off by a rounding of all its turns.
        let to_middle = (u64::from(step) * (frames as u64).saturating_sub(1) / 2) as u32;
        let first = from_turns(-cycles).wrapping_sub(to_middle);
        Self {
            first: cos_sin(first),
            step: cos_sin(step),
        }
    }

    /// Cosine and sine, frame by frame, without end.
    pub fn iter(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        let ((cos, sin), mut now) = (self.step, self.first);
        core::iter::repeat_with(move || {
            let (c, s) = now;
            now = (c * cos - s * sin, s * cos + c * sin);
            (c, s)
        })
    }

    /// Sums of the points times cosine and sine: the transform at this frequency is the first less
    /// i times the second.
    pub fn project(&self, points: &[f32]) -> (f32, f32) {
        let (mut along_cos, mut along_sin) = (0.0, 0.0);
        for (point, (cos, sin)) in points.iter().zip(self.iter()) {
            along_cos += point * cos;
            along_sin += point * sin;
        }
        (along_cos, along_sin)
    }
}

/// The middle of a window, in frames from its first one.
pub fn middle(frames: usize) -> f32 {
    0.5 * (frames as f32 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    extern crate std;

    #[test]
    fn agrees_with_f64_to_the_end_of_the_window() {
        for (frames, most) in [(241, 3e-5), (1024, 1e-4)] {
            let mut worst = 0f64;
            for k in 1..500 {
                let frequency = k as f32 * 1e-3;
                let rotation = Rotation::delayed(frequency, frames, 0.3);
                for (n, (cos, sin)) in rotation.iter().take(frames).enumerate() {
                    let time = n as f64 - 0.5 * (frames as f64 - 1.0);
                    let (s, c) =
                        (TAU * (f64::from(frequency) * time - f64::from(0.3f32))).sin_cos();
                    worst = worst.max((f64::from(cos) - c).hypot(f64::from(sin) - s));
                }
            }
            assert!(worst < most, "{frames} frames: {worst:e}");
        }
    }
}
