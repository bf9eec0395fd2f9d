//! Pages of settings in RAM, where the emulator has no flash that can be written. A reset leaves them as they are.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use ridgetone::store::{NotStored, PAGES, Pages, WORD_BYTES};

/// Bytes of a page: two items and what the store keeps beside them.
const PAGE_BYTES: usize = 192;

/// What says that the pages have been erased once.
const MARK: u32 = 0x7e55_e11a;

struct Memory {
    mark: u32,
    pages: [u8; PAGES as usize * PAGE_BYTES],
}

struct Kept(UnsafeCell<MaybeUninit<Memory>>);

// SAFETY: only the one [`SettingsFlash`] looks into it.
unsafe impl Sync for Kept {}

// Not cleared at start.
#[unsafe(link_section = ".uninit.settings")]
static MEMORY: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// The pages.
pub struct SettingsFlash(&'static mut Memory);

impl SettingsFlash {
    /// Takes the pages over.
    ///
    /// # Safety
    /// Once only.
    pub unsafe fn new() -> Self {
        // SAFETY: nobody else has it, by this function's own condition, and any bytes are a `Memory`.
        let memory = unsafe { (*MEMORY.0.get()).assume_init_mut() };
        if memory.mark != MARK {
            *memory = Memory { mark: MARK, pages: [0xff; PAGES as usize * PAGE_BYTES] };
        }
        Self(memory)
    }
}

impl Pages for SettingsFlash {
    const PAGE_BYTES: u32 = PAGE_BYTES as u32;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) {
        for (byte, kept) in bytes.iter_mut().zip(self.0.pages.iter().skip(offset as usize)) {
            *byte = *kept;
        }
    }

    fn program(&mut self, offset: u32, word: [u8; WORD_BYTES]) -> Result<(), NotStored> {
        let offset = offset as usize;
        let place = self.0.pages.get_mut(offset..offset + WORD_BYTES).ok_or(NotStored)?;
        // Flash only ever loses bits.
        place.iter_mut().zip(word).for_each(|(kept, byte)| *kept &= byte);
        Ok(())
    }

    fn erase(&mut self, page: u32) -> Result<(), NotStored> {
        let page = self.0.pages.chunks_exact_mut(PAGE_BYTES).nth(page as usize).ok_or(NotStored)?;
        page.fill(0xff);
        Ok(())
    }
}
