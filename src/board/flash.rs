//! The last two sectors of the flash, 128 KiB each, which store the settings: 10 and 11 of the
//! STM32F405RG (RM0090, table 5), 6 and 7 of the STM32F446RE (RM0390, table 4).
//!
//! The firmware runs from the same bank, so programming a word stalls the processor for 16 us, at
//! most 100 us, and erasing a sector for 1 s, at most 2 s (DS8626, flash memory programming, words
//! of 32 bits).
//!
//! `stm32f4xx_hal::flash` (0.23) is not used: it programs byte by byte, which takes four times as
//! long, does not reset the data cache, never clears an error, panics if the flash does not unlock,
//! and can write to all of the flash.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use ridgetone_proto::store::{PAGES, WORD_BYTES};
use stm32f4xx_hal::pac::FLASH;

unsafe extern "C" {
    /// Start of the first settings sector; `memory.x` keeps code below it.
    static _settings_start: u32;
}

/// Address of sector 5, the first of the sectors of 128 KiB.
const SECTOR_5: usize = 0x0802_0000;

fn first() -> usize {
    &raw const _settings_start as usize
}

fn first_sector() -> u8 {
    5 + (first().saturating_sub(SECTOR_5) / SettingsFlash::ERASE_SIZE) as u8
}

/// Code for programming in words of 32 bits, which requires at least 2.7 V.
const PSIZE: u8 = 2;

/// All error flags and the end-of-operation flag in FLASH_SR: cleared by writing ones.
const FLAGS: u32 = 0xf3;

/// FLASH_KEYR's two keys.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// The two settings sectors. Offsets count from the start of the first; offsets beyond both are
/// refused.
pub struct SettingsFlash(FLASH);

impl SettingsFlash {
    pub const fn new(flash: FLASH) -> Self {
        Self(flash)
    }

    /// Runs `action` with the flash unlocked, and waits until the flash is ready.
    fn unlocked(&mut self, action: impl FnOnce(&FLASH)) -> Result<(), NorFlashErrorKind> {
        let flash = &self.0;
        // SAFETY: writing ones clears these flags.
        flash.sr().write(|w| unsafe { w.bits(FLAGS) });
        if flash.cr().read().lock().bit_is_set() {
            for key in KEYS {
                // SAFETY: these keys unlock the flash.
                flash.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        action(flash);
        cortex_m::asm::dsb();
        while flash.sr().read().bsy().bit_is_set() {}
        let failed = flash.sr().read().bits() & FLAGS & !1 != 0;
        flash.cr().write(|w| w.lock().set_bit());
        // The data cache may still hold the old contents (RM0090, 3.5.2).
        if flash.acr().read().dcen().bit_is_set() {
            flash.acr().modify(|_, w| w.dcen().clear_bit());
            flash.acr().modify(|_, w| w.dcrst().set_bit());
            flash.acr().modify(|_, w| w.dcrst().clear_bit());
            flash.acr().modify(|_, w| w.dcen().set_bit());
        }
        if failed {
            Err(NorFlashErrorKind::Other)
        } else {
            Ok(())
        }
    }
}

/// Returns the address of `bytes` bytes at `offset`, if they are within the two sectors.
fn address(offset: u32, bytes: usize) -> Result<usize, NorFlashErrorKind> {
    let end = (offset as usize).saturating_add(bytes);
    if end > CAPACITY {
        Err(NorFlashErrorKind::OutOfBounds)
    } else {
        Ok(first() + offset as usize)
    }
}

const CAPACITY: usize = PAGES as usize * SettingsFlash::ERASE_SIZE;

impl ErrorType for SettingsFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SettingsFlash {
    /// Whole words, for speed: start-up searches both sectors.
    const READ_SIZE: usize = WORD_BYTES;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let place = address(offset, bytes.len())?;
        let (words, rest) = bytes.as_chunks_mut::<WORD_BYTES>();
        if !offset.is_multiple_of(WORD_BYTES as u32) || !rest.is_empty() {
            return Err(NorFlashErrorKind::NotAligned);
        }
        for (place, word) in (place..).step_by(WORD_BYTES).zip(words) {
            // SAFETY: an aligned word in the two sectors, which are flash.
            *word = unsafe { (place as *const u32).read_volatile() }.to_ne_bytes();
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        CAPACITY
    }
}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = 128 * 1024;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let (words, rest) = bytes.as_chunks::<WORD_BYTES>();
        if !offset.is_multiple_of(WORD_BYTES as u32) || !rest.is_empty() {
            return Err(NorFlashErrorKind::NotAligned);
        }
        for (place, word) in (address(offset, bytes.len())?..)
            .step_by(WORD_BYTES)
            .zip(words)
        {
            self.unlocked(|flash| {
                // SAFETY: PSIZE has two bits.
                flash.cr().write(|w| {
                    unsafe { w.psize().bits(PSIZE) }
                        .lock()
                        .clear_bit()
                        .pg()
                        .set_bit()
                });
                // SAFETY: an aligned word in the two sectors, which hold nothing else.
                unsafe { (place as *mut u32).write_volatile(u32::from_ne_bytes(*word)) };
            })?;
        }
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let page = match (from as usize, to as usize) {
            (0, Self::ERASE_SIZE) => 0,
            (Self::ERASE_SIZE, CAPACITY) => 1,
            _ => return Err(NorFlashErrorKind::OutOfBounds),
        };
        self.unlocked(|flash| {
            // SAFETY: PSIZE has two bits, and the number is one of the two sectors.
            flash.cr().write(|w| {
                unsafe { w.psize().bits(PSIZE).snb().bits(first_sector() + page) }
                    .lock()
                    .clear_bit()
                    .ser()
                    .set_bit()
            });
            flash.cr().modify(|_, w| w.strt().set_bit());
        })
    }
}
