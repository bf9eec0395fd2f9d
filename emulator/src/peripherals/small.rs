//! Peripherals with few registers: PWR and DBGMCU.

const VOS: u32 = 0xC000;
const ADCDC1: u32 = 1 << 13;

/// Power control (RM0090, 5.4); the supply never fails.
pub struct Pwr {
    cr: u32,
}

impl Pwr {
    pub const fn new(cr: u32) -> Self {
        Self { cr }
    }

    /// Highest processor clock that VOS allows, hertz: 84 MHz in scale 2 of the STM32F401 and F411
    /// (RM0383, 5.4.1); no limit is modelled for the other chips.
    pub const fn limit_hz(&self) -> u64 {
        if self.cr & VOS == 0x8000 {
            84_000_000
        } else {
            u64::MAX
        }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.cr),
            // VOSRDY.
            0x04 => Some(1 << 14),
            _ => None,
        }
    }

    /// ADCDC1, which lowers the noise of the on-chip ADC.
    pub const fn has_adcdc1(&self) -> bool {
        self.cr & ADCDC1 != 0
    }

    /// Writes a register; returns true if VOS changes.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<bool> {
        let fits = offset == 0 && value & !(VOS | ADCDC1) == 0;
        fits.then(|| (core::mem::replace(&mut self.cr, value) ^ value) & VOS != 0)
    }
}

/// DBGMCU: clocks and counters that stop under a debugger (RM0090, 38.16). Without a debugger the
/// registers only store what is written, and keep it across resets.
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
