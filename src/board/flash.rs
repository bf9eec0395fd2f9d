//! The last two sectors of the flash, for settings, 128 KiB each: 10 and 11 of the STM32F405RG (RM0090, table 5), 6 and 7
//! of the STM32F446RE (RM0390, table 4).
//!
//! The firmware runs from the same bank, so the processor stands still meanwhile: 16 us for a word, at most 100 us, and
//! 1 s for a sector, at most 2 s (DS8626, flash memory programming, words of 32 bits).

use ridgetone::store::{NotStored, PAGES, Pages, WORD_BYTES};
use stm32f4xx_hal::pac::FLASH;

unsafe extern "C" {
    /// Where the first of them begins; `memory.x` keeps code out from there on.
    static _settings_start: u32;
}

/// From sector 5 on all have the same size; its address.
const SECTOR_5: usize = 0x0802_0000;

/// Address of the first of them.
fn first() -> usize {
    &raw const _settings_start as usize
}

/// Number of the first of them.
fn first_sector() -> u8 {
    5 + (first().saturating_sub(SECTOR_5) / SettingsFlash::PAGE_BYTES as usize) as u8
}

/// Words of 32 bits at once: allowed from 2.7 V on.
const PSIZE: u8 = 2;

/// Every error flag, and the end of an operation, in FLASH_SR: cleared by writing ones.
const FLAGS: u32 = 0xf3;

/// FLASH_KEYR's two keys.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// The two sectors.
pub struct SettingsFlash(FLASH);

impl SettingsFlash {
    /// Takes over the flash's registers.
    pub const fn new(flash: FLASH) -> Self {
        Self(flash)
    }

    /// Does something with the flash unlocked; waits until it is done.
    fn unlocked(&mut self, action: impl FnOnce(&FLASH)) -> Result<(), NotStored> {
        let flash = &self.0;
        // SAFETY: the flags that a write clears.
        flash.sr().write(|w| unsafe { w.bits(FLAGS) });
        if flash.cr().read().lock().bit_is_set() {
            for key in KEYS {
                // SAFETY: the keys that unlock it.
                flash.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        action(flash);
        cortex_m::asm::dsb();
        while flash.sr().read().bsy().bit_is_set() {}
        let failed = flash.sr().read().bits() & FLAGS & !1 != 0;
        flash.cr().write(|w| w.lock().set_bit());
        // What the data cache holds of it is old now (RM0090, 3.5.2).
        if flash.acr().read().dcen().bit_is_set() {
            flash.acr().modify(|_, w| w.dcen().clear_bit());
            flash.acr().modify(|_, w| w.dcrst().set_bit());
            flash.acr().modify(|_, w| w.dcrst().clear_bit());
            flash.acr().modify(|_, w| w.dcen().set_bit());
        }
        if failed { Err(NotStored) } else { Ok(()) }
    }
}

impl Pages for SettingsFlash {
    const PAGE_BYTES: u32 = 128 * 1024;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) {
        for (place, byte) in (first() + offset as usize..).zip(bytes) {
            // SAFETY: the caller keeps to the two sectors, which are flash and can be read byte by byte.
            *byte = unsafe { (place as *const u8).read_volatile() };
        }
    }

    fn program(&mut self, offset: u32, word: [u8; WORD_BYTES]) -> Result<(), NotStored> {
        self.unlocked(|flash| {
            // SAFETY: PSIZE has two bits.
            flash.cr().write(|w| unsafe { w.psize().bits(PSIZE) }.pg().set_bit());
            // SAFETY: the caller keeps to the two sectors and to whole words; nothing else lies there.
            unsafe { ((first() + offset as usize) as *mut u32).write_volatile(u32::from_ne_bytes(word)) };
        })
    }

    fn erase(&mut self, page: u32) -> Result<(), NotStored> {
        if page >= PAGES {
            return Err(NotStored);
        }
        self.unlocked(|flash| {
            // SAFETY: PSIZE has two bits, and the number is that of one of the two sectors.
            flash
                .cr()
                .write(|w| unsafe { w.psize().bits(PSIZE).snb().bits(first_sector() + page as u8) }.ser().set_bit());
            flash.cr().modify(|_, w| w.strt().set_bit());
        })
    }
}
