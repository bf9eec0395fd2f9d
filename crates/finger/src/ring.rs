//! The latest frames in a fixed buffer, and their interface to the fit.
//!
//! A window of the paper's longest slide takes 62 kB, so there is a single ring, in which windows
//! overlap and refer to frames by number. The fit reads a short block at a time, on the chip under
//! a lock for each block, so that higher-priority tasks wait for only microseconds. A reader is
//! told if frames were overwritten.

use crate::scan::{Scan, taxels};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{RING_FRAMES, TAXELS};
use ridgetone_tone::{FrameSource, Overwritten, Values};

/// True if frame `number` is frame `mark` or a later one. The numbers wrap, so they must be less
/// than half their range apart: 103 days at 241 Hz, a day at 23.3 kHz.
pub const fn reached(number: u32, mark: u32) -> bool {
    number.wrapping_sub(mark) as i32 >= 0
}

/// The latest frames: [`RING_FRAMES`] rows of a sample for each of sixteen taxels. With fewer
/// taxels several frames share a row, so that the ring holds as many samples
/// ([`Plan::frames_a_row`]).
#[derive(Debug)]
pub struct Ring {
    /// Values by taxel if a row holds one frame; otherwise the taxels of its frames, one after
    /// another.
    values: [Values; RING_FRAMES],
    /// Mask of the valid values of each row.
    valid: [u16; RING_FRAMES],
    /// Device time of each row's first frame, microseconds.
    t_us: [u32; RING_FRAMES],
    /// Position of the next frame in the ring, in frames. It cannot be derived from the frame's
    /// number, because 2^32 is not a multiple of the ring's length.
    head: u32,
    /// Number of the next frame to be written.
    next: u32,
    /// Number of frames in the ring.
    filled: u32,
    /// Capacity in frames.
    frames: u32,
    /// Frames per row.
    in_row: u32,
    /// Mask of the converted taxels, and their number (`channels`).
    inputs: u16,
    channels: u32,
    frame_ns: u32,
}

impl Ring {
    /// Creates an empty ring, for frames of the default plan unless a different one is set before
    /// the first frame. `const` and all zeros, so that it can live in a static without a copy in
    /// flash.
    pub const fn new() -> Self {
        Self {
            values: [[0.0; TAXELS]; RING_FRAMES],
            valid: [0; RING_FRAMES],
            t_us: [0; RING_FRAMES],
            head: 0,
            next: 0,
            filled: 0,
            frames: 0,
            in_row: 0,
            inputs: 0,
            channels: 0,
            frame_ns: 0,
        }
    }

    /// Empties the ring and switches it to frames of this plan. The next frame gets `number`.
    pub fn change(&mut self, plan: &Plan, number: u32) {
        self.frames = plan.ring_frames();
        self.in_row = plan.frames_a_row() as u32;
        (self.inputs, self.channels) = (plan.inputs, plan.channels() as u32);
        self.frame_ns = Scan::new(plan).frame_ns();
        self.restart(number);
    }

    /// Number of the next frame to be written.
    pub const fn next(&self) -> u32 {
        self.next
    }

    /// Number of the oldest frame in the ring.
    pub const fn oldest(&self) -> u32 {
        self.next.wrapping_sub(self.filled)
    }

    /// Capacity in frames.
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Empties the ring; the next frame written gets `number`.
    pub fn restart(&mut self, number: u32) {
        self.next = number;
        self.filled = 0;
        // Start at position 0, so that results do not depend on earlier contents: sums over a
        // window round differently if the ring's end splits a block.
        self.head = 0;
    }

    /// Writes the next frame: values, mask of valid taxels, and the time of its first slot (low 32
    /// bits of the device time in microseconds).
    #[inline]
    pub fn push(&mut self, values: &Values, valid: u16, t_us: u32) {
        if self.in_row == 0 {
            self.change(&Plan::PAPER, self.next);
        }
        let at = self.head;
        if self.in_row == 1 {
            let at = at as usize;
            if let (Some(v), Some(m), Some(t)) = (
                self.values.get_mut(at),
                self.valid.get_mut(at),
                self.t_us.get_mut(at),
            ) {
                *v = *values;
                *m = valid;
                *t = t_us;
            }
        } else {
            self.pack(values, valid, t_us);
        }
        self.head = if at + 1 < self.frames { at + 1 } else { 0 };
        self.next = self.next.wrapping_add(1);
        // The first frame of a shared row replaces all frames that were in the row.
        self.filled = (self.filled + 1).min(self.frames + 1 - self.in_row);
    }

    /// Writes a frame into a shared row.
    fn pack(&mut self, values: &Values, valid: u16, t_us: u32) {
        let (row, place) = (
            (self.head / self.in_row.max(1)) as usize,
            self.head % self.in_row.max(1) * self.channels,
        );
        let (Some(to), Some(mask), Some(t)) = (
            self.values.get_mut(row),
            self.valid.get_mut(row),
            self.t_us.get_mut(row),
        ) else {
            return;
        };
        if place == 0 {
            (*mask, *t) = (0, t_us);
        }
        // Clears the values of the frame that was there before.
        *mask &= ((1u32 << place) - 1) as u16;
        for (taxel, at) in taxels(self.inputs).zip(place as usize..) {
            to[at % TAXELS] = values[taxel];
            *mask |= (valid >> taxel & 1) << (at % TAXELS);
        }
    }

    /// Position of a frame in the ring, if present.
    fn place(&self, number: u32) -> Option<u32> {
        let age = self.next.wrapping_sub(number);
        // For a frame outside the ring, as after a gap, this is not a valid position.
        let at = if age <= self.head {
            self.head - age
        } else {
            (self.head + self.frames).wrapping_sub(age)
        };
        (age >= 1 && age <= self.filled).then_some(at)
    }

    /// Values and mask of a frame, if it is present and has a valid value; `place` is storage for
    /// values that have to be unpacked.
    #[inline]
    pub fn frame<'a>(&'a self, number: u32, place: &'a mut Values) -> Option<(&'a Values, u16)> {
        let at = self.place(number)?;
        if self.in_row > 1 {
            let valid = self.unpack(at, place);
            return (valid != 0).then_some((&*place, valid));
        }
        let valid = *self.valid.get(at as usize)?;
        (valid != 0).then_some((self.values.get(at as usize)?, valid))
    }

    /// Copies a frame out of a shared row. Returns the frame's mask.
    fn unpack(&self, at: u32, to: &mut Values) -> u16 {
        let (row, place) = (
            (at / self.in_row.max(1)) as usize,
            (at % self.in_row.max(1) * self.channels) as usize,
        );
        let (Some(from), Some(mask)) = (self.values.get(row), self.valid.get(row)) else {
            return 0;
        };
        let mut valid = 0;
        for (taxel, place) in taxels(self.inputs).zip(place..) {
            to[taxel] = from[place % TAXELS];
            valid |= (mask >> (place % TAXELS) & 1) << taxel;
        }
        valid
    }

    /// Averages the frames with a valid value, among `count` frames from `first` on, into `mean`.
    /// Returns false if there are none.
    pub fn mean(&self, first: u32, count: u32, mean: &mut Values) -> bool {
        // Add by position in a row, so that whole rows can be added.
        let (mut sums, mut frames, mut number) = ([0.0f32; TAXELS], 0, first);
        let end = first.wrapping_add(count);
        let whole = ((1u32 << (self.channels * self.in_row)) - 1) as u16;
        let whole = if self.in_row == 1 { self.inputs } else { whole };
        while number != end {
            let left = end.wrapping_sub(number);
            let Some(at) = self.place(number) else {
                number = number.wrapping_add(1);
                continue;
            };
            let (row, beside) = ((at / self.in_row.max(1)) as usize, at % self.in_row.max(1));
            let (Some(values), Some(valid)) = (self.values.get(row), self.valid.get(row)) else {
                return false;
            };
            if beside == 0 && left >= self.in_row && *valid == whole {
                (0..TAXELS).for_each(|place| sums[place] += values[place]);
                (frames, number) = (frames + self.in_row, number.wrapping_add(self.in_row));
                continue;
            }
            let from = if self.in_row == 1 {
                0
            } else {
                (beside * self.channels) as usize
            };
            let until = if self.in_row == 1 {
                TAXELS
            } else {
                from + self.channels as usize
            };
            let of_frame = ((1u32 << until) - (1u32 << from)) as u16;
            if *valid & of_frame != 0 {
                for (sum, value) in sums.iter_mut().zip(values).take(until).skip(from) {
                    *sum += value;
                }
                frames += 1;
            }
            number = number.wrapping_add(1);
        }
        if frames == 0 {
            return false;
        }
        let fraction = 1.0 / frames as f32;
        if self.in_row == 1 {
            *mean = sums.map(|sum| sum * fraction);
            return true;
        }
        for (taxel, first) in taxels(self.inputs).zip(0..) {
            let (mut sum, mut at) = (0.0, first);
            for _ in 0..self.in_row {
                sum += sums[at % TAXELS];
                at += self.channels as usize;
            }
            mean[taxel] = sum * fraction;
        }
        true
    }

    /// Time of a frame's first slot (low 32 bits of the device time in microseconds). In a shared
    /// row only the first frame's time was measured.
    pub fn t_us(&self, number: u32) -> Option<u32> {
        let at = self.place(number)?;
        if self.in_row == 1 {
            return self.t_us.get(at as usize).copied();
        }
        let first_us = *self.t_us.get((at / self.in_row.max(1)) as usize)?;
        Some(first_us.wrapping_add((at % self.in_row.max(1)) * self.frame_ns / 1000))
    }

    /// Time of a frame, in microseconds plus nanoseconds: the earliest estimate from the time
    /// stamps of its row and of the next `rows` rows, each moved back at the scan's nominal period.
    pub fn min_delay(&self, number: u32, rows: u32) -> Option<(u32, i32)> {
        let row_us = |number: u32| {
            self.t_us
                .get((self.place(number)? / self.in_row.max(1)) as usize)
                .copied()
        };
        let (from_us, mut min_ns) = (row_us(number)?, 0);
        for later in (1..=rows).map(|row| row * self.in_row) {
            let passed_us = row_us(number.wrapping_add(later))?.wrapping_sub(from_us);
            min_ns = min_ns.min(
                passed_us
                    .wrapping_mul(1000)
                    .wrapping_sub(later * self.frame_ns) as i32,
            );
        }
        let in_row_ns = self.place(number)? % self.in_row.max(1) * self.frame_ns;
        Some((from_us, min_ns.wrapping_add_unsigned(in_row_ns)))
    }

    /// Reads frames as [`FrameSource::read`] does.
    #[inline]
    pub fn read<R>(
        &self,
        first: u32,
        max: usize,
        read: impl FnOnce(&[Values], &[u16]) -> R,
    ) -> Option<R> {
        let at = self.place(first)?;
        let there = self.next.wrapping_sub(first);
        let count = (max as u32).min(there).min(self.frames - at);
        if self.in_row > 1 {
            return Some(self.read_packed(at, count, read));
        }
        let range = at as usize..(at + count) as usize;
        Some(read(
            self.values.get(range.clone())?,
            self.valid.get(range)?,
        ))
    }

    fn read_packed<R>(&self, at: u32, count: u32, read: impl FnOnce(&[Values], &[u16]) -> R) -> R {
        let count = count.min(READ_FRAMES as u32);
        let (mut values, mut valid) = ([[0.0; TAXELS]; READ_FRAMES], [0; READ_FRAMES]);
        for ((to, mask), at) in values.iter_mut().zip(&mut valid).zip(at..at + count) {
            *mask = self.unpack(at, to);
        }
        let count = count as usize;
        read(
            values.get(..count).unwrap_or_default(),
            valid.get(..count).unwrap_or_default(),
        )
    }
}

/// Maximum number of packed frames per read. Kept small because they are unpacked onto the stack.
const READ_FRAMES: usize = 4;

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

/// Maximum number of frames that a fit reads at once. On the board `detect` waits for the work on
/// them, in which its queue fills up at the chip's highest rate. Everywhere else the same number
/// keeps sums over frames equal to the bit.
const FIT_FRAMES: usize = 4;

impl FrameSource for &Ring {
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        Ring::read(self, first, max.min(FIT_FRAMES), show).ok_or(Overwritten)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::converter::Ads1258Plan;
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
            let mut place = [0.0; TAXELS];
            let found = ring
                .frame(number(n), &mut place)
                .map(|(values, _)| values[3]);
            assert_eq!(found, Some(n as f32));
            assert_eq!(ring.t_us(number(n)), Some(n));
        }
        let is_there = |n| ring.frame(number(n), &mut [0.0; TAXELS]).is_some();
        assert!(!is_there(2000) && !is_there(2000 - RING_FRAMES as u32 - 1));
        let mut read = 0;
        while let Some(shown) = ring.read(number(1200 + read), 16, |values, _| {
            for (values, i) in values.iter().zip(0..) {
                assert_eq!(values[0], (1200 + read + i) as f32);
            }
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
        assert!(ring.frame(70, &mut [0.0; TAXELS]).is_none() && ring.oldest() == 70);
        (0..16).for_each(|n| ring.push(&[n as f32; TAXELS], 1, n));
        // The frames are contiguous, so the rounding of a window's sums does not depend on earlier
        // contents.
        assert_eq!(
            ring.read(70, 16, |values, _| (values.len(), values[15][0])),
            Some((16, 15.0))
        );
    }

    #[test]
    fn a_frame_without_a_valid_value_is_not_shown_as_one() {
        let mut ring = Box::new(Ring::new());
        ring.push(&[5.0; TAXELS], 0, 7);
        assert!(ring.frame(0, &mut [0.0; TAXELS]).is_none());
        assert_eq!(ring.t_us(0), Some(7));
    }

    /// Compares times with the true ends of the conversions, in f64. Either three of four are
    /// served late, by up to half a period of `single`, and the two crystals differ; or none is
    /// late, and the chip's clock error is just too small for a fault.
    #[test]
    fn late_times_do_not_change_the_time_between_two_frames() {
        for plan in [Plan::SINGLE, Plan::VIBRATION, Plan::HAND, Plan::PAPER] {
            for (clock, lateness) in [(0.995, 0), (1.005, 0), (1.0, 1), (0.9999, 1), (1.0001, 1)] {
                let mut ring = Box::new(Ring::new());
                ring.change(&plan, 70);
                let period_us = f64::from(Scan::new(&plan).frame_ns()) * 1e-3 * clock;
                for n in 0..900u32 {
                    let late_us = lateness * [21, 14, 0, 7][n as usize / plan.frames_a_row() % 4];
                    let t_us = (f64::from(n) * period_us) as u32 + late_us;
                    let t_us = t_us.wrapping_add(u32::MAX - 9000);
                    ring.push(&[1.0; TAXELS], plan.inputs, t_us);
                }
                let mut max_us = 0.0f64;
                for first in (70..200).step_by(7) {
                    let [from, until] =
                        [first, first + 600].map(|frame| ring.min_delay(frame, 7).unwrap());
                    let passed_us = f64::from(until.0.wrapping_sub(from.0))
                        + f64::from(until.1 - from.1) * 1e-3;
                    max_us = max_us.max((passed_us - 600.0 * period_us).abs());
                }
                // Limit: the counter's microsecond, and the clock's error over one row, or over
                // eight if some are late.
                let rows_us = f64::from(plan.frames_a_row() as u32)
                    * period_us
                    * [1.0, 8.0][lateness as usize];
                let limit_us = 1.1 + (clock - 1.0f64).abs() * rows_us;
                assert!(max_us < limit_us, "{plan:?} {clock}: {max_us}");
            }
        }
    }

    /// Compares frames of various sets of taxels with a list of what was written, around the ring's
    /// end and the wrap of the numbers.
    #[test]
    fn frames_that_share_rows_are_as_they_were_written() {
        for inputs in [0x8001u16, 0x0412, 0x001f, 0x0100, 0x01ff] {
            let mut own = Ads1258Plan::HAND;
            own.inputs = inputs;
            let (plan, name) = (own.plan(), std::format!("{inputs:#x}"));
            let mut ring = Box::new(Ring::new());
            let first = u32::MAX - 5000;
            ring.change(&plan, first);
            let number = |n: u32| first.wrapping_add(n);
            let value = |n: u32, c: usize| (inputs >> c & 1) as f32 * (n * 16 + c as u32) as f32;
            let values = |n: u32| -> Values { core::array::from_fn(|c| value(n, c)) };
            // Every 37th frame is missing, and the first taxel of every 11th is bad.
            let valid = |n: u32| match n {
                n if n % 37 == 0 => 0,
                n if n % 11 == 0 => inputs & (inputs - 1),
                _ => inputs,
            };
            let frame_us = Scan::new(&plan).frame_ns() as f64 * 1e-3;
            let t_us = |n: u32| (f64::from(n) * frame_us) as u32;
            let all = ring.frames() + ring.frames() / 2 + 7;
            (0..all).for_each(|n| ring.push(&values(n), valid(n), t_us(n)));
            let frames = RING_FRAMES * (TAXELS / inputs.count_ones() as usize);
            assert_eq!(ring.frames() as usize, frames, "{name}");
            let oldest = all - (ring.frames() + 1 - plan.frames_a_row() as u32);
            assert_eq!(ring.oldest(), number(oldest));
            for n in oldest..all {
                let mut place = [0.0; TAXELS];
                let found = ring.frame(number(n), &mut place);
                let found = found.map(|(values, valid)| (*values, valid));
                let expected = Some((values(n), valid(n))).filter(|(_, valid)| *valid != 0);
                assert_eq!(found, expected, "{name} {n}");
                let found_us = ring.t_us(number(n)).unwrap();
                assert!(found_us.abs_diff(t_us(n)) <= 1, "{name} {n}");
            }
            let (from, count) = (oldest + 1000, 97);
            let mut mean = [0.0; TAXELS];
            assert!(ring.mean(number(from), count, &mut mean));
            let there = || (from..from + count).filter(|n| valid(*n) != 0);
            for c in (0..TAXELS).filter(|c| inputs >> c & 1 == 1) {
                let sum: f64 = there().map(|n| f64::from(value(n, c))).sum();
                let expected = sum / there().count() as f64;
                let off = f64::from(mean[c]) / expected - 1.0;
                assert!(off.abs() < 1e-5, "{name} {c}: {off}");
            }
            let mut read = 0;
            while let Some(shown) = ring.read(number(all - 100 + read), 16, |shown, masks| {
                for (n, (one, mask)) in (all - 100 + read..).zip(shown.iter().zip(masks)) {
                    assert_eq!((*one, *mask), (values(n), valid(n)), "{name} {n}");
                }
                shown.len() as u32
            }) {
                read += shown;
            }
            assert_eq!(read, 100, "{name}");
        }
    }
}
