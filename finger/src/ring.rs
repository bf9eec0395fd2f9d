//! The latest frames in a fixed buffer, and how the fit reads them.
//!
//! A window of the paper's longest slide holds 62 kB. So there is one ring, windows overlap in it, and they name their
//! frames by number. The fit reads a short block at a time. On the chip it does so behind a lock that lasts for one block,
//! so that higher tasks wait for microseconds only. A reader learns which frames were overwritten.

use ridgetone_proto::settings::{RING_FRAMES, TAXELS};
use ridgetone_tone::{FrameSource, Overwritten, Values};

/// Whether frame `number` is frame `mark` or a later one. The numbers wrap, so the two must be less than half their range
/// apart: 103 days at 241 Hz.
pub const fn reached(number: u32, mark: u32) -> bool {
    number.wrapping_sub(mark) as i32 >= 0
}

/// The latest [`RING_FRAMES`] frames.
#[derive(Debug)]
pub struct Ring {
    values: [Values; RING_FRAMES],
    valid: [u16; RING_FRAMES],
    t_us: [u32; RING_FRAMES],
    /// Place in the arrays that is written next. It does not follow from the number: 2^32 is no multiple of the ring's
    /// length.
    head: usize,
    /// Number of the frame that is written next.
    next: u32,
    /// Frames that are there, at most [`RING_FRAMES`].
    filled: u32,
}

impl Ring {
    /// An empty ring; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self {
            values: [[0.0; TAXELS]; RING_FRAMES],
            valid: [0; RING_FRAMES],
            t_us: [0; RING_FRAMES],
            head: 0,
            next: 0,
            filled: 0,
        }
    }

    /// Number of the frame that is written next.
    pub const fn next(&self) -> u32 {
        self.next
    }

    /// Number of the oldest frame that is there.
    pub const fn oldest(&self) -> u32 {
        self.next.wrapping_sub(self.filled)
    }

    /// Empties the ring; the next frame written gets `number`.
    pub fn restart(&mut self, number: u32) {
        self.next = number;
        self.filled = 0;
        // The sums over a window round differently where the ring's end cuts a block. From the start, results do not
        // depend on what was there before.
        self.head = 0;
    }

    /// Writes the next frame: values, mask of valid taxels, and the time of its first slot (low 32 bits of the device time
    /// in microseconds).
    pub fn push(&mut self, values: &Values, valid: u16, t_us: u32) {
        let at = self.head;
        if let (Some(v), Some(m), Some(t)) = (self.values.get_mut(at), self.valid.get_mut(at), self.t_us.get_mut(at)) {
            *v = *values;
            *m = valid;
            *t = t_us;
        }
        self.head = if at + 1 < RING_FRAMES { at + 1 } else { 0 };
        self.next = self.next.wrapping_add(1);
        self.filled = (self.filled + 1).min(RING_FRAMES as u32);
    }

    /// Place of a frame in the arrays, if it is there.
    fn place(&self, number: u32) -> Option<usize> {
        let age = self.next.wrapping_sub(number);
        let back = age as usize;
        // For a frame that is far from those in the ring, as after a gap, this is not a place in the arrays.
        let at = if back <= self.head { self.head - back } else { (self.head + RING_FRAMES).wrapping_sub(back) };
        (age >= 1 && age <= self.filled).then_some(at)
    }

    /// One frame's values and mask, if it is there and has a valid value.
    pub fn frame(&self, number: u32) -> Option<(&Values, u16)> {
        let at = self.place(number)?;
        let valid = *self.valid.get(at)?;
        (valid != 0).then_some((self.values.get(at)?, valid))
    }

    /// Time of a frame's first slot, low 32 bits of the device time in microseconds.
    pub fn t_us(&self, number: u32) -> Option<u32> {
        self.t_us.get(self.place(number)?).copied()
    }

    /// See [`FrameSource::read`].
    pub fn read<R>(&self, first: u32, most: usize, read: impl FnOnce(&[Values], &[u16]) -> R) -> Option<R> {
        let at = self.place(first)?;
        let there = self.next.wrapping_sub(first) as usize;
        let end = at + most.min(there).min(RING_FRAMES - at);
        Some(read(self.values.get(at..end)?, self.valid.get(at..end)?))
    }
}

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameSource for &Ring {
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Result<(), Overwritten> {
        Ring::read(self, first, most, show).ok_or(Overwritten)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::boxed::Box;

    #[test]
    fn frames_are_found_by_number_across_the_wrap_of_both() {
        let mut ring = Box::new(Ring::new());
        let first = u32::MAX - 700;
        ring.restart(first);
        for n in 0..2000u32 {
            ring.push(&[n as f32; TAXELS], 1, n);
        }
        let number = |n: u32| first.wrapping_add(n);
        assert_eq!(ring.oldest(), number(2000 - RING_FRAMES as u32));
        for n in 2000 - RING_FRAMES as u32..2000 {
            assert_eq!(ring.frame(number(n)).map(|(values, _)| values[3]), Some(n as f32));
            assert_eq!(ring.t_us(number(n)), Some(n));
        }
        assert!(ring.frame(number(2000)).is_none());
        assert!(ring.frame(number(2000 - RING_FRAMES as u32 - 1)).is_none());
        let mut read = 0;
        while let Some(shown) = ring.read(number(1200 + read), 16, |values, _| {
            assert!(values.iter().zip(0..).all(|(v, i)| v[0] == (1200 + read + i) as f32));
            values.len() as u32
        }) {
            read += shown;
        }
        assert_eq!(read, 800);
    }

    #[test]
    fn a_ring_that_was_restarted_reads_as_a_new_one() {
        let mut ring = Box::new(Ring::new());
        (0..RING_FRAMES as u32 - 3).for_each(|n| ring.push(&[n as f32; TAXELS], 1, n));
        ring.restart(70);
        assert!(ring.frame(70).is_none() && ring.oldest() == 70);
        (0..16).for_each(|n| ring.push(&[n as f32; TAXELS], 1, n));
        // In one piece: what a window's sums round to does not depend on what was there before.
        assert_eq!(ring.read(70, 16, |values, _| (values.len(), values[15][0])), Some((16, 15.0)));
    }

    #[test]
    fn a_frame_without_a_valid_value_is_not_shown_as_one() {
        let mut ring = Box::new(Ring::new());
        ring.push(&[5.0; TAXELS], 0, 7);
        assert!(ring.frame(0).is_none());
        assert_eq!(ring.t_us(0), Some(7));
    }
}
