//! One port of general-purpose pins (RM0090, 8.4).

pub struct Gpio {
    port: u8,
    moder: u32,
    otyper: u32,
    ospeedr: u32,
    pupdr: u32,
    odr: u32,
    afr: [u32; 2],
    pub outside: u16,
}

impl Gpio {
    pub const fn new(port: u8) -> Self {
        // The debugger's pins have different reset values (RM0090, 8.4.1 to 8.4.4). OSPEEDR of port
        // A: RM0090 has 0x0C000000, the register descriptions 0; nothing depends on it.
        let (moder, ospeedr, pupdr) = match port {
            0 => (0xA800_0000, 0x0C00_0000, 0x6400_0000),
            1 => (0x0280, 0xC0, 0x0100),
            _ => (0, 0, 0),
        };
        Self {
            port,
            moder,
            otyper: 0,
            ospeedr,
            pupdr,
            odr: 0,
            afr: [0; 2],
            outside: 0,
        }
    }

    pub fn reset(&mut self) {
        *self = Self {
            outside: self.outside,
            ..Self::new(self.port)
        };
    }

    /// Mode of a pin: 0 input, 1 output, 2 alternate, 3 analogue.
    pub fn mode(&self, pin: u8) -> u32 {
        self.moder >> (2 * pin) & 3
    }

    /// The level that an output drives; `None` for other pins.
    pub fn driven(&self, pin: u8) -> Option<bool> {
        (self.mode(pin) == 1).then(|| self.odr >> pin & 1 != 0)
    }

    /// Alternate function of a pin; `None` in other modes.
    pub fn function(&self, pin: u8) -> Option<u32> {
        (self.mode(pin) == 2).then(|| self.afr[usize::from(pin / 8)] >> (4 * (pin % 8)) & 15)
    }

    /// Speed of a pad: 0 low, 1 medium, 2 fast, 3 very fast.
    pub fn speed(&self, pin: u8) -> u32 {
        self.ospeedr >> (2 * pin) & 3
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.moder,
            0x04 => self.otyper,
            0x08 => self.ospeedr,
            0x0C => self.pupdr,
            0x10 => (0..16).fold(0, |bits, pin| {
                let level = match self.mode(pin) {
                    3 => false,
                    _ => self.driven(pin).unwrap_or(self.outside >> pin & 1 != 0),
                };
                bits | u32::from(level) << pin
            }),
            0x14 => self.odr,
            0x20 => self.afr[0],
            0x24 => self.afr[1],
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.moder = value,
            0x04 => self.otyper = value & 0xFFFF,
            0x08 => self.ospeedr = value,
            0x0C => self.pupdr = value,
            0x14 => self.odr = value & 0xFFFF,
            // If both are written, set has priority over reset.
            0x18 => self.odr = self.odr & !(value >> 16) | value & 0xFFFF,
            0x20 => self.afr[0] = value,
            0x24 => self.afr[1] = value,
            _ => return None,
        }
        Some(())
    }
}
