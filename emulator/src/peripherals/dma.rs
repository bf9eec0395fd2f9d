//! A stream of a DMA controller from a peripheral to memory, in direct mode (RM0090, 9.3 and 9.5).
//! A transfer takes no time.
//!
//! Only the streams that the boards need are modelled, each as a separate controller: for ADC1 and
//! for the serial line's receiver. Not modelled: other directions, bursts, the FIFO.

use crate::findings::Rule;

/// Offsets of a stream's registers from its CR.
const CR: u32 = 0x00;
const NDTR: u32 = 0x04;
const PAR: u32 = 0x08;
const M0AR: u32 = 0x0C;
const M1AR: u32 = 0x10;
const FIFO: u32 = 0x14;

const EN: u32 = 1;
const TEIE: u32 = 1 << 2;
const HTIE: u32 = 1 << 3;
const TCIE: u32 = 1 << 4;
const CIRC: u32 = 1 << 8;
const MINC: u32 = 1 << 10;
const DBM: u32 = 1 << 18;
const CT: u32 = 1 << 19;
/// CR bits of the direction, sizes, increments and channel.
const KIND: u32 = 3 << 6 | 1 << 9 | MINC | 3 << 11 | 3 << 13 | 7 << 25;
/// Flags of a stream, relative to its first bit in the status register.
const TEIF: u32 = 1 << 3;
const HTIF: u32 = 1 << 4;
const TCIF: u32 = 1 << 5;
const FLAGS: u32 = 0x3D;
/// FCR after a reset: the FIFO is empty.
const FCR: u32 = 0x21;

/// Memory that the DMA can access: CCM is not on its bus.
const RAM: u32 = 0x2000_0000;
const RAM_BYTES: u32 = 128 << 10;

/// Processor cycles from clearing EN until the stream has stopped, the duration of a transfer.
const STOP_CYCLES: u64 = 8;

/// Source of a stream's data: required register values and stream number (RM0090, tables 42 and
/// 43).
struct Source {
    number: u32,
    name: &'static str,
    data: u32,
    /// CR bits: peripheral to memory with increment, both sizes, and the channel.
    kind: u32,
    bytes: u32,
}

/// Half words on channel 0.
const ADC1: Source = Source {
    number: 0,
    name: "ADC1",
    data: 0x4001_204C,
    kind: MINC | 1 << 11 | 1 << 13,
    bytes: 2,
};

/// Bytes on channel 4.
const USART2_RX: Source = Source {
    number: 5,
    name: "USART2",
    data: 0x4000_4404,
    kind: MINC | 4 << 25,
    bytes: 1,
};

const USART3_RX: Source = Source {
    number: 1,
    name: "USART3",
    data: 0x4000_4804,
    ..USART2_RX
};

pub struct Stream {
    source: &'static Source,
    flags: u32,
    cr: u32,
    /// Transfers left in this round, and transfers per round.
    left: u32,
    count: u32,
    par: u32,
    memory: [u32; 2],
    fcr: u32,
    /// Cycle from which a cleared EN reads as zero; and true once software has read it as zero.
    stops: Option<u64>,
    has_seen_stop: bool,
}

impl Stream {
    /// Creates stream 0 of DMA2, for ADC1.
    pub const fn adc1() -> Self {
        Self::of(&ADC1)
    }

    /// Creates the DMA1 stream for a USART's receiver.
    pub const fn receiver(usart: u8) -> Self {
        Self::of(if usart == 2 { &USART2_RX } else { &USART3_RX })
    }

    const fn of(source: &'static Source) -> Self {
        Self {
            source,
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

    pub fn reset(&mut self) {
        *self = Self::of(self.source);
    }

    /// Interrupt number (RM0090, table 61).
    pub const fn irq(&self) -> u16 {
        match self.source.number {
            0 => 56,
            1 => 12,
            _ => 16,
        }
    }

    /// Offset of the status register with the stream's flags, and number of the first flag's bit.
    const fn status(&self) -> (u32, u32) {
        let number = self.source.number;
        (4 * (number / 4), [0, 6, 16, 22][number as usize % 4])
    }

    /// Returns a register's offset from the stream's CR; a large number for the controller's own
    /// registers.
    const fn own(&self, offset: u32) -> u32 {
        offset.wrapping_sub(0x10 + 0x18 * self.source.number)
    }

    pub fn is_on(&self) -> bool {
        self.cr & EN != 0 && self.stops.is_none()
    }

    pub fn is_requested(&self) -> bool {
        let enabled = [(TEIE, TEIF), (HTIE, HTIF), (TCIE, TCIF)];
        let is_up = |(enable, flag)| self.cr & enable != 0 && self.flags & flag != 0;
        enabled.into_iter().any(is_up)
    }

    /// Number of transfers until the next interrupt; `None` if there will be none.
    pub fn transfers_to_event(&self) -> Option<u64> {
        let half = self.count / 2;
        let to_half = (self.cr & HTIE != 0 && self.left > half).then(|| self.left - half);
        let to_end = (self.cr & TCIE != 0).then_some(self.left);
        let next = to_half.into_iter().chain(to_end).min();
        next.filter(|_| self.is_on()).map(u64::from)
    }

    /// Makes a transfer. Returns its address, and true if it was the last of its round; `None` if
    /// the stream is off.
    pub fn transfer(&mut self) -> Option<(u32, bool)> {
        if !self.is_on() || self.left == 0 {
            return None;
        }
        let target = usize::from(self.cr & DBM != 0 && self.cr & CT != 0);
        let address = self.memory[target] + self.source.bytes * (self.count - self.left);
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

    /// Stops the stream because a transfer failed on the bus (9.3.19).
    pub fn fail(&mut self) {
        self.flags |= TEIF;
        self.cr &= !EN;
    }

    pub fn read(&mut self, offset: u32, now: u64) -> Option<u32> {
        self.end_stop(now);
        if offset < 8 {
            let (register, bit) = self.status();
            return Some(if offset == register {
                self.flags << bit
            } else {
                0
            });
        }
        let offset = self.own(offset);
        self.has_seen_stop |= offset == CR && self.cr & EN == 0;
        Some(match offset {
            CR => self.cr,
            NDTR => self.left,
            PAR => self.par,
            M0AR | M1AR => self.memory[((offset - M0AR) / 4) as usize],
            FIFO => self.fcr,
            _ => return None,
        })
    }

    fn end_stop(&mut self, now: u64) {
        if self.stops.take_if(|stops| *stops <= now).is_some() {
            self.cr &= !EN;
            // A stream that is stopped midway sets the transfer-complete flag (9.3.14).
            self.flags |= TCIF;
        }
    }

    /// Writes a register and returns the broken rule, if any. `sequence` is the number of transfers
    /// that belong together, such as the conversions of the ADC's sequence.
    pub fn write(&mut self, offset: u32, value: u32, now: u64, sequence: u32) -> Option<Broken> {
        self.end_stop(now);
        let is_on = self.cr & EN != 0;
        let locked = is_on.then(|| {
            let detail = format!("DMA register {offset:#x} is written while the stream is on");
            (Rule::DmaEnabled, detail)
        });
        if let 0x08 | 0x0C = offset {
            let (register, bit) = self.status();
            if offset == register + 8 {
                self.flags &= !(value >> bit & FLAGS);
            }
            return Some(None);
        }
        let offset = self.own(offset);
        Some(match offset {
            CR if is_on => {
                // Only interrupts and EN may change.
                let changed = (self.cr ^ value) & !(EN | 0x1E);
                if value & EN == 0 && self.stops.is_none() {
                    (self.stops, self.has_seen_stop) = (Some(now + STOP_CYCLES), false);
                }
                self.cr = self.cr & !0x1E | value & 0x1E;
                locked.filter(|_| changed != 0)
            }
            CR => {
                // Flow control by the peripheral and bursts are not modelled.
                if value & 0xF1A0_0020 != 0 {
                    return None;
                }
                self.cr = value;
                let begins = value & EN != 0;
                (self.count, self.left) = (self.left, self.left);
                begins.then(|| self.check(sequence)).flatten()
            }
            NDTR => {
                if !is_on {
                    self.left = value & 0xFFFF;
                }
                locked
            }
            PAR => {
                self.par = value;
                locked
            }
            M0AR | M1AR => {
                self.memory[((offset - M0AR) / 4) as usize] = value;
                locked
            }
            // Direct mode only.
            FIFO if value & 4 == 0 => {
                self.fcr = FCR & !3 | value & 3;
                locked
            }
            _ => return None,
        })
    }

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
        let Source {
            name,
            data,
            kind,
            bytes,
            ..
        } = *self.source;
        let fits = |start: &u32| {
            start.is_multiple_of(bytes)
                && (RAM..RAM + RAM_BYTES).contains(start)
                && start + bytes * left <= RAM + RAM_BYTES
        };
        // Half a round must be whole scans, so that each position in the buffer belongs to one
        // input.
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
        } else if cr & KIND != kind || par != data {
            let detail = format!("CR {cr:#010x} and PAR {par:#010x} do not fit {name}'s DR");
            Some((Rule::DmaSetting, detail))
        } else if left == 0 || !left.is_multiple_of(round) || !used.iter().all(fits) {
            let detail = format!("{left} transfers to {memory:x?}, {sequence} at a time");
            Some((Rule::DmaSetting, detail))
        } else {
            None
        }
    }
}

pub type Broken = Option<(Rule, String)>;
