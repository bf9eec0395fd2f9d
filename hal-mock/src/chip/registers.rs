//! The ten registers: names and bits as in the datasheet, SBAS297G.

/// Number of registers, at addresses 00h to 09h.
pub const REGISTERS: usize = 10;

pub(crate) const CONFIG0: u8 = 0x00;
pub(crate) const CONFIG1: u8 = 0x01;
pub(crate) const MUXSCH: u8 = 0x02;
pub(crate) const MUXDIF: u8 = 0x03;
pub(crate) const MUXSG0: u8 = 0x04;
pub(crate) const MUXSG1: u8 = 0x05;
pub(crate) const SYSRED: u8 = 0x06;
pub(crate) const GPIOC: u8 = 0x07;
pub(crate) const GPIOD: u8 = 0x08;
pub(crate) const ID: u8 = 0x09;

#[derive(Clone, Copy)]
pub(crate) struct Bit {
    register: u8,
    number: u8,
}

impl Bit {
    const fn new(register: u8, number: u8) -> Self {
        Self { register, number }
    }
}

/// SPI interface time-out of 256 tCLK instead of 4096.
pub(crate) const SPIRST: Bit = Bit::new(CONFIG0, 6);
/// Fixed channel instead of auto-scan.
pub(crate) const MUXMOD: Bit = Bit::new(CONFIG0, 5);
/// External ADC inputs instead of the multiplexer's.
pub(crate) const BYPAS: Bit = Bit::new(CONFIG0, 4);
pub(crate) const CHOP: Bit = Bit::new(CONFIG0, 2);
/// Status byte in front of a direct read.
pub(crate) const STAT: Bit = Bit::new(CONFIG0, 1);
/// Sleep instead of standby while idle.
pub(crate) const IDLMOD: Bit = Bit::new(CONFIG1, 7);

const RESET: [u8; REGISTERS] = [0x0A, 0x83, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x8B];

/// Bits that a write can change. Reserved bits read as 0 and ID is read-only.
const WRITABLE: [u8; REGISTERS] = [0x7E, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x3D, 0xFF, 0xFF, 0x00];

#[derive(Clone, Debug)]
pub(crate) struct Registers {
    bytes: [u8; REGISTERS],
    /// Levels on the GPIO pins that are inputs.
    pub(crate) gpio_inputs: u8,
    id: u8,
}

impl Registers {
    pub(crate) fn new(id: u8) -> Self {
        let mut registers = Self {
            bytes: RESET,
            gpio_inputs: 0,
            id,
        };
        registers.reset();
        registers
    }

    pub(crate) fn reset(&mut self) {
        self.bytes = RESET;
        self.bytes[usize::from(ID)] = self.id;
    }

    pub(crate) fn read(&self, address: u8) -> Option<u8> {
        let byte = *self.bytes.get(usize::from(address))?;
        // GPIOD reads the pins: the driven level where GPIOC selects output (0), else the external
        // level.
        Some(if address == GPIOD {
            (byte & !self.byte(GPIOC)) | (self.gpio_inputs & self.byte(GPIOC))
        } else {
            byte
        })
    }

    /// Writes a register over SPI: read-only and reserved bits keep their value, and addresses
    /// above 09h are ignored.
    pub(crate) fn write(&mut self, address: u8, value: u8) {
        let at = usize::from(address);
        if let (Some(byte), Some(&mask)) = (self.bytes.get_mut(at), WRITABLE.get(at)) {
            *byte = (*byte & !mask) | (value & mask);
        }
    }

    /// Inverts any bits, even read-only ones: a fault, not a write.
    pub(crate) fn invert(&mut self, address: u8, mask: u8) {
        if let Some(byte) = self.bytes.get_mut(usize::from(address)) {
            *byte ^= mask;
        }
    }

    pub(crate) fn byte(&self, address: u8) -> u8 {
        self.bytes[usize::from(address)]
    }

    pub(crate) fn bit(&self, bit: Bit) -> bool {
        self.byte(bit.register) & (1 << bit.number) != 0
    }

    /// DLY[2:0], 0 to 7.
    pub(crate) fn dly(&self) -> u8 {
        (self.byte(CONFIG1) >> 4) & 7
    }

    /// DRATE[1:0], 0 (slowest) to 3.
    pub(crate) fn drate(&self) -> u8 {
        self.byte(CONFIG1) & 3
    }
}
