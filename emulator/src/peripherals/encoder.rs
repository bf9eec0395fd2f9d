//! TIM3 as the counter of a quadrature encoder (RM0090, 18.3.12 and 18.4). The hand is a function
//! of time: its position in counts, four per encoder period. Individual edges and the input
//! filter's delay are not modelled.

const CEN: u32 = 1;
/// SMCR: encoder mode 3, which counts the edges of both channels.
const BOTH_CHANNELS: u32 = 3;
/// CCMR1: both channels are inputs, TI1 and TI2; any filter is allowed.
const INPUTS: u32 = 0x0101;

/// Returns the hand's position (counts) at a time in nanoseconds since power-up.
pub type Hand = Box<dyn Fn(u64) -> i64>;

pub struct Encoder {
    cr1: u32,
    smcr: u32,
    ccmr1: u32,
    arr: u32,
    /// Counter and hand position at the latest change of settings.
    from: (u32, i64),
    pub hand: Hand,
    /// Times at which the counter was read, nanoseconds.
    pub reads_ns: Vec<u64>,
}

impl Encoder {
    pub fn new() -> Self {
        let (hand, reads_ns): (Hand, _) = (Box::new(|_| 0), Vec::new());
        Self {
            cr1: 0,
            smcr: 0,
            ccmr1: 0,
            arr: 0xFFFF,
            from: (0, 0),
            hand,
            reads_ns,
        }
    }

    /// Returns the registers to the state after a reset. The hand keeps moving.
    pub fn reset(&mut self) {
        let hand = std::mem::replace(&mut self.hand, Box::new(|_| 0));
        *self = Self {
            hand,
            reads_ns: std::mem::take(&mut self.reads_ns),
            ..Self::new()
        };
    }

    pub fn is_on(&self) -> bool {
        self.cr1 & CEN != 0
    }

    /// True if edges reach the counter.
    fn counts(&self) -> bool {
        self.is_on() && self.smcr == BOTH_CHANNELS && self.ccmr1 & 0x0303 == INPUTS
    }

    fn count(&self, now_ns: u64) -> u32 {
        let moved = if self.counts() {
            (self.hand)(now_ns) - self.from.1
        } else {
            0
        };
        (i64::from(self.from.0) + moved).rem_euclid(i64::from(self.arr) + 1) as u32
    }

    pub fn read(&mut self, offset: u32, now_ns: u64) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x04 | 0x0C | 0x10 | 0x20 | 0x28 => 0,
            0x08 => self.smcr,
            0x18 => self.ccmr1,
            0x24 => {
                self.reads_ns.push(now_ns);
                self.count(now_ns)
            }
            0x2C => self.arr,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64) -> Option<()> {
        self.from = (self.count(now_ns), (self.hand)(now_ns));
        match offset {
            // Without encoder mode the counter would count its clock.
            0x00 if value == 0 || value == CEN && self.smcr == BOTH_CHANNELS => self.cr1 = value,
            0x08 if value == 0 || value == BOTH_CHANNELS => self.smcr = value,
            // A prescaler of the captures is not modelled.
            0x18 if value & !0xF3F3 == 0 => self.ccmr1 = value,
            // Inverted channels, a prescaler and requests are not modelled.
            0x04 | 0x0C | 0x20 | 0x28 if value == 0 => {}
            0x24 => self.from.0 = value & 0xFFFF,
            0x2C => self.arr = value & 0xFFFF,
            _ => return None,
        }
        Some(())
    }
}
