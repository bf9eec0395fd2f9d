//! External interrupts, and the selection of their ports in SYSCFG (RM0090, 12.3 and 9.2).

#[derive(Default)]
pub struct Exti {
    mask: u32,
    falling: u32,
    pending: u32,
}

/// Lines 0 to 22.
const LINES: u32 = 0x007F_FFFF;

impl Exti {
    pub fn fall(&mut self, line: u8) {
        self.pending |= self.falling & 1 << line;
    }

    pub fn is_requested(&self, line: u8) -> bool {
        self.pending & self.mask & 1 << line != 0
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.mask,
            0x04 => 0,
            0x08 => 0,
            0x0C => self.falling,
            0x10 => 0,
            0x14 => self.pending,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        let value = value & LINES;
        match offset {
            0x00 => self.mask = value,
            0x04 if value == 0 => {}
            // Rising edges are not modelled.
            0x08 if value == 0 => {}
            0x0C => self.falling = value,
            0x14 => self.pending &= !value,
            _ => return None,
        }
        Some(())
    }
}

#[derive(Default)]
pub struct Syscfg {
    /// MEMRMP: memory mapped at address 0.
    pub memrmp: u32,
    /// PMC: only ADCxDC2.
    pmc: u32,
    exticr: [u32; 4],
    cmpcr: u32,
}

impl Syscfg {
    /// Port selected for a line of EXTI.
    pub fn port(&self, line: u8) -> u8 {
        (self.exticr[usize::from(line / 4)] >> (4 * (line % 4)) & 15) as u8
    }

    /// True if an ADCxDC2 bit, which lowers the noise of the on-chip ADC, is set.
    pub const fn has_adc_dc2(&self) -> bool {
        self.pmc != 0
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.memrmp,
            0x04 => self.pmc,
            0x08..=0x14 => self.exticr[(offset as usize - 8) / 4],
            0x20 => self.cmpcr,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.memrmp = value & 3,
            0x04 if value & !(7 << 16) == 0 => self.pmc = value,
            0x08..=0x14 => self.exticr[(offset as usize - 8) / 4] = value & 0xFFFF,
            _ => return None,
        }
        Some(())
    }
}
