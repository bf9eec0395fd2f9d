//! TIM2, TIM4 and TIM6, counting up and wrapping (RM0090, 18.4 and 20.4).

const CEN: u32 = 1;
const UIF: u32 = 1;
/// CR2: the update is TRGO.
const MMS_UPDATE: u32 = 2 << 4;

pub struct Timer {
    /// Maximum of the counter: 16 or 32 bits.
    top: u32,
    cr1: u32,
    cr2: u32,
    dier: u32,
    has_wrapped: bool,
    /// Prescaler written, and prescaler in use.
    psc: [u32; 2],
    arr: u32,
    is_arr_written: bool,
    /// Counter and the cycle at which it had this value.
    from: (u32, u64),
}

impl Timer {
    /// Creates a timer. `top` is the counter's maximum, and ARR after a reset (all ones in RM0090,
    /// but zero in the register descriptions).
    pub const fn new(top: u32) -> Self {
        let (psc, from) = ([0; 2], (0, 0));
        Self {
            top,
            cr1: 0,
            cr2: 0,
            dier: 0,
            has_wrapped: false,
            psc,
            arr: top,
            is_arr_written: false,
            from,
        }
    }

    pub fn reset(&mut self) {
        *self = Self::new(self.top);
    }

    /// True if the timer runs and its reload register was never written.
    pub fn runs_unset(&self) -> bool {
        self.cr1 & CEN != 0 && !self.is_arr_written
    }

    /// Processor cycles per count; `ratio` is processor cycles per timer clock.
    fn cycles_per_count(&self, ratio: u64) -> u64 {
        u64::from(self.psc[1] + 1) * ratio
    }

    /// Returns the counter, and the number of wraps since `from`.
    fn count(&self, now: u64, ratio: u64) -> (u32, u64) {
        let passed = if self.cr1 & CEN == 0 {
            0
        } else {
            (now - self.from.1) / self.cycles_per_count(ratio)
        };
        let (sum, period) = (u64::from(self.from.0) + passed, u64::from(self.arr) + 1);
        // A reload value of zero stops the counter.
        if self.arr == 0 {
            (0, 0)
        } else {
            ((sum % period) as u32, sum / period)
        }
    }

    /// True if each wrap triggers another peripheral.
    pub fn triggers(&self) -> bool {
        self.cr2 == MMS_UPDATE
    }

    /// Cycle of the next wrap, if it causes an interrupt or a trigger.
    pub fn next_event(&self, ratio: u64) -> Option<u64> {
        let wakes =
            self.cr1 & CEN != 0 && (self.dier & UIF != 0 || self.triggers()) && self.arr != 0;
        let left = (u64::from(self.arr) + 1).saturating_sub(self.from.0.into());
        wakes.then(|| self.from.1 + left * self.cycles_per_count(ratio))
    }

    /// Counts until now. Returns the cycle of the latest wrap.
    pub fn advance(&mut self, now: u64, ratio: u64) -> Option<u64> {
        let (_, wraps) = self.count(now, ratio);
        if wraps > 0 {
            self.has_wrapped = true;
            let whole = (u64::from(self.arr) + 1) * wraps - u64::from(self.from.0);
            self.from = (0, self.from.1 + whole * self.cycles_per_count(ratio));
        }
        (wraps > 0).then_some(self.from.1)
    }

    pub fn restart(&mut self, value: u32, now: u64) {
        self.from = (value, now);
    }

    pub fn is_requested(&self) -> bool {
        self.has_wrapped && self.dier & UIF != 0
    }

    pub fn read(&self, offset: u32, now: u64, ratio: u64) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => 0,
            0x0C => self.dier,
            0x10 => self.has_wrapped.into(),
            0x24 => self.count(now, ratio).0,
            0x28 => self.psc[0],
            0x2C => self.arr,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32, now: u64, ratio: u64) -> Option<()> {
        let (count, _) = self.count(now, ratio);
        match offset {
            // Counting down, one-pulse mode and similar are not modelled; ARPE and URS have no
            // effect here.
            0x00 if value & !0x85 == 0 => {
                self.cr1 = value;
                self.restart(count, now);
            }
            0x04 if value == 0 || value == MMS_UPDATE => self.cr2 = value,
            0x08 if value == 0 => {}
            0x0C if value & !UIF == 0 => self.dier = value,
            0x10 => self.has_wrapped &= value & UIF != 0,
            0x14 if value == 1 => {
                self.psc[1] = self.psc[0];
                self.has_wrapped |= self.cr1 & 4 == 0;
                self.restart(0, now);
            }
            0x24 => self.restart(value & self.top, now),
            0x28 => self.psc[0] = value & 0xFFFF,
            0x2C => {
                self.arr = value & self.top;
                self.is_arr_written = true;
                self.restart(count, now);
            }
            _ => return None,
        }
        Some(())
    }
}
