//! Entry of and return from exceptions, with the floating-point unit's lazy stacking (DDI 0403E,
//! B1.5.6 to B1.5.8).

use super::state::Cpu;
use crate::bus::Bus;
use crate::scs::{HARD_FAULT, Masks};
use crate::stop::Stop;

/// Cycles of an exception entry, a return, and a tail-chained return (DDI 0439B, 3.9).
const ENTRY: u64 = 12;
const RETURN: u64 = 10;

/// Size of a frame, bytes, without and with floating-point registers.
const BASIC: u32 = 0x20;
const EXTENDED: u32 = 0x68;

/// Bit of the stacked xPSR: the stack pointer was realigned to a multiple of 8.
const ALIGNED: u32 = 1 << 9;

impl Cpu {
    pub fn masks(&self) -> Masks {
        Masks {
            primask: self.primask,
            faultmask: self.faultmask,
            basepri: self.basepri,
        }
    }

    /// Takes an exception. The caller must handle a fault that occurs while the frame is stored.
    pub fn enter(&mut self, number: u16, bus: &mut Bus) -> Result<(), Stop> {
        self.is_asleep = false;
        bus.scs
            .charge(self.ipsr, [bus.time.cycles, self.instructions]);
        self.exclusive = None;
        let it = u32::from(if self.it == super::state::LAST_OF_IT {
            0
        } else {
            self.it
        });
        let status =
            self.apsr() | u32::from(self.ipsr) | 1 << 24 | (it & 3) << 25 | (it >> 2) << 10;
        let bytes = if self.fpca { EXTENDED } else { BASIC };
        let misaligned = self.r[13] & 4 != 0;
        let frame = (self.r[13] & !7).wrapping_sub(bytes);
        let before = [
            self.r[0],
            self.r[1],
            self.r[2],
            self.r[3],
            self.r[12],
            self.r[14],
            self.pc,
            status | if misaligned { ALIGNED } else { 0 },
        ];
        // EXC_RETURN to a handler or a thread, on the main stack, with or without floating-point
        // registers.
        self.r[14] = match (self.ipsr != 0, self.fpca) {
            (true, false) => 0xFFFF_FFF1,
            (false, false) => 0xFFFF_FFF9,
            (true, true) => 0xFFFF_FFE1,
            (false, true) => 0xFFFF_FFE9,
        };
        self.r[13] = frame;
        self.it = 0;
        self.ipsr = number;
        bus.time.cycles += ENTRY;
        bus.scs.now = bus.time.cycles;
        bus.scs.begin(number);
        let stored = self.store_frame(frame, &before, bus);
        self.fpca = false;
        self.pc = bus.read(bus.scs.vectors() + u32::from(number) * 4, 4)? & !1;
        bus.attend();
        stored
    }

    fn store_frame(&mut self, frame: u32, words: &[u32; 8], bus: &mut Bus) -> Result<(), Stop> {
        for (at, word) in words.iter().enumerate() {
            bus.write_aligned(frame.wrapping_add(at as u32 * 4), *word)?;
        }
        if self.fpca {
            let place = frame.wrapping_add(BASIC);
            if bus.scs.is_lazy() {
                bus.scs.lazy_frame = Some(place);
            } else {
                self.store_float_frame(place, bus)?;
                bus.time.cycles += 17;
            }
        }
        Ok(())
    }

    fn store_float_frame(&mut self, place: u32, bus: &mut Bus) -> Result<(), Stop> {
        for at in 0..16_u32 {
            bus.write_aligned(place.wrapping_add(at * 4), self.s[at as usize])?;
        }
        bus.write_aligned(place.wrapping_add(64), self.fpscr)
    }

    /// Stores the floating-point registers of the interrupted code, because the running code is
    /// about to use them.
    pub(super) fn stack_lazily(&mut self, bus: &mut Bus) -> Result<(), Stop> {
        if let Some(place) = bus.scs.lazy_frame.take() {
            bus.time.cycles += 17;
            self.store_float_frame(place, bus)?;
        }
        Ok(())
    }

    /// Returns from an exception; `how` is EXC_RETURN.
    pub(super) fn leave(&mut self, how: u32, bus: &mut Bus) -> Result<(), Stop> {
        if !matches!(how, 0xFFFF_FFF1 | 0xFFFF_FFF9 | 0xFFFF_FFE1 | 0xFFFF_FFE9) {
            return Err(bus.unmodelled("a return from an exception", how));
        }
        bus.scs.now = bus.time.cycles;
        bus.scs
            .charge(self.ipsr, [bus.time.cycles, self.instructions]);
        bus.scs.end(self.ipsr);
        if self.ipsr != HARD_FAULT {
            self.faultmask = false;
        }
        bus.time.cycles += RETURN;
        let frame = self.r[13];
        let has_float = how & 0x10 == 0;
        let word = |at: u32, bus: &mut Bus| bus.read_aligned(frame.wrapping_add(at * 4));
        for (at, register) in [0, 1, 2, 3, 12, 14].into_iter().enumerate() {
            self.r[register] = word(at as u32, bus)?;
        }
        let (pc, status) = (word(6, bus)?, word(7, bus)?);
        if has_float && bus.scs.lazy_frame.take().is_none() {
            for at in 0..16_u32 {
                self.s[at as usize] = word(8 + at, bus)?;
            }
            self.fpscr = word(24, bus)?;
        }
        self.fpca = has_float;
        self.r[13] = frame.wrapping_add(if has_float { EXTENDED } else { BASIC });
        if status & ALIGNED != 0 {
            self.r[13] |= 4;
        }
        self.set_apsr(status);
        self.ipsr = (status & 0x1FF) as u16;
        self.it = (status >> 25 & 3 | status >> 8 & 0xFC) as u8;
        self.pc = pc & !1;
        bus.attend();
        Ok(())
    }
}
