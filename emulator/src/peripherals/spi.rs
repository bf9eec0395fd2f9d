//! SPI1 as a full-duplex master, bit by bit in time (RM0090, 28.5).

const CPHA: u32 = 1;
const CPOL: u32 = 2;
const MSTR: u32 = 4;
const SPE: u32 = 1 << 6;
const LSBFIRST: u32 = 1 << 7;

const RXNE: u32 = 1;
const TXE: u32 = 2;
const OVR: u32 = 1 << 6;
const BSY: u32 = 1 << 7;

#[derive(Default)]
pub struct Spi {
    cr1: u32,
    cr2: u32,
    received: Option<u8>,
    overrun: bool,
    /// True if DR was read after the overrun.
    overrun_read: bool,
    /// Byte waiting for the shift register.
    waiting: Option<u8>,
    /// Answer to the byte in the shift register, until its last bit is sampled, and the cycle of
    /// that sample.
    incoming: Option<(u8, u64)>,
    /// Cycle at which the byte in the shift register ends, half a bit after its last sample.
    shifting: Option<u64>,
    /// True if BSY clears at the sample of the last bit, half a bit before its end, as users have
    /// measured (`Start::bsy_is_early`).
    pub bsy_is_early: bool,
    pub overruns: u64,
}

impl Spi {
    /// Returns to the state after a reset, but keeps the overrun count.
    pub fn reset(&mut self) {
        *self = Self {
            overruns: self.overruns,
            bsy_is_early: self.bsy_is_early,
            ..Self::default()
        };
    }

    pub fn is_on(&self) -> bool {
        self.cr1 & SPE != 0
    }

    /// True if SPI is a full-duplex master in mode 0 with 8 bits, most significant bit first.
    pub fn fits_adc(&self) -> bool {
        self.cr1 & (CPHA | CPOL | MSTR | LSBFIRST | 0xFC00) == MSTR
    }

    /// Number of APB clock cycles per cycle of SCLK.
    pub fn divider(&self) -> u64 {
        2 << (self.cr1 >> 3 & 7)
    }

    pub fn is_busy(&self) -> bool {
        self.shifting.is_some() || self.waiting.is_some()
    }

    fn seems_busy(&self) -> bool {
        let is_sampled = self.incoming.is_none() && self.waiting.is_none();
        self.is_busy() && !(self.bsy_is_early && is_sampled)
    }

    /// Takes the next byte to shift, if the shift register is free.
    pub fn take_next(&mut self) -> Option<u8> {
        if self.shifting.is_some() || !self.is_on() {
            None
        } else {
            self.waiting.take()
        }
    }

    /// Begins a byte, with the cycles of its last sample and of its end.
    pub fn begin(&mut self, incoming: u8, sampled: u64, end: u64) {
        (self.incoming, self.shifting) = (Some((incoming, sampled)), Some(end));
    }

    /// Cycle at which the current byte is received or ends.
    pub fn next_event(&self) -> Option<u64> {
        self.incoming.map(|(_, sampled)| sampled).or(self.shifting)
    }

    /// Receives and ends the current byte, if it is due.
    pub fn advance(&mut self, now: u64) {
        self.shifting.take_if(|end| *end <= now);
        if let Some((byte, _)) = self.incoming.take_if(|(_, sampled)| *sampled <= now) {
            if self.received.is_some() {
                (self.overrun, self.overrun_read) = (true, false);
                self.overruns += 1;
            } else {
                self.received = Some(byte);
            }
        }
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => {
                let flag = |is: bool, bit: u32| if is { bit } else { 0 };
                let status = flag(self.received.is_some(), RXNE)
                    | flag(self.waiting.is_none(), TXE)
                    | flag(self.overrun, OVR)
                    | flag(self.seems_busy(), BSY);
                // Reading DR and then SR clears OVR.
                if self.overrun_read {
                    (self.overrun, self.overrun_read) = (false, false);
                }
                status
            }
            0x0C => {
                self.overrun_read = self.overrun;
                self.received.take().unwrap_or(0).into()
            }
            0x10 => 7,
            0x14 | 0x18 | 0x1C => 0,
            0x20 => 2,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.cr1 = value & 0xFFFF,
            // Interrupts, DMA and the TI format are not modelled; SSOE has no effect on a master
            // that ignores NSS.
            0x04 if value & !4 == 0 => self.cr2 = value,
            0x0C => self.waiting = Some(value as u8),
            // I2SCFGR: SPI, not I2S.
            0x1C if value & 1 << 11 == 0 => {}
            _ => return None,
        }
        Some(())
    }
}
