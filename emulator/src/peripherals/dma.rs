//! Stream 0 of DMA2 from a peripheral to memory, in direct mode (RM0090, 9.3 and 9.5). A transfer
//! takes no time.
//!
//! Not modelled: the other streams, other directions, bursts, the FIFO.

use crate::findings::Rule;

const EN: u32 = 1;
const TEIE: u32 = 1 << 2;
const HTIE: u32 = 1 << 3;
const TCIE: u32 = 1 << 4;
const CIRC: u32 = 1 << 8;
const MINC: u32 = 1 << 10;
const DBM: u32 = 1 << 18;
const CT: u32 = 1 << 19;
/// Direction, sizes, increments and channel.
const KIND: u32 = 3 << 6 | 1 << 9 | MINC | 3 << 11 | 3 << 13 | 7 << 25;
/// From a peripheral to memory that is counted up, half words both, channel 0.
const ADC1_KIND: u32 = MINC | 1 << 11 | 1 << 13;
/// Flags of stream 0.
const TEIF: u32 = 1 << 3;
const HTIF: u32 = 1 << 4;
const TCIF: u32 = 1 << 5;
const FLAGS: u32 = 0x3D;
/// FCR after a reset: the FIFO is empty.
const FCR: u32 = 0x21;

/// ADC1's data register, and where the DMA reaches memory: CCM is not on its bus.
const ADC1_DR: u32 = 0x4001_204C;
const RAM: u32 = 0x2000_0000;
const RAM_BYTES: u32 = 128 << 10;

/// Processor cycles from EN's zero until the stream has stopped: its transfer under way.
const STOP_CYCLES: u64 = 8;

pub struct Stream {
    flags: u32,
    cr: u32,
    /// Transfers left, and those of a round.
    left: u32,
    count: u32,
    par: u32,
    memory: [u32; 2],
    fcr: u32,
    /// When EN reads as zero, once that is written, cycles; and whether somebody has seen it.
    stops: Option<u64>,
    has_seen_stop: bool,
}

impl Stream {
    pub const fn new() -> Self {
        Self {
            flags: 0,
            cr: 0,
            left: 0,
            count: 0,
            par: 0,
            memory: [0; 2],
            fcr: FCR,
            stops: None,
            has_seen_stop: true,
        }
    }

    pub fn is_on(&self) -> bool {
        self.cr & EN != 0 && self.stops.is_none()
    }

    pub fn is_requested(&self) -> bool {
        let enabled = [(TEIE, TEIF), (HTIE, HTIF), (TCIE, TCIF)];
        let is_up = |(enable, flag)| self.cr & enable != 0 && self.flags & flag != 0;
        enabled.into_iter().any(is_up)
    }

    /// Transfers until the next that raises an interrupt; none if none will.
    pub fn transfers_to_event(&self) -> Option<u64> {
        let half = self.count / 2;
        let to_half = (self.cr & HTIE != 0 && self.left > half).then(|| self.left - half);
        let to_end = (self.cr & TCIE != 0).then_some(self.left);
        let next = to_half.into_iter().chain(to_end).min();
        next.filter(|_| self.is_on()).map(u64::from)
    }

    /// Where the next transfer goes, and whether the count reaches zero with it. None: the stream is
    /// off.
    pub fn transfer(&mut self) -> Option<(u32, bool)> {
        if !self.is_on() || self.left == 0 {
            return None;
        }
        let target = usize::from(self.cr & DBM != 0 && self.cr & CT != 0);
        let address = self.memory[target] + 2 * (self.count - self.left);
        self.left -= 1;
        if self.left == self.count / 2 {
            self.flags |= HTIF;
        }
        let is_last = self.left == 0;
        if is_last {
            self.flags |= TCIF;
            if self.cr & (CIRC | DBM) != 0 {
                self.left = self.count;
            } else {
                self.cr &= !EN;
            }
            if self.cr & DBM != 0 {
                self.cr ^= CT;
            }
        }
        Some((address, is_last))
    }

    /// A transfer failed on the bus: the stream stops (9.3.19).
    pub fn fail(&mut self) {
        self.flags |= TEIF;
        self.cr &= !EN;
    }

    pub fn read(&mut self, offset: u32, now: u64) -> Option<u32> {
        self.end_stop(now);
        self.has_seen_stop |= offset == 0x10 && self.cr & EN == 0;
        Some(match offset {
            0x00 => self.flags,
            0x04 => 0,
            0x10 => self.cr,
            0x14 => self.left,
            0x18 => self.par,
            0x1C | 0x20 => self.memory[(offset as usize - 0x1C) / 4],
            0x24 => self.fcr,
            _ => return None,
        })
    }

    fn end_stop(&mut self, now: u64) {
        if self.stops.take_if(|stops| *stops <= now).is_some() {
            self.cr &= !EN;
            // Stopped midway it says that it is complete (9.3.14).
            self.flags |= TCIF;
        }
    }

    /// Writes a register; what is wrong with that, if anything. `sequence`: conversions of the
    /// converter's sequence.
    pub fn write(&mut self, offset: u32, value: u32, now: u64, sequence: u32) -> Option<Broken> {
        self.end_stop(now);
        let is_on = self.cr & EN != 0;
        let locked = is_on.then(|| {
            let detail = format!("DMA register {offset:#x} is written while the stream is on");
            (Rule::DmaEnabled, detail)
        });
        Some(match offset {
            0x08 => {
                self.flags &= !(value & FLAGS);
                None
            }
            0x0C => None,
            0x10 if is_on => {
                // Interrupts and EN alone may change.
                let changed = (self.cr ^ value) & !(EN | 0x1E);
                if value & EN == 0 && self.stops.is_none() {
                    (self.stops, self.has_seen_stop) = (Some(now + STOP_CYCLES), false);
                }
                self.cr = self.cr & !0x1E | value & 0x1E;
                locked.filter(|_| changed != 0)
            }
            0x10 => {
                // No flow by the peripheral, no bursts.
                if value & 0xF1A0_0020 != 0 {
                    return None;
                }
                self.cr = value;
                let begins = value & EN != 0;
                (self.count, self.left) = (self.left, self.left);
                begins.then(|| self.check(sequence)).flatten()
            }
            0x14 => {
                if !is_on {
                    self.left = value & 0xFFFF;
                }
                locked
            }
            0x18 => {
                self.par = value;
                locked
            }
            0x1C | 0x20 => {
                self.memory[(offset as usize - 0x1C) / 4] = value;
                locked
            }
            // Direct mode.
            0x24 if value & 4 == 0 => {
                self.fcr = FCR & !3 | value & 3;
                locked
            }
            _ => return None,
        })
    }

    /// The rules for a stream that is switched on.
    fn check(&self, sequence: u32) -> Broken {
        let Self {
            cr,
            left,
            par,
            memory,
            ..
        } = *self;
        let used = if cr & DBM != 0 {
            &memory[..]
        } else {
            &memory[..1]
        };
        let fits = |start: &u32| {
            start.is_multiple_of(2)
                && (RAM..RAM + RAM_BYTES).contains(start)
                && start + 2 * left <= RAM + RAM_BYTES
        };
        // Half a round is whole scans, so that each place of the buffer is one input's.
        let round = if cr & DBM != 0 {
            sequence
        } else {
            2 * sequence
        };
        if !self.has_seen_stop {
            Some((
                Rule::DmaStop,
                "EN is set before it was seen to be zero".into(),
            ))
        } else if self.flags != 0 {
            let detail = format!("the stream starts with flags {:#x}", self.flags);
            Some((Rule::DmaFlags, detail))
        } else if cr & KIND != ADC1_KIND || par != ADC1_DR {
            let detail = format!("CR {cr:#010x} and PAR {par:#010x} do not fit ADC1's DR");
            Some((Rule::DmaSetting, detail))
        } else if left == 0 || !left.is_multiple_of(round) || !used.iter().all(fits) {
            let detail = format!("{left} half words to {memory:x?} for {sequence} inputs");
            Some((Rule::DmaSetting, detail))
        } else {
            None
        }
    }
}

/// A broken rule, if one is.
pub type Broken = Option<(Rule, String)>;
