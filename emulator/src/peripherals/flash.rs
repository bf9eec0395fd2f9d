//! The flash and its interface (RM0090, 3.8): wait states, programming and erasing, both of which
//! stall the processor.

use crate::findings::Rule;

/// Time to program 32 bits, nanoseconds: 16 us typical (DS8626, flash memory programming).
const PROGRAM_NS: u64 = 16_000;
/// Time to erase 128 KiB, nanoseconds: 1 s typical at x32 (DS8626, flash memory programming).
const ERASE_NS: u64 = 1_000_000_000;
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

const PG: u32 = 1;
const SER: u32 = 2;
const STRT: u32 = 1 << 16;
const LOCK: u32 = 1 << 31;
/// PGPERR: the width does not match PSIZE; PGSERR: the sequence is wrong.
const PGPERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
/// WRPERR, PGAERR, PGPERR and PGSERR.
const ERRORS: u32 = 0xF0;

pub struct Flash {
    pub bytes: Vec<u8>,
    acr: u32,
    sr: u32,
    cr: u32,
    keys_seen: usize,
    pub programmed: u64,
    pub erased: u64,
    /// Number of words that can still be programmed before power is lost; `None` for no limit.
    pub words_left: Option<u64>,
    /// If set, power is lost within the next erase, and the function computes each remaining byte
    /// from its offset in the sector and its old content.
    pub erase_remains: Option<fn(usize, u8) -> u8>,
    /// FLASH_OPTCR: the option bytes.
    optcr: u32,
}

#[derive(Default)]
pub struct Effect {
    pub stall_ns: u64,
    pub has_erased: bool,
    pub broken: Option<(Rule, String)>,
}

impl Flash {
    pub fn new(bytes: usize, optcr: u32) -> Self {
        let (acr, sr, cr) = (0, 0, LOCK);
        let (keys_seen, programmed, erased, words_left, erase_remains) = (0, 0, 0, None, None);
        let bytes = vec![0xFF; bytes];
        Self {
            bytes,
            acr,
            sr,
            cr,
            keys_seen,
            programmed,
            erased,
            words_left,
            erase_remains,
            optcr,
        }
    }

    pub fn set_errors(&mut self, are_set: bool) {
        self.sr = if are_set { ERRORS } else { 0 };
    }

    /// Returns the registers to the state after a reset. Stored data remain.
    pub fn reset(&mut self) {
        (self.acr, self.sr, self.cr, self.keys_seen) = (0, 0, LOCK, 0);
    }

    pub fn latency(&self) -> u64 {
        (self.acr & 7).into()
    }

    /// PRFTEN.
    pub const fn prefetches(&self) -> bool {
        self.acr & 1 << 8 != 0
    }

    /// Start and size of a sector (RM0090, table 5; RM0390, table 4).
    fn sector(number: u32) -> (usize, usize) {
        match number {
            0..=3 => (number as usize * 0x4000, 0x4000),
            4 => (0x1_0000, 0x1_0000),
            _ => ((number as usize - 4) * 0x2_0000, 0x2_0000),
        }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.acr,
            0x0C => self.sr,
            0x10 => self.cr,
            0x14 => self.optcr,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<Effect> {
        let mut effect = Effect::default();
        match offset {
            0x00 => self.acr = value & 0x1F07,
            0x04 => {
                let is_right = KEYS.get(self.keys_seen) == Some(&value);
                self.keys_seen = if is_right {
                    self.keys_seen + 1
                } else {
                    usize::MAX
                };
                if self.keys_seen == KEYS.len() {
                    (self.cr, self.keys_seen) = (self.cr & !LOCK, 0);
                }
                if !is_right {
                    effect.broken =
                        Some((Rule::FlashSequence, format!("a wrong key {value:#010x}")));
                }
            }
            0x0C => self.sr &= !(value & 0xF3),
            0x10 if self.cr & LOCK != 0 => {
                // Writes to a locked register are lost; locking it again is harmless.
                if value & LOCK == 0 {
                    effect.broken = Some((
                        Rule::FlashSequence,
                        "FLASH_CR is written while it is locked".into(),
                    ));
                }
            }
            0x10 => {
                // Mass erase and interrupts are not modelled.
                if value & 0x0300_8004 != 0 {
                    return None;
                }
                if value & LOCK != 0 && value & (PG | SER) != 0 {
                    let detail = format!("{value:#010x} locks FLASH_CR as it chooses an operation");
                    effect.broken = Some((Rule::FlashSequence, detail));
                }
                self.cr = value & !STRT;
                if value & STRT != 0 {
                    self.erase(value, &mut effect);
                }
            }
            _ => return None,
        }
        Some(effect)
    }

    fn erase(&mut self, cr: u32, effect: &mut Effect) {
        let (from, bytes) = Self::sector(cr >> 3 & 15);
        let Some(sector) = self
            .bytes
            .get_mut(from..from + bytes)
            .filter(|_| cr & (SER | PG) == SER)
        else {
            self.sr |= PGSERR;
            effect.broken = Some((
                Rule::FlashSequence,
                format!("STRT without a sector to erase, {cr:#010x}"),
            ));
            return;
        };
        if let Some(remains) = self.erase_remains.take() {
            sector
                .iter_mut()
                .enumerate()
                .for_each(|(at, byte)| *byte = remains(at, *byte));
            self.words_left = Some(0);
        } else if self.words_left.is_none_or(|left| left > 0) {
            sector.fill(0xFF);
        }
        self.erased += 1;
        (effect.stall_ns, effect.has_erased) = (ERASE_NS, true);
    }

    pub fn program(&mut self, at: usize, bytes: u32, value: u32) -> Effect {
        let mut effect = Effect::default();
        let mut refuse = |bit: u32, why: &str| {
            self.sr |= bit;
            effect.broken = Some((
                Rule::FlashSequence,
                format!("{why}: {at:#x}, FLASH_CR {:#010x}", self.cr),
            ));
        };
        // It is unspecified whether PG works in a locked register, so the firmware must not rely on
        // it.
        if self.cr & LOCK != 0 || self.cr & PG == 0 {
            refuse(PGSERR, "a store into the flash without PG");
            return effect;
        }
        if 1 << (self.cr >> 8 & 3) != bytes {
            refuse(PGPERR, "a store of another width than PSIZE");
            return effect;
        }
        let Some(place) = self.bytes.get_mut(at..at + bytes as usize) else {
            return effect;
        };
        if place.iter().any(|byte| *byte != 0xFF) {
            effect.broken = Some((
                Rule::FlashWordTwice,
                format!("a word that is not erased is programmed: {at:#x}"),
            ));
        }
        effect.stall_ns = PROGRAM_NS;
        if let Some(left) = &mut self.words_left {
            if *left == 0 {
                return effect;
            }
            *left -= 1;
        }
        // Programming only clears bits.
        place
            .iter_mut()
            .zip(value.to_le_bytes())
            .for_each(|(byte, new)| *byte &= new);
        self.programmed += 1;
        effect
    }
}
