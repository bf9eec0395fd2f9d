//! Peripherals of few registers: PWR and DBGMCU.

/// Power control (RM0090, 5.4): the supply is always there.
pub struct Pwr {
    cr: u32,
}

impl Pwr {
    /// VOS chooses the full range after a reset (from memory: 0x4000 on the STM32F405, 0xC000 on
    /// the STM32F446).
    pub const fn new() -> Self {
        Self { cr: 0xC000 }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.cr),
            // VOSRDY.
            0x04 => Some(1 << 14),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        // VOS only.
        let fits = offset == 0 && value & !0xC000 == 0;
        fits.then(|| self.cr = value)
    }
}

/// What a debugger may stop (RM0090, 38.16). There is none; the registers hold what is written. A
/// reset leaves them.
pub struct Dbgmcu {
    id_code: u32,
    registers: [u32; 3],
}

impl Dbgmcu {
    pub const fn new(id_code: u32) -> Self {
        Self {
            id_code,
            registers: [0; 3],
        }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.id_code),
            0x04..=0x0C => Some(self.registers[(offset as usize - 4) / 4]),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        let register = self
            .registers
            .get_mut((offset as usize).wrapping_sub(4) / 4)?;
        *register = value;
        Some(())
    }
}
