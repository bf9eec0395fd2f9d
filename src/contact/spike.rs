//! The contact spike: the paper's equations 2 and 3.

use super::{Change, ContactDetector, Phase, Sought, back_at_idle};
use crate::motion::{BLOCK_FRAMES, Motion};
use crate::settings::{FRAME_RATE_HZ, SlideRule, TAXELS};
use crate::window::{Ring, Values, reached};

/// Frames after a peak in which any higher frame is a better one: 20 ms.
const PEAK_FRAMES: u32 = 5;
/// Standard deviations by which a later one must be higher.
const CLEAR: f32 = 4.0;
/// Squared height of a spike, in units of the noise, from which a tap that leaves no load is told: 30
/// standard deviations in every taxel. Less is a vibration.
const TAP: f32 = 16.0 * 900.0;
/// Frames before the block of the first touch where the spike may have begun.
const LOOK_BACK: u32 = 4;

/// The highest deviation of every taxel so far.
#[derive(Clone, Debug)]
pub(super) struct Spike {
    /// That deviation from the idle level, codes.
    pub peak: Values,
    /// Its frame.
    pub frame: [u32; TAXELS],
    /// Frame that is looked at next.
    next: u32,
}

impl Spike {
    /// None.
    pub const fn new() -> Self {
        Self { peak: [0.0; TAXELS], frame: [0; TAXELS], next: 0 }
    }

    /// Looks from just before the block that ends with frame `number` on.
    pub fn begin(&mut self, number: u32) {
        self.peak = [0.0; TAXELS];
        self.next = number.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK);
        self.frame = [self.next; TAXELS];
    }

    /// Equation 3, for every taxel at once, in the next `frames` frames up to frame `until`.
    #[inline(never)]
    pub fn track(&mut self, frames: u32, until: u32, idle: &Values, motion: &Motion, ring: &Ring) {
        for _ in 0..frames {
            let number = self.next;
            if !reached(until, number) {
                return;
            }
            self.next = number.wrapping_add(1);
            let Some((values, _)) = ring.frame(number) else { continue };
            for c in 0..TAXELS {
                let off = values[c] - idle[c];
                let higher = off.abs() - self.peak[c].abs();
                if higher > 0.0 {
                    // A touch without a spike is a step, whose highest frame is any: long after a peak only
                    // what stands clear of the noise is a higher one.
                    let late = number.wrapping_sub(self.frame[c]) > PEAK_FRAMES;
                    if !late || higher * higher > CLEAR * CLEAR * motion.variance(c) {
                        self.peak[c] = off;
                        self.frame[c] = number;
                    }
                }
            }
        }
    }

    /// Equation 2: the taxel with the best defined spike.
    pub fn best(&self) -> usize {
        let mut best = 0;
        for c in 1..TAXELS {
            if self.peak[c].abs() > self.peak[best].abs() {
                best = c;
            }
        }
        best
    }
}

impl ContactDetector {
    /// The first touch was in the block that ends with frame `number`.
    #[inline(never)]
    pub(super) fn begin_spike(&mut self, number: u32) {
        self.enter(Phase::Spike(number));
        self.spike.begin(number);
    }

    /// The taxel with the best defined spike tells the time, unless there was no touch.
    #[inline(never)]
    pub(super) fn end_spike(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.spike.track(u32::MAX, self.block_end, &self.idle, &self.motion, ring);
        let best = self.spike.best();
        let peak_height = self.motion.distance(&self.spike.peak, &[0.0; TAXELS]);
        let off_again = back_at_idle(self.motion.distance(&self.loaded, &self.idle), peak_height);
        if off_again && peak_height < TAP {
            self.enter(Phase::Idle);
            return;
        }
        let frame = self.spike.frame[best];
        self.touched = frame;
        self.planned = match self.rule {
            SlideRule::Found => None,
            SlideRule::Protocol { delay_s, speed_mm_s, length_mm } => {
                let start = frame.wrapping_add((delay_s * FRAME_RATE_HZ + 0.5) as u32);
                Some((start, start.wrapping_add((length_mm / speed_mm_s * FRAME_RATE_HZ + 0.5) as u32)))
            }
        };
        self.tell(Change::Contact { frame, taxel: best as u8, height: self.spike.peak[best] }, ring, changed);
        self.enter(Phase::Hold);
        if off_again {
            self.release(self.loaded);
            self.date(Sought::Release, self.idle, number, ring, changed);
        }
    }
}
