//! The contact spike: the paper's equations 2 and 3.

use super::{Change, ContactDetector, Phase};
use crate::ring::{Ring, reached};
use crate::touch::motion::{BLOCK_FRAMES, SHARE, SHARES, distance, share, share_mut};
use ridgetone_proto::settings::{FRAME_RATE_HZ, SlideRule, TAXELS};
use ridgetone_tone::Values;

/// Frames after a peak in which any higher frame is a better one: 20 ms.
const PEAK_FRAMES: u32 = 5;
/// Standard deviations by which a later one must be higher.
const CLEAR: f32 = 4.0;
/// Squared height of a spike, in units of the noise, from which a tap that leaves no load is told: 30
/// standard deviations in every taxel. Less is a vibration.
const TAP: f32 = 16.0 * 900.0;
/// Frames before the block of the first touch where the spike may have begun.
const LOOK_BACK: u32 = 4;
/// Frames that are looked at while a block is evaluated: one more than come, for a touch is noticed late.
const LOOKS: u32 = BLOCK_FRAMES + 1;

/// The highest deviation of every taxel so far.
#[derive(Clone, Debug)]
pub(super) struct Spike {
    /// That deviation from the idle level, codes.
    peak: Values,
    /// Its frame.
    frame: [u32; TAXELS],
    /// Frame that is looked at next, for each share of the taxels.
    next: [u32; SHARES],
    /// Whether nothing is known of it yet but the block of the first touch.
    new: bool,
    /// Squared length of all the peaks in units of the noise, as far as it is summed up.
    pub height: f32,
    /// Equation 2: the taxel with the best defined spike, of those that are summed up.
    best: usize,
}

impl Spike {
    /// None.
    pub const fn new() -> Self {
        Self { peak: [0.0; TAXELS], frame: [0; TAXELS], next: [0; SHARES], new: false, height: 0.0, best: 0 }
    }

    /// Too low for a tap that leaves no load.
    pub fn is_faint(&self) -> bool {
        self.height < TAP
    }

    /// One share of the taxels is looked at from frame `first` on.
    fn begin(&mut self, turn: usize, first: u32) {
        *share_mut(&mut self.peak, turn) = [0.0; SHARE];
        *share_mut(&mut self.frame, turn) = [first; SHARE];
        self.next[turn % SHARES] = first;
    }

    /// Equation 3 for one share of the taxels, in the next `frames` frames up to frame `until`.
    fn track(&mut self, turn: usize, frames: u32, until: u32, idle: &Values, weights: &Values, ring: &Ring) {
        let (idle, weights, next) = (*share(idle, turn), share(weights, turn), &mut self.next[turn % SHARES]);
        let (peak, at) = (share_mut(&mut self.peak, turn), share_mut(&mut self.frame, turn));
        let mut highest = peak.map(f32::abs);
        let mut look = |values: &[f32; SHARE], number: u32| {
            for c in 0..SHARE {
                let off = values[c] - idle[c];
                if off.abs() > highest[c] {
                    let higher = off.abs() - highest[c];
                    // A touch without a spike is a step, whose highest frame is any: long after a peak only
                    // what stands clear of the noise is a higher one.
                    let late = number.wrapping_sub(at[c]) > PEAK_FRAMES;
                    if !late || higher * higher * weights[c] > CLEAR * CLEAR {
                        highest[c] = off.abs();
                        (peak[c], at[c]) = (off, number);
                    }
                }
            }
        };
        let mut left = frames;
        // Once more where the ring's end is among them.
        while left > 0 && reached(until, *next) {
            let first = *next;
            let most = left.min(until.wrapping_sub(first).wrapping_add(1));
            let read = ring.read(first, most as usize, |values, valid| {
                for ((values, valid), number) in values.iter().zip(valid).zip(0..) {
                    if *valid != 0 {
                        look(share(values, turn), first.wrapping_add(number));
                    }
                }
                values.len() as u32
            });
            // What the ring has lost is passed over.
            let read = read.unwrap_or(1);
            *next = first.wrapping_add(read);
            left -= read;
        }
    }

    /// Sums up one share of the peaks, each after the one before it.
    fn sum_up(&mut self, turn: usize, weights: &Values) {
        let (peak, weights) = (share(&self.peak, turn), share(weights, turn));
        for c in 0..SHARE {
            self.height += peak[c] * peak[c] * weights[c];
            if peak[c].abs() > self.peak[self.best % TAXELS].abs() {
                self.best = turn * SHARE + c;
            }
        }
    }
}

impl ContactDetector {
    /// The first touch was in the block that ends with frame `number`.
    #[inline(never)]
    pub(super) fn begin_spike(&mut self, number: u32) {
        self.enter(Phase::Spike(number));
        (self.spike.new, self.spike.height, self.spike.best) = (true, 0.0, 0);
        self.crept = 0.0;
    }

    /// Follows the spike in one share of the taxels; the first touch was in the block that ends with frame `since`.
    #[inline(never)]
    pub(super) fn follow_spike(&mut self, turn: usize, since: u32, ring: &Ring) {
        let weights = self.motion.weights();
        // While it rises it is work enough.
        let rises = self.block_end.wrapping_sub(since) <= 2 * BLOCK_FRAMES;
        let looks = if rises { BLOCK_FRAMES } else { LOOKS };
        if self.spike.new {
            self.spike.begin(turn, since.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK));
            self.spike.new = turn + 1 < SHARES;
            if let Some(before) = &self.before {
                let weights = share(weights, turn);
                let (mean, idle) = (share(self.motion.mean(), turn), share(&self.idle, turn));
                let before = share(before, turn);
                self.crept += distance(weights, mean, before) - distance(weights, idle, before);
            }
        }
        self.spike.track(turn, looks, self.block_end, &self.idle, weights, ring);
    }

    /// Looks at what is left of one share of the spike up to frame `over`, and sums it up.
    #[inline(never)]
    pub(super) fn sum_up_spike(&mut self, turn: usize, over: u32, ring: &Ring) {
        let weights = self.motion.weights();
        self.spike.track(turn, u32::MAX, over, &self.idle, weights, ring);
        self.spike.sum_up(turn, weights);
    }

    /// The taxel with the best defined spike tells the time.
    #[inline(never)]
    pub(super) fn tell_contact(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        let best = self.spike.best % TAXELS;
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
    }
}
