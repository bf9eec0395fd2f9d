//! A start under load: the level that was taken for idle is that of a finger that rests on
//! something.
//!
//! A contact reaches its load at once and stays away from idle. A slide moves about its mean and
//! passes the level before it again and again: a sine is off its mean by at most the root of two of
//! its standard deviations. A slow contact presses all taxels alike, so the levels follow a
//! straight path; a slide moves each taxel with its own phase.

use crate::touch::chi_square::{along, distance};
use crate::touch::onset::Frames;
use crate::touch::values::greater;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Frames after the first touch within which a contact is at its load: 33 ms.
const EARLY_FRAMES: u32 = 8;
/// Frames after which little is left of a spike: 100 ms; and end of the frames that show if the
/// levels move on after it.
const LATE_FRAMES: (u32, u32) = (24, 48);
/// Approximate number of frames to examine: more would take too long.
const LOOKED_AT: u32 = 40;
/// Squared fraction of the later distance that a contact has at once, as has a tone above 10 Hz.
const AT_ONCE: f32 = 0.5;
/// Squared distance from a motion's mean, over the motion's mean square, beyond which a level does
/// not belong to the motion. A sine has at most 2.
const BESIDE_MOTION: f32 = 4.0;
/// Fraction of a slow motion's mean square that is not along one direction: a gentle contact
/// presses all taxels alike, and a slide takes each by its own phase.
const BENT: f32 = 0.2;
/// Minimum fraction of a motion's mean square in the motion's first half.
const GOES_ON: f32 = 0.1;
/// Squared ratio of a contact's highest frame to the later ones that is a spike: only a contact has
/// one.
const SPIKED: f32 = 1.5;
/// Frames after which a motion that began slowly is judged, if it is not still before: 1 s.
const JUDGED_AFTER: u32 = 241;

/// Mean of a motion, and its squares about the mean.
#[derive(Clone, Debug)]
pub struct Moments {
    mean: Values,
    squares: f32,
    frames: f32,
}

impl Moments {
    const fn new() -> Self {
        Self {
            mean: [0.0; TAXELS],
            squares: 0.0,
            frames: 0.0,
        }
    }

    /// Takes a frame (Welford's method).
    fn add(&mut self, values: &Values, weights: &Values) {
        self.frames += 1.0;
        let fraction = 1.0 / self.frames;
        for c in 0..TAXELS {
            let off = values[c] - self.mean[c];
            self.mean[c] += off * fraction;
            self.squares += off * (values[c] - self.mean[c]) * weights[c];
        }
    }

    /// Mean square about the mean, less that of the noise.
    fn spread(&self, taxels: f32) -> f32 {
        self.squares / greater(self.frames, 1.0) - taxels
    }
}

/// Level in the air, as far as it is known.
#[derive(Clone, Debug)]
pub enum Air {
    /// The idle level is known. The value is the level before the latest touch, to which the skin
    /// creeps back.
    Known(Option<Values>),
    /// The finger was on something when the detector began. Holds the statistics of its slides.
    Unknown(Moments),
}

impl Air {
    pub const fn is_known(&self) -> bool {
        matches!(self, Self::Known(_))
    }

    /// Takes a frame of a slide.
    pub fn follow_slide(&mut self, values: &Values, weights: &Values) {
        if let Self::Unknown(moments) = self {
            moments.add(values, weights);
        }
    }

    /// True if the finger has left the levels of its slides.
    pub fn is_left(&self, level: &Values, weights: &Values, taxels: f32) -> bool {
        let Self::Unknown(slides) = self else {
            return false;
        };
        let max = BESIDE_MOTION * greater(slides.spread(taxels), taxels);
        slides.frames > 0.0 && distance(weights, level, &slides.mean) > max
    }
}

/// Verdict on a change from the first level.
#[derive(Clone, Debug)]
pub enum Judged {
    /// A contact; with a spike it is sure that the finger was in the air before.
    Contact { has_spike: bool },
    /// A slide of a finger that was loaded before, with its moments so far.
    Slide(Moments),
    /// A slow motion, which goes on.
    Unclear,
}

/// Calls `take` with the frames to examine, of the `all` frames from `first` on.
fn look_at(frames: &Frames, first: u32, all: u32, take: &mut dyn FnMut(u32, &Values)) {
    let every = all / LOOKED_AT + 1;
    let mut buffer = [0.0; TAXELS];
    for at in (0..=all).filter(|at| *at < EARLY_FRAMES || at.is_multiple_of(every)) {
        if let Some(values) = frames.values(first.wrapping_add(at), &mut buffer) {
            take(at, values);
        }
    }
}

/// Judges the change from `level` in the frames from `first` to `last`.
pub fn judge(frames: &Frames, level: &Values, first: u32, last: u32, is_still: bool) -> Judged {
    let (weights, taxels) = (frames.motion.weights(), frames.motion.taxels.count);
    let all = last.wrapping_sub(first);
    let is_short = all < 2 * LATE_FRAMES.0;
    let (from, until) = if is_short {
        (all / 2, all)
    } else {
        LATE_FRAMES
    };
    let (mut late, mut half, mut early) = (Moments::new(), Moments::new(), 0.0);
    look_at(frames, first, all, &mut |at, values| {
        if at < EARLY_FRAMES {
            early = greater(early, distance(weights, values, level) - taxels);
        }
        if at >= from {
            late.add(values, weights);
            if at < until {
                half.add(values, weights);
            }
        }
    });
    let (off, spread) = (distance(weights, &late.mean, level), late.spread(taxels));
    if early > AT_ONCE * (off + spread) {
        let moves = off < BESIDE_MOTION * spread && half.spread(taxels) > GOES_ON * spread;
        let has_spike = early > SPIKED * (off + spread);
        return if moves {
            Judged::Slide(late)
        } else {
            Judged::Contact { has_spike }
        };
    }
    if all < JUDGED_AFTER && !is_still {
        return Judged::Unclear;
    }
    // The part of the motion that is along the way from the level to its mean.
    let way = core::array::from_fn(|c| (late.mean[c] - level[c]) * weights[c]);
    let (mut squares, mut count) = (0.0, 0.0);
    look_at(frames, first, all, &mut |at, values| {
        if at >= from {
            let off = along(&way, &late.mean, values);
            (squares, count) = (squares + off * off, count + 1.0);
        }
    });
    let straight = squares / greater(count * off, 1.0) - 1.0;
    if spread - straight > BENT * spread {
        Judged::Slide(late)
    } else {
        Judged::Contact { has_spike: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the definition, in f64.
    #[test]
    fn moments_have_the_mean_and_the_mean_square_of_their_frames() {
        let value = |n: u16, c: usize| f32::from((n * 37 + 11 * c as u16) % 101) + f32::from(n);
        let weights: Values = core::array::from_fn(|c| 1.0 + c as f32);
        let mut moments = Moments::new();
        (0..50).for_each(|n| moments.add(&core::array::from_fn(|c| value(n, c)), &weights));
        let mut spread = -16.0;
        for c in 0..TAXELS {
            let values = (0..50).map(|n| f64::from(value(n, c)));
            let mean = values.clone().sum::<f64>() / 50.0;
            assert!((f64::from(moments.mean[c]) - mean).abs() < 1e-3, "{c}");
            let square = values.map(|value| (value - mean).powi(2)).sum::<f64>();
            spread += f64::from(weights[c]) * square / 50.0;
        }
        assert!((f64::from(moments.spread(16.0)) / spread - 1.0).abs() < 1e-4);
    }
}
