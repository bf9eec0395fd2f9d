//! ADC1 in scan mode, one conversion after the other (RM0090, 13.3 to 13.13; RM0390, 13), with the
//! common register of the prescaler. A conversion samples its input at the end of the sampling
//! time, and is ready 12 periods later.
//!
//! Not modelled: injected conversions, triggers, watchdogs, 10 bits and fewer, interrupts, ADC2 and
//! ADC3.

use crate::findings::Rule;

const EOC: u32 = 1 << 1;
const STRT: u32 = 1 << 4;
const OVR: u32 = 1 << 5;
const SCAN: u32 = 1 << 8;
const ADON: u32 = 1;
const CONT: u32 = 1 << 1;
const DMA: u32 = 1 << 8;
const DDS: u32 = 1 << 9;
const EOCS: u32 = 1 << 10;
const SWSTART: u32 = 1 << 30;
const ADCPRE: u32 = 3 << 16;

/// Maximum time from ADON to the first conversion, nanoseconds: tSTAB (DS8626 and DS10693, ADC
/// characteristics).
const SETTLING_NS: u64 = 3000;
/// Maximum clock, hertz (the same tables, above 2.4 V).
const CLOCK_MAX_HZ: u64 = 36_000_000;
/// Periods to convert twelve bits.
const BITS: u64 = 12;
/// Sampling times by SMP, periods.
const SAMPLING: [u64; 8] = [3, 15, 28, 56, 84, 112, 144, 480];

pub struct Converted {
    pub channel: u8,
    pub sampled: u64,
}

#[derive(Default)]
pub struct OwnAdc {
    sr: u32,
    cr1: u32,
    cr2: u32,
    smpr: [u32; 2],
    sqr: [u32; 3],
    ccr: u32,
    data: u16,
    /// Time at which ADON was set, nanoseconds.
    on_ns: u64,
    /// Current conversion: its position in the sequence, and the cycle of its start.
    converts: Option<(u32, u64)>,
    has_request: bool,
    /// True if the DMA has made its last transfer, so that no more requests follow.
    is_drained: bool,
}

impl OwnAdc {
    /// Returns all three ADCs to the state after a reset.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    pub fn is_converting(&self) -> bool {
        self.converts.is_some()
    }

    /// Divider from APB2's clock.
    pub const fn divider(&self) -> u64 {
        2 * (1 + (self.ccr >> 16 & 3) as u64)
    }

    pub const fn sequence_length(&self) -> u32 {
        if self.cr1 & SCAN == 0 {
            1
        } else {
            1 + (self.sqr[0] >> 20 & 15)
        }
    }

    /// Channel at a position of the sequence: SQR3 and SQR2 hold six each, SQR1 four.
    pub const fn channel(&self, place: u32) -> u8 {
        let register = self.sqr[2 - (place / 6) as usize];
        (register >> (5 * (place % 6)) & 31) as u8
    }

    fn sampling(&self, channel: u8) -> u64 {
        let (register, place) = if channel >= 10 {
            (self.smpr[0], channel - 10)
        } else {
            (self.smpr[1], channel)
        };
        SAMPLING[(register >> (3 * place) & 7) as usize]
    }

    /// Cycle at which the next `conversions` conversions are ready; `None` if there will be fewer.
    pub fn ready_after(&self, conversions: u64, tick: u64) -> Option<u64> {
        let (mut place, mut at) = self.converts?;
        for left in (0..conversions).rev() {
            at += (self.sampling(self.channel(place)) + BITS) * tick;
            place = (place + 1) % self.sequence_length();
            if place == 0 && left > 0 && self.cr2 & CONT == 0 {
                return None;
            }
        }
        Some(at)
    }

    /// Ends the current conversion if it is due, and begins the next. `tick` is a period in
    /// processor cycles.
    pub fn advance(&mut self, now: u64, tick: u64) -> Option<Converted> {
        let (place, begun) = self.converts?;
        let channel = self.channel(place);
        let sampled = begun + self.sampling(channel) * tick;
        let ready = sampled + BITS * tick;
        if ready > now {
            return None;
        }
        let is_last = place + 1 >= self.sequence_length();
        let goes_on = !is_last || self.cr2 & CONT != 0;
        let next = if is_last { 0 } else { place + 1 };
        self.converts = goes_on.then_some((next, ready));
        Some(Converted { channel, sampled })
    }

    /// Puts a result into DR. If DR holds an unread result and the DMA or EOCS is on, there is an
    /// overrun: conversions stop, and the DMA gets no more requests (13.8.1). Returns true if a DMA
    /// request is made.
    pub fn finish(&mut self, data: u16) -> bool {
        if self.has_request && self.cr2 & (DMA | EOCS) != 0 {
            self.overrun();
            return false;
        }
        self.data = data;
        self.sr |= EOC;
        self.has_request = self.cr2 & DMA != 0;
        self.has_request && !self.is_drained
    }

    /// Sets the overrun: a result is lost.
    pub fn overrun(&mut self) {
        self.sr |= OVR;
        self.converts = None;
        self.has_request = false;
        self.is_drained = true;
    }

    pub const fn has_overrun(&self) -> bool {
        self.sr & OVR != 0
    }

    /// Reads DR by DMA. `is_last` is true if the DMA's count has reached zero.
    pub fn transfer(&mut self, is_last: bool) -> u16 {
        self.has_request = false;
        self.is_drained |= is_last && self.cr2 & DDS == 0;
        self.take()
    }

    fn take(&mut self) -> u16 {
        self.sr &= !EOC;
        self.data
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.sr,
            0x04 => self.cr1,
            0x08 => self.cr2,
            0x0C | 0x10 => self.smpr[(offset as usize - 0x0C) / 4],
            0x2C..=0x34 => self.sqr[(offset as usize - 0x2C) / 4],
            0x4C => {
                self.has_request = false;
                self.take().into()
            }
            0x304 => self.ccr,
            _ => return None,
        })
    }

    /// Writes a register and returns the broken rule, if any.
    pub fn write(&mut self, offset: u32, value: u32, now: Now) -> Option<Option<(Rule, String)>> {
        let mut broken = None;
        match offset {
            // Flags are cleared by writing zeros.
            0x00 => self.sr &= value,
            0x04 if value & !SCAN == 0 => {
                broken = self.changes(offset, self.cr1 != value);
                self.cr1 = value;
            }
            // Triggers, injected conversions and left alignment are not modelled.
            0x08 if value & !(ADON | CONT | DMA | DDS | EOCS | SWSTART) == 0 => {
                broken = self.control(value, now);
            }
            0x0C | 0x10 => {
                let at = (offset as usize - 0x0C) / 4;
                broken = self.changes(offset, self.smpr[at] != value);
                self.smpr[at] = value & 0x3FFF_FFFF;
            }
            0x2C..=0x34 => {
                let at = (offset as usize - 0x2C) / 4;
                broken = self.changes(offset, self.sqr[at] != value);
                self.sqr[at] = value & 0x3FFF_FFFF;
            }
            0x304 if value & !ADCPRE == 0 => {
                broken = self.changes(offset, self.ccr != value);
                self.ccr = value;
            }
            _ => return None,
        }
        Some(broken)
    }

    /// Sequence, sampling times and clock must not change while the ADC converts (13.3.3, 13.13).
    fn changes(&self, offset: u32, does: bool) -> Option<(Rule, String)> {
        let is_broken = does && self.is_converting();
        is_broken.then(|| {
            let detail = format!("ADC register {offset:#x} is changed while it converts");
            (Rule::AdcSequence, detail)
        })
    }

    fn control(&mut self, value: u32, now: Now) -> Option<(Rule, String)> {
        if value & !self.cr2 & ADON != 0 {
            self.on_ns = now.ns;
        }
        self.cr2 = value & !SWSTART;
        if value & DMA == 0 {
            (self.has_request, self.is_drained) = (false, false);
        }
        if value & ADON == 0 {
            self.converts = None;
            return None;
        }
        if value & SWSTART == 0 || self.is_converting() || self.has_overrun() {
            return None;
        }
        self.sr |= STRT;
        self.converts = Some((0, now.cycles));
        let (since_ns, adc_hz) = (now.ns - self.on_ns, now.apb_hz / self.divider());
        if since_ns < SETTLING_NS {
            let detail = format!("SWSTART {since_ns} ns after ADON");
            Some((Rule::AdcSettling, detail))
        } else if adc_hz > CLOCK_MAX_HZ {
            Some((Rule::ClockLimit, format!("the ADC has {adc_hz} Hz")))
        } else {
            None
        }
    }
}

#[derive(Clone, Copy)]
pub struct Now {
    pub cycles: u64,
    pub ns: u64,
    pub apb_hz: u64,
}
