//! Fetches, decodes and runs instructions, with IT blocks.

use super::op::Op;
use super::state::{Cpu, FLASH, LAST_OF_IT, UNKNOWN};
use super::{decode16, decode32};
use crate::bus::Bus;
use crate::stop::Stop;

impl Cpu {
    /// Starts from the vectors at address 0 (DDI 0403E, B1.5.5).
    pub fn reset(&mut self, bus: &mut Bus) -> Result<(), Stop> {
        let (instructions, cache) = (self.instructions, std::mem::take(&mut self.cache));
        *self = Self {
            instructions,
            cache,
            ..Self::new(0)
        };
        self.r[13] = bus.read(0, 4)? & !3;
        self.r[14] = !0;
        self.pc = bus.read(4, 4)? & !1;
        Ok(())
    }

    /// Discards decoded instructions after the flash has changed.
    pub fn forget(&mut self) {
        self.cache.fill(UNKNOWN);
    }

    #[inline(always)]
    pub fn step(&mut self, bus: &mut Bus) -> Result<(), Stop> {
        let pc = self.pc;
        bus.pc = pc;
        let (op, bytes) = match self.cache.get((pc.wrapping_sub(FLASH) >> 1) as usize) {
            Some((op, bytes)) if *bytes != 0 => (*op, *bytes),
            _ => self.decode(pc, bus)?,
        };
        self.r[15] = pc.wrapping_add(4);
        self.pc = pc.wrapping_add(bytes.into());
        self.instructions += 1;
        bus.time.cycles += 1;
        if self.it != 0 && !self.advance_it(op) {
            return Ok(());
        }
        self.execute(op, bus)
    }

    #[inline(never)]
    fn decode(&mut self, pc: u32, bus: &mut Bus) -> Result<(Op, u8), Stop> {
        let first = bus.fetch(pc)?;
        let decoded = if first >> 11 < 0b11101 {
            (decode16::decode(first, pc), 2)
        } else {
            (
                decode32::decode(first, bus.fetch(pc.wrapping_add(2))?, pc),
                4,
            )
        };
        if let Some(place) = self.cache.get_mut((pc.wrapping_sub(FLASH) >> 1) as usize) {
            *place = decoded;
        }
        Ok(decoded)
    }

    /// Advances the IT block, if any. Returns true if the block lets the instruction run.
    fn advance_it(&mut self, op: Op) -> bool {
        if matches!(op, Op::It(..)) {
            return true;
        }
        let runs = self.holds(self.it >> 4);
        // `execute` reads `it` after this, and 16-bit encodings must not set flags within a block,
        // so the last instruction of a block is marked.
        self.it = if self.it & 7 == 0 {
            LAST_OF_IT
        } else {
            self.it & 0xE0 | self.it << 1 & 0x1F
        };
        if !runs && self.it == LAST_OF_IT {
            self.it = 0;
        }
        runs
    }
}
