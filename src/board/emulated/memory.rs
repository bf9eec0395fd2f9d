//! Pages of settings in RAM, where the emulator has no flash that can be written. A reset leaves
//! them as they are.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use ridgetone_proto::store::{PAGES, RECORD_BYTES, WORD_BYTES};

/// Bytes of a page: a record, so that every other one is erased.
const PAGE_BYTES: usize = RECORD_BYTES;

/// The mark of pages that have been erased once.
const MARK: u32 = 0x7e55_e11a;

struct Memory {
    mark: u32,
    pages: [u8; PAGES as usize * PAGE_BYTES],
}

struct Kept(UnsafeCell<MaybeUninit<Memory>>);

// SAFETY: only the one [`SettingsFlash`] uses it.
unsafe impl Sync for Kept {}

// Not cleared at start.
#[unsafe(link_section = ".uninit.settings")]
static MEMORY: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// The pages.
pub struct SettingsFlash(&'static mut Memory);

impl SettingsFlash {
    /// # Safety
    /// Once only.
    pub unsafe fn new() -> Self {
        // SAFETY: nobody else has it, by this function's own condition, and any bytes are a
        // `Memory`.
        let memory = unsafe { (*MEMORY.0.get()).assume_init_mut() };
        if memory.mark != MARK {
            *memory = Memory {
                mark: MARK,
                pages: [0xff; PAGES as usize * PAGE_BYTES],
            };
        }
        Self(memory)
    }
}

impl ErrorType for SettingsFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let kept = self
            .0
            .pages
            .get(offset as usize..)
            .and_then(|kept| kept.get(..bytes.len()));
        bytes.copy_from_slice(kept.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.pages.len()
    }
}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let place = self
            .0
            .pages
            .get_mut(offset as usize..)
            .and_then(|place| place.get_mut(..bytes.len()));
        // Flash only ever loses bits.
        place
            .ok_or(NorFlashErrorKind::OutOfBounds)?
            .iter_mut()
            .zip(bytes)
            .for_each(|(kept, byte)| *kept &= byte);
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.0
            .pages
            .get_mut(from as usize..to as usize)
            .ok_or(NorFlashErrorKind::OutOfBounds)?
            .fill(0xff);
        Ok(())
    }
}
