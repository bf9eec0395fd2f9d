//! USART2 or USART3, byte by byte in time, with one data register each way; software or the DMA
//! fetches received bytes (RM0090, 30.3 and 30.6).

use std::collections::VecDeque;

const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
const ORE: u32 = 1 << 3;

const UE: u32 = 1 << 13;
const TE: u32 = 1 << 3;
const RE: u32 = 1 << 2;
/// CR3: the DMA fetches received bytes.
const DMAR: u32 = 1 << 6;

/// Delay from RXNE to the DMA's read of the data register, processor cycles: arbitration and the
/// bridge (from memory: AN4031).
const FETCH_CYCLES: u64 = 8;

pub struct Usart {
    cr: [u32; 3],
    brr: u32,
    /// Byte in the data register, and the cycle of its arrival.
    received: Option<(u8, u64)>,
    overrun: bool,
    /// True if SR was read while it showed the overrun.
    overrun_seen: bool,
    /// Idle flag: true if the line has been idle for the time of a byte since the last one; and
    /// true if SR was read while the flag was set.
    idle: bool,
    idle_seen: bool,
    /// Cycle at which the line becomes idle unless a byte begins before.
    idle_at: Option<u64>,
    waiting: Option<u8>,
    /// Byte being sent, and the cycle of its end.
    leaving: Option<(u8, u64)>,
    is_complete: bool,
    /// Bytes being received, with the cycle of their end.
    arriving: VecDeque<(u8, u64)>,
    /// Sent bytes, with the cycle of their end.
    pub sent: VecDeque<(u8, u64)>,
    pub overruns: u64,
    /// Number of bytes that arrived while the receiver was off.
    pub unheard: u64,
    /// Number of bytes taken by software or the DMA.
    pub taken: u64,
    /// Number of bytes read by software although the DMA was about to fetch them.
    pub stolen: u64,
}

impl Usart {
    pub const fn new() -> Self {
        Self {
            cr: [0; 3],
            brr: 0,
            received: None,
            overrun: false,
            overrun_seen: false,
            idle: false,
            idle_seen: false,
            idle_at: None,
            waiting: None,
            leaving: None,
            is_complete: true,
            arriving: VecDeque::new(),
            sent: VecDeque::new(),
            overruns: 0,
            unheard: 0,
            taken: 0,
            stolen: 0,
        }
    }

    /// Returns to the state after a reset. Bytes on the cable stay there.
    pub fn reset(&mut self) {
        let (arriving, sent) = (
            std::mem::take(&mut self.arriving),
            std::mem::take(&mut self.sent),
        );
        *self = Self {
            arriving,
            sent,
            overruns: self.overruns,
            unheard: self.unheard,
            taken: self.taken,
            stolen: self.stolen,
            ..Self::new()
        };
    }

    pub fn is_on(&self) -> bool {
        self.cr[0] & UE != 0
    }

    /// APB clock cycles in ten bits.
    pub fn byte_clocks(&self) -> u64 {
        // OVER8 is refused, so BRR is the divider itself.
        u64::from(self.brr) * 10
    }

    /// Schedules a byte whose last bit ends at cycle `end`.
    pub fn arrive(&mut self, byte: u8, end: u64) {
        self.arriving.push_back((byte, end));
    }

    /// Discards bytes that are still arriving, because the receiver has no clock.
    pub fn lose_arriving(&mut self) {
        self.unheard += self.arriving.drain(..).len() as u64;
    }

    /// Cycle at which the last arriving byte ends.
    pub fn last_arrival(&self) -> Option<u64> {
        self.arriving.back().map(|(_, end)| *end)
    }

    /// Cycle at which the DMA fetches the byte in the data register, if it is on.
    fn fetched_at(&self, dma_is_on: bool) -> Option<u64> {
        let fetched = self.received.map(|(_, arrived)| arrived + FETCH_CYCLES);
        fetched.filter(|_| dma_is_on && self.cr[2] & DMAR != 0)
    }

    pub fn next_event(&self, dma_is_on: bool) -> Option<u64> {
        [
            self.leaving.map(|(_, end)| end),
            self.arriving.front().map(|(_, end)| *end),
            self.idle_at,
            self.fetched_at(dma_is_on),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// Receives bytes until now, or until the DMA, if it is on, fetches a byte, which is then
    /// returned. `byte_cycles` is the duration of a byte.
    pub fn receive(&mut self, now: u64, byte_cycles: u64, dma_is_on: bool) -> Option<u8> {
        loop {
            let arrival = self.arriving.front().copied();
            let arrives = arrival.map_or(u64::MAX, |(_, end)| end);
            let fetched = self.fetched_at(dma_is_on).unwrap_or(u64::MAX);
            if fetched <= now.min(arrives) {
                self.taken += 1;
                return self.received.take().map(|(byte, _)| byte);
            }
            // A byte that has begun keeps the line busy.
            let begins = arrives.saturating_sub(byte_cycles);
            if self
                .idle_at
                .take_if(|idle| *idle <= now.min(begins))
                .is_some()
            {
                self.idle = true;
            }
            let (byte, end) = arrival.filter(|(_, end)| *end <= now)?;
            self.arriving.pop_front();
            if self.cr[0] & (UE | RE) != UE | RE {
                self.unheard += 1;
                continue;
            }
            self.idle_at = Some(end + byte_cycles);
            if self.received.is_some() {
                self.overrun = true;
                self.overruns += 1;
            } else {
                self.received = Some((byte, end));
            }
        }
    }

    /// Sends bytes until now; `byte_cycles` is the duration of a byte.
    pub fn send(&mut self, now: u64, byte_cycles: u64) {
        while let Some((byte, end)) = self.leaving.take_if(|(_, end)| *end <= now) {
            self.sent.push_back((byte, end));
            self.leaving = self.waiting.take().map(|byte| (byte, end + byte_cycles));
            self.is_complete = self.leaving.is_none();
        }
        if self.leaving.is_none() && self.cr[0] & (UE | TE) == UE | TE {
            self.leaving = self.waiting.take().map(|byte| (byte, now + byte_cycles));
        }
    }

    fn status(&self) -> u32 {
        let flag = |is: bool, bit: u32| if is { bit } else { 0 };
        flag(self.received.is_some(), RXNE)
            | flag(self.overrun, ORE)
            | flag(self.idle, IDLE)
            | flag(self.waiting.is_none(), TXE)
            | flag(self.is_complete, TC)
    }

    /// True if the interrupt is requested: TXE, TC, IDLE, or RXNE and ORE, as CR1 enables them.
    pub fn is_requested(&self) -> bool {
        let status = self.status();
        let enabled = self.cr[0] & (TXE | TC | RXNE | IDLE);
        self.is_on() && (status & enabled != 0 || status & ORE != 0 && enabled & RXNE != 0)
    }

    /// Reads a register by software; `dma_is_on` is the state of the receiver's stream.
    pub fn read(&mut self, offset: u32, dma_is_on: bool) -> Option<u32> {
        Some(match offset {
            0x00 => {
                (self.overrun_seen, self.idle_seen) = (self.overrun, self.idle);
                self.status()
            }
            0x04 => {
                // Reading SR and then DR clears ORE and IDLE.
                self.overrun &= !std::mem::take(&mut self.overrun_seen);
                self.idle &= !std::mem::take(&mut self.idle_seen);
                self.stolen += u64::from(self.fetched_at(dma_is_on).is_some());
                let received = self.received.take();
                self.taken += u64::from(received.is_some());
                received.map_or(0, |(byte, _)| byte).into()
            }
            0x08 => self.brr,
            0x0C..=0x14 => self.cr[(offset as usize - 0x0C) / 4],
            0x18 => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            // Only TC and RXNE can be cleared by a write.
            0x00 => {
                self.is_complete &= value & TC != 0;
                if value & RXNE == 0 {
                    self.received = None;
                }
            }
            0x04 => {
                self.waiting = Some(value as u8);
                self.is_complete = false;
            }
            0x08 => self.brr = value & 0xFFFF,
            // 8 bits, no parity, oversampling by 16.
            0x0C if value & 0x9700 == 0 => self.cr[0] = value,
            // One stop bit; flow control and sending by DMA are not modelled.
            0x10 if value == 0 => self.cr[1] = value,
            0x14 if value & !DMAR == 0 => self.cr[2] = value,
            _ => return None,
        }
        Some(())
    }
}
