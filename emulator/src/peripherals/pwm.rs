//! TIM10 as a clock source: channel 1 in PWM mode 1, counting up, nothing preloaded (RM0090,
//! 19.3.10 and 19.5).

const CEN: u32 = 1;
const CC1E: u32 = 1;
/// CCMR1: OC1 is an output, high while the counter is below CCR1.
const PWM_MODE_1: u32 = 6 << 4;

pub struct Pwm {
    cr1: u32,
    ccmr1: u32,
    ccer: u32,
    arr: u32,
    ccr1: u32,
}

impl Default for Pwm {
    fn default() -> Self {
        Self {
            cr1: 0,
            ccmr1: 0,
            ccer: 0,
            arr: 0xFFFF,
            ccr1: 0,
        }
    }
}

/// Output of the channel, in timer clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wave {
    pub period: u32,
    pub high: u32,
}

impl Pwm {
    /// Output of the channel, if it has edges.
    pub fn wave(&self) -> Option<Wave> {
        let runs = self.cr1 & CEN != 0 && self.ccer & CC1E != 0 && self.ccmr1 == PWM_MODE_1;
        let wave = Wave {
            period: self.arr + 1,
            high: self.ccr1,
        };
        (runs && (1..wave.period).contains(&wave.high)).then_some(wave)
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x0C | 0x28 => 0,
            0x18 => self.ccmr1,
            0x20 => self.ccer,
            0x2C => self.arr,
            0x34 => self.ccr1,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 if value & !CEN == 0 => self.cr1 = value,
            0x18 if value == 0 || value == PWM_MODE_1 => self.ccmr1 = value,
            0x20 if value & !CC1E == 0 => self.ccer = value,
            // Requests and a prescaler are not modelled.
            0x0C | 0x28 if value == 0 => {}
            0x2C => self.arr = value & 0xFFFF,
            0x34 => self.ccr1 = value & 0xFFFF,
            _ => return None,
        }
        Some(())
    }
}
