//! Means of a few frames each: a span in a fraction of its frames.

use crate::frame_span::{BLOCK, Block};
use crate::limits::CHANNELS_MAX;
use crate::source::Values;
use crate::sums::{OfQuads, QUAD, Quads, Sums};

/// Sums of groups of frames, relative to the first frame that counts: means, but for a common factor.
pub struct Means<'a> {
    /// Frames of a group, a multiple of [`QUAD`].
    pub by: u32,
    /// One for each complete group.
    values: &'a mut [Values],
    /// Mask of valid channels; 0 where no frame of a group counts.
    valid: &'a mut [u16],
    /// Over the groups.
    pub sums: Sums,
    /// Of the latest block.
    of_quads: OfQuads,
}

impl<'a> Means<'a> {
    /// Memory for as many groups of `by` frames as go into both slices.
    pub fn new(by: u32, values: &'a mut [Values], valid: &'a mut [u16]) -> Self {
        Self { by, values, valid, sums: Sums::new([0.0; CHANNELS_MAX]), of_quads: OfQuads::default() }
    }

    /// `u` of a group, and from one to the next.
    fn place(&self, group: usize) -> (f32, f32) {
        let step = 2.0 / self.valid.len().max(1) as f32;
        ((group as f32 + 0.5) * step - 1.0, step)
    }

    /// Adds a block here and to the sums of all frames.
    pub fn add(&mut self, sums: &mut Sums, block: &Block, from: f32, step: f32, channels: u16) {
        let first = block.first as usize / QUAD;
        let (u, u_step) = self.place(first);
        if block.complete
            && self.by == QUAD as u32
            && let Some(quads) = self.values.get_mut(first..).and_then(|values| values.first_chunk_mut())
            && let Some(valid) = self.valid.get_mut(first..first + BLOCK / QUAD)
        {
            valid.fill(channels);
            sums.add(block, from, step, quads, &mut self.of_quads);
            sums.add_block(&self.of_quads, from, step);
            return self.sums.add_quads(&self.of_quads, u, u_step);
        }
        let mut quads = [[0.0; CHANNELS_MAX]; BLOCK / QUAD];
        sums.add(block, from, step, &mut quads, &mut self.of_quads);
        if block.complete && step > 0.0 {
            sums.add_block(&self.of_quads, from, step);
        }
        self.add_apart(block, &quads, channels);
    }

    /// Adds quads that are less than a group, or of which frames are missing.
    #[inline(never)]
    fn add_apart(&mut self, block: &Block, quads: &Quads, channels: u16) {
        for (q, quad) in quads.iter().enumerate() {
            let at = block.first + (QUAD * q) as u32;
            let group = (at / self.by) as usize;
            let (u, _) = self.place(group);
            let (Some(sum), Some(valid)) = (self.values.get_mut(group), self.valid.get_mut(group)) else { return };
            if at.is_multiple_of(self.by) {
                (*sum, *valid) = ([0.0; CHANNELS_MAX], 0);
            }
            // Frames are counted in the mask until all are there.
            *valid += block.valid[QUAD * q..QUAD * (q + 1)].iter().filter(|valid| **valid != 0).count() as u16;
            for c in 0..CHANNELS_MAX {
                sum[c] += quad[c];
            }
            if (at + QUAD as u32).is_multiple_of(self.by) && *valid > 0 {
                let share = self.by as f32 / *valid as f32;
                sum.iter_mut().for_each(|sum| *sum *= share);
                *valid = channels;
                self.sums.add_one(sum, u);
            }
        }
    }
}
