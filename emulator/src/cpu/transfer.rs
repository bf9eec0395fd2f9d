//! Loads and stores of several registers, and exclusive loads and stores.

use super::op::Op;
use super::operands::Index;
use super::state::Cpu;
use crate::bus::Bus;
use crate::stop::Stop;

impl Cpu {
    /// Returns the address of a load or store, and the new value of its address register.
    pub(super) fn indexed(&self, n: u8, offset: i16, index: Index) -> (u32, u32) {
        let base = self.r[usize::from(n)];
        let there = base.wrapping_add_signed(offset.into());
        match index {
            Index::Offset => (there, base),
            Index::Before => (there, there),
            Index::After => (base, there),
        }
    }

    /// Returns the first address of several words, and the new value of the address register.
    pub(super) fn span(&self, n: u8, words: u8, down: bool) -> (u32, u32) {
        let (base, bytes) = (self.r[usize::from(n)], u32::from(words) * 4);
        if down {
            (base.wrapping_sub(bytes), base.wrapping_sub(bytes))
        } else {
            (base, base.wrapping_add(bytes))
        }
    }

    pub(super) fn transfer(&mut self, op: Op, bus: &mut Bus) -> Result<(), Stop> {
        match op {
            Op::LoadPair(t, t2, n, offset, index) => {
                let (address, after) = self.indexed(n, offset, index);
                let address = if n == 15 { address & !3 } else { address };
                bus.time.cycles += 2;
                let (first, second) = (
                    bus.read_aligned(address)?,
                    bus.read_aligned(address.wrapping_add(4))?,
                );
                if n != 15 {
                    self.r[usize::from(n)] = after;
                }
                (self.r[usize::from(t)], self.r[usize::from(t2)]) = (first, second);
            }
            Op::StorePair(t, t2, n, offset, index) => {
                let (address, after) = self.indexed(n, offset, index);
                bus.time.cycles += 2;
                bus.write_aligned(address, self.r[usize::from(t)])?;
                bus.write_aligned(address.wrapping_add(4), self.r[usize::from(t2)])?;
                self.r[usize::from(n)] = after;
            }
            Op::LoadMany(n, list, back, down) => {
                let (from, after) = self.span(n, list.count_ones() as u8, down);
                let mut address = from;
                let mut target = None;
                let mut loaded = self.r;
                for t in (0..16_usize).filter(|t| list >> t & 1 != 0) {
                    let value = bus.read_aligned(address)?;
                    if t == 15 {
                        target = Some(value)
                    } else {
                        loaded[t] = value
                    }
                    address = address.wrapping_add(4);
                }
                bus.time.cycles += u64::from(list.count_ones());
                self.r = loaded;
                if back {
                    self.r[usize::from(n)] = after;
                }
                if let Some(to) = target {
                    self.jump(to, bus)?;
                }
            }
            Op::StoreMany(n, list, back, down) => {
                let (from, after) = self.span(n, list.count_ones() as u8, down);
                let mut address = from;
                for t in (0..15_usize).filter(|t| list >> t & 1 != 0) {
                    bus.write_aligned(address, self.r[t])?;
                    address = address.wrapping_add(4);
                }
                bus.time.cycles += u64::from(list.count_ones());
                if back {
                    self.r[usize::from(n)] = after;
                }
            }
            Op::LoadExclusive(width, t, n, offset) => {
                let address = self.r[usize::from(n)].wrapping_add(offset.into());
                self.r[usize::from(t)] = bus.load(width, address)?;
                self.exclusive = Some(address);
            }
            Op::StoreExclusive(width, d, t, n, offset) => {
                let address = self.r[usize::from(n)].wrapping_add(offset.into());
                let holds = self.exclusive.take() == Some(address);
                if holds {
                    bus.store(width, address, self.r[usize::from(t)])?;
                }
                self.r[usize::from(d)] = (!holds).into();
            }
            _ => self.exclusive = None,
        }
        Ok(())
    }
}
