//! The memory map (RM0090, 2.3).

use super::state::Bus;
use crate::peripherals::flash::Effect;
use crate::stop::{Stop, Usage};
use crate::width::Width;

const FLASH: u32 = 0x0800_0000;
const CCM: u32 = 0x1000_0000;
const RAM: u32 = 0x2000_0000;
/// Bit-band alias of RAM and of peripherals: one word for each bit (DDI 0403E, B3.1; RM0090,
/// 2.3.4).
const RAM_BITS: u32 = 0x2200_0000;
const PERIPHERALS: u32 = 0x4000_0000;
const PERIPHERAL_BITS: u32 = 0x4200_0000;
const SYSTEM: u32 = 0xE000_0000;

/// Extra cycles of a register access, which takes 2 to 3.
const REGISTER_CYCLES: u64 = 2;

impl Bus {
    pub fn fetch(&mut self, address: u32) -> Result<u16, Stop> {
        // Code cannot run from registers.
        if address >= PERIPHERALS {
            return Err(Stop::Bus(address));
        }
        Ok(self.read(address, 2)? as u16)
    }

    /// Loads a value for an instruction, which takes an extra cycle.
    #[inline(always)]
    pub fn load(&mut self, width: Width, address: u32) -> Result<u32, Stop> {
        self.time.cycles += 1;
        Ok(width.extend(self.read(address, width.bytes())?))
    }

    /// Stores a value for an instruction; the write buffer hides the time.
    #[inline(always)]
    pub fn store(&mut self, width: Width, address: u32, value: u32) -> Result<(), Stop> {
        self.write(address, width.bytes(), value)
    }

    #[inline(always)]
    pub fn read_aligned(&mut self, address: u32) -> Result<u32, Stop> {
        if address & 3 != 0 {
            Err(Stop::Usage(Usage::Unaligned))
        } else {
            self.read(address, 4)
        }
    }

    #[inline(always)]
    pub fn write_aligned(&mut self, address: u32, value: u32) -> Result<(), Stop> {
        if address & 3 != 0 {
            Err(Stop::Usage(Usage::Unaligned))
        } else {
            self.write(address, 4, value)
        }
    }

    #[inline(always)]
    pub fn read(&mut self, address: u32, bytes: u32) -> Result<u32, Stop> {
        let at = address.wrapping_sub(RAM) as usize;
        if let Some(place) = self.ram.get(at..at + bytes as usize) {
            return Ok(little_endian(place));
        }
        let at = address.wrapping_sub(FLASH) as usize;
        if let Some(place) = self.flash.bytes.get(at..at + bytes as usize) {
            return Ok(little_endian(place));
        }
        self.read_elsewhere(address, bytes)
    }

    fn read_elsewhere(&mut self, address: u32, bytes: u32) -> Result<u32, Stop> {
        let at = |from: u32| (address - from) as usize;
        let inside =
            |memory: &[u8], at: usize| memory.get(at..at + bytes as usize).map(little_endian);
        match address {
            // Memory mapped at 0: the flash, or the ROM's boot loader, whose content is unknown.
            0..FLASH if self.syscfg.memrmp == 0 => {
                inside(&self.flash.bytes, at(0)).ok_or(Stop::Bus(address))
            }
            0..FLASH => Ok(0xFFFF_FFFF),
            CCM..0x1001_0000 => inside(&self.ccm, at(CCM)).ok_or(Stop::Bus(address)),
            RAM_BITS..0x2240_0000 => {
                let word = self.read(RAM + (address - RAM_BITS) / 32, 1)?;
                Ok(word >> bit_of(address, 8) & 1)
            }
            PERIPHERALS..0x4002_8000 => self.read_peripheral(address, bytes),
            PERIPHERAL_BITS..0x4250_0000 => {
                let word =
                    self.read_peripheral(PERIPHERALS + (address - PERIPHERAL_BITS) / 128 * 4, 4)?;
                Ok(word >> bit_of(address, 32) & 1)
            }
            SYSTEM..=0xE00F_FFFF => self.read_system(address, bytes),
            _ => Err(Stop::Bus(address)),
        }
    }

    #[inline(always)]
    pub fn write(&mut self, address: u32, bytes: u32, value: u32) -> Result<(), Stop> {
        let at = address.wrapping_sub(RAM) as usize;
        if let Some(place) = self.ram.get_mut(at..at + bytes as usize) {
            put(place, value);
            return Ok(());
        }
        self.write_elsewhere(address, bytes, value)
    }

    fn write_elsewhere(&mut self, address: u32, bytes: u32, value: u32) -> Result<(), Stop> {
        match address {
            FLASH..CCM if ((address - FLASH) as usize) < self.flash.bytes.len() => {
                let effect = self.flash.program((address - FLASH) as usize, bytes, value);
                self.apply(effect);
                Ok(())
            }
            CCM..0x1001_0000 => {
                let at = (address - CCM) as usize;
                self.ccm
                    .get_mut(at..at + bytes as usize)
                    .map(|place| put(place, value))
                    .ok_or(Stop::Bus(address))
            }
            RAM_BITS..0x2240_0000 => {
                let (byte, bit) = (RAM + (address - RAM_BITS) / 32, bit_of(address, 8));
                let word = self.read(byte, 1)?;
                self.write(byte, 1, word & !(1 << bit) | (value & 1) << bit)
            }
            PERIPHERALS..0x4002_8000 => self.write_peripheral(address, bytes, value),
            PERIPHERAL_BITS..0x4250_0000 => {
                let (register, bit) = (
                    PERIPHERALS + (address - PERIPHERAL_BITS) / 128 * 4,
                    bit_of(address, 32),
                );
                let word = self.read_peripheral(register, 4)?;
                self.write_peripheral(register, 4, word & !(1 << bit) | (value & 1) << bit)
            }
            SYSTEM..=0xE00F_FFFF => self.write_system(address, bytes, value),
            _ => Err(Stop::Bus(address)),
        }
    }

    fn read_system(&mut self, address: u32, bytes: u32) -> Result<u32, Stop> {
        let word = match address & !3 {
            word @ 0xE004_2000.. => self.dbgmcu.read(word - 0xE004_2000),
            word => self.scs.read(word),
        };
        let word = word.ok_or_else(|| self.unmodelled("a register", address))?;
        Ok(part(word, address, bytes))
    }

    fn write_system(&mut self, address: u32, bytes: u32, value: u32) -> Result<(), Stop> {
        self.scs.now = self.time.cycles;
        let done = match address {
            0xE004_2000.. => self.dbgmcu.write(address - 0xE004_2000, value),
            _ => self.scs.write(address, bytes, value),
        };
        self.attend();
        done.ok_or_else(|| self.unmodelled("a register", address))
    }

    fn read_peripheral(&mut self, address: u32, bytes: u32) -> Result<u32, Stop> {
        self.time.cycles += REGISTER_CYCLES;
        self.catch_up();
        let word = self
            .register(address & !3)
            .ok_or_else(|| self.unmodelled("a register", address))?;
        Ok(part(word, address, bytes))
    }

    fn write_peripheral(&mut self, address: u32, bytes: u32, value: u32) -> Result<(), Stop> {
        self.time.cycles += REGISTER_CYCLES;
        self.catch_up();
        // The bridge repeats a short value over the whole word. This is not modelled, because only
        // registers of up to 16 bits are written this way.
        let done = if address & 3 == 0 {
            self.set_register(address, part(value, 0, bytes))
        } else {
            None
        };
        self.attend();
        done.ok_or_else(|| self.unmodelled("a register", address))
    }

    pub fn apply(&mut self, effect: Effect) {
        self.time.cycles += effect.stall_ns * self.time.hz() / 1_000_000_000;
        self.flash_changed |= effect.has_erased;
        self.note(effect.broken);
        self.attend();
    }
}

/// Returns the number, modulo `bits`, of the bit that a word of a bit-band alias represents.
fn bit_of(alias: u32, bits: u32) -> u32 {
    alias / 4 % bits
}

/// Extracts the `bytes` bytes at `address` from their word.
fn part(word: u32, address: u32, bytes: u32) -> u32 {
    if bytes == 4 {
        word
    } else {
        word >> (8 * (address & 3)) & !(u32::MAX << (8 * bytes))
    }
}

#[inline(always)]
fn put(place: &mut [u8], value: u32) {
    match place {
        [_, _, _, _] => place.copy_from_slice(&value.to_le_bytes()),
        [_, _] => place.copy_from_slice(&(value as u16).to_le_bytes()),
        _ => place[0] = value as u8,
    }
}

#[inline(always)]
fn little_endian(bytes: &[u8]) -> u32 {
    match *bytes {
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        [a, b] => u16::from_le_bytes([a, b]).into(),
        [a] => a.into(),
        _ => 0,
    }
}
