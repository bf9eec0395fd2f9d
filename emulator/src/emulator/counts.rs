//! Counters of instructions and cycles.

use crate::cpu::FLASH;

/// Instructions and cycles per half word of the flash.
pub(super) struct Counts(pub(super) Vec<[u64; 2]>);

impl Counts {
    pub fn new(flash_bytes: usize) -> Self {
        Self(vec![[0; 2]; flash_bytes / 2])
    }

    #[inline(always)]
    pub fn add(&mut self, pc: u32, cycles: u64) {
        if let Some([instructions, sum]) = self.0.get_mut((pc.wrapping_sub(FLASH) >> 1) as usize) {
            *instructions += 1;
            *sum += cycles;
        }
    }
}
