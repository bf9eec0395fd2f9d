//! Channel 1 of the digital-to-analogue converter, 12 bits, triggered by TIM6 (RM0090, 14.3 and
//! 14.5).

const EN1: u32 = 1;
const BOFF1: u32 = 1 << 1;
const TEN1: u32 = 1 << 2;

/// Change of the pin's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Time of the change, nanoseconds since power-up.
    pub at_ns: u64,
    /// Code in DOR1, 0 to 4095; `None` if the DAC is off and nothing drives the pin.
    pub code: Option<u16>,
}

#[derive(Default)]
pub struct Dac {
    cr: u32,
    dhr: u32,
    dor: u32,
    /// Outputs at each trigger, and when the DAC is switched on or off.
    pub outputs: Vec<Output>,
}

impl Dac {
    pub fn is_on(&self) -> bool {
        self.cr & EN1 != 0
    }

    /// Returns to the state after a reset: the pin is released.
    pub fn reset(&mut self, now_ns: u64) {
        let was_on = self.is_on();
        *self = Self {
            outputs: std::mem::take(&mut self.outputs),
            ..Self::default()
        };
        if was_on {
            self.outputs.push(Output {
                at_ns: now_ns,
                code: None,
            });
        }
    }

    /// Outputs the held code at `out_ns`, three cycles of APB1 after TIM6's update (14.3.4).
    pub fn trigger(&mut self, out_ns: u64) {
        if self.cr & (EN1 | TEN1) == EN1 | TEN1 {
            self.dor = self.dhr;
            self.outputs.push(Output {
                at_ns: out_ns,
                code: Some(self.dor as u16),
            });
        }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr,
            0x08 => self.dhr,
            0x2C => self.dor,
            0x30 | 0x34 => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64) -> Option<()> {
        match offset {
            // TSEL1 0: TIM6. Other triggers, waves, DMA, the second channel and output without a
            // trigger are not modelled.
            0x00 if value == 0 || value & !BOFF1 == EN1 | TEN1 || value & !BOFF1 == TEN1 => {
                let was_on = self.is_on();
                self.cr = value;
                if was_on != self.is_on() {
                    self.outputs.push(Output {
                        at_ns: now_ns,
                        code: self.is_on().then_some(self.dor as u16),
                    });
                }
            }
            0x08 => self.dhr = value & 0xFFF,
            _ => return None,
        }
        Some(())
    }
}
