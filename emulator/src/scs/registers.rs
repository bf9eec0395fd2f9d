//! Registers of the system control space.

use super::state::{FIRST_IRQ, Scs, numbers};

impl Scs {
    /// Reads a word of the control space; `None` if it is not modelled.
    pub fn read(&self, address: u32) -> Option<u32> {
        let word = |bits: u128, from: u32| (bits >> FIRST_IRQ >> ((address - from) * 8)) as u32;
        Some(match address {
            0xE000_E100..=0xE000_E108 => word(self.enabled, 0xE000_E100),
            0xE000_E180..=0xE000_E188 => word(self.enabled, 0xE000_E180),
            0xE000_E200..=0xE000_E208 => word(self.pending, 0xE000_E200),
            0xE000_E280..=0xE000_E288 => word(self.pending, 0xE000_E280),
            0xE000_E300..=0xE000_E308 => word(self.active, 0xE000_E300),
            0xE000_E400..=0xE000_E45F => {
                self.priorities(usize::from(FIRST_IRQ) + (address - 0xE000_E400) as usize)
            }
            // CPUID of the r0p1 core in all chips modelled (ST, PM0214).
            0xE000_ED00 => 0x410F_C241,
            0xE000_ED04 => {
                numbers(self.active)
                    .min_by_key(|number| self.priority_of(*number))
                    .unwrap_or(0) as u32
                    | u32::from(self.pending >> FIRST_IRQ != 0) << 22
            }
            0xE000_ED08 => self.vtor,
            0xE000_ED0C => 0xFA05_0000,
            0xE000_ED10 => self.scr,
            // CCR: STKALIGN.
            0xE000_ED14 => 0x200,
            0xE000_ED18..=0xE000_ED23 => self.priorities(4 + (address - 0xE000_ED18) as usize),
            0xE000_ED24 => self.shcsr,
            0xE000_ED28 => self.cfsr,
            0xE000_ED2C => self.hfsr,
            0xE000_ED38 => self.bfar,
            0xE000_ED88 => self.cpacr,
            0xE000_EF34 => self.fpccr | u32::from(self.lazy_frame.is_some()),
            0xE000_EF38 => self.lazy_frame.unwrap_or(0),
            _ => return None,
        })
    }

    fn priorities(&self, at: usize) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|k| {
            self.priority.get(at + k).copied().unwrap_or(0)
        }))
    }

    /// Writes to the control space: a word, or a byte of the priorities. `None` if not modelled.
    pub fn write(&mut self, address: u32, bytes: u32, value: u32) -> Option<()> {
        let bits = |from: u32| u128::from(value) << FIRST_IRQ << ((address - from) * 8);
        match address {
            0xE000_E100..=0xE000_E108 => self.enabled |= bits(0xE000_E100),
            0xE000_E180..=0xE000_E188 => self.enabled &= !bits(0xE000_E180),
            0xE000_E200..=0xE000_E208 => {
                self.by_software |= bits(0xE000_E200) & !self.pending;
                numbers(bits(0xE000_E200)).for_each(|number| self.pend(number));
            }
            0xE000_E280..=0xE000_E288 => {
                self.pending &= !(bits(0xE000_E280) & !(self.lines & !self.active))
            }
            0xE000_E400..=0xE000_E45F => {
                self.set_priorities(
                    usize::from(FIRST_IRQ) + (address - 0xE000_E400) as usize,
                    bytes,
                    value,
                );
            }
            0xE000_ED08 => self.vtor = value & 0x3FFF_FF80,
            0xE000_ED0C if value >> 16 == 0x05FA => {
                // PRIGROUP must not split off subpriority bits.
                if value & 0x700 > 0x300 {
                    return None;
                }
                self.reset_requested |= value & 4 != 0;
            }
            0xE000_ED0C => {}
            // SEVONPEND, SLEEPDEEP, SLEEPONEXIT.
            0xE000_ED10 if value == 0 => self.scr = value,
            0xE000_ED18..=0xE000_ED23 => {
                self.set_priorities(4 + (address - 0xE000_ED18) as usize, bytes, value)
            }
            0xE000_ED28 => self.cfsr &= !value,
            0xE000_ED2C => self.hfsr &= !value,
            0xE000_ED88 => self.cpacr = value & 0x00F0_0000,
            0xE000_EF34 => {
                self.fpccr = value & 0xC000_0000;
                if value & 1 == 0 {
                    self.lazy_frame = None;
                }
            }
            _ => return None,
        }
        Some(())
    }

    /// Sets priorities; only the upper four bits of each exist (PM0214).
    fn set_priorities(&mut self, at: usize, bytes: u32, value: u32) {
        for (k, byte) in value
            .to_le_bytes()
            .into_iter()
            .enumerate()
            .take(bytes as usize)
        {
            if let Some(priority) = self.priority.get_mut(at + k) {
                *priority = byte & 0xF0;
            }
        }
    }
}
