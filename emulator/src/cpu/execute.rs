//! Executes instructions. Cycles are from the Cortex-M4 reference manual (DDI 0439B, table 3-1),
//! including the one counted for every instruction: load 2, taken branch 2, computed branch 3,
//! integer division 4, float division 14.

use super::integer::Operands;
use super::op::Op;
use super::operands::Flags;
use super::state::{Cpu, LAST_OF_IT};
use crate::bus::Bus;
use crate::stop::{Stop, Usage};
use crate::width::Width;

/// Extra cycles of a taken branch, to refill the pipeline.
const BRANCH: u64 = 1;
/// Extra cycles of a branch to an address from a register or memory.
const COMPUTED_BRANCH: u64 = 2;
/// Extra cycles of an integer division, which takes 2 to 12.
const DIVISION: u64 = 4;

impl Cpu {
    #[inline(always)]
    pub(super) fn execute(&mut self, op: Op, bus: &mut Bus) -> Result<(), Stop> {
        match op {
            Op::DpImm {
                f,
                flags,
                d,
                n,
                imm,
                carry,
            } => {
                let operands = Operands {
                    a: self.r[usize::from(n)],
                    b: imm,
                    carry: carry.unwrap_or(self.c),
                };
                self.write_back(self.data_processing(f, operands), d, self.sets(flags));
            }
            Op::DpReg {
                f,
                flags,
                d,
                n,
                m,
                shift,
                by,
            } => {
                let (a, b) = (self.r[usize::from(n)], self.r[usize::from(m)]);
                let (b, carry) = if by == 0 {
                    (b, self.c)
                } else {
                    self.shift(shift, b, by.into())
                };
                let computed = self.data_processing(f, Operands { a, b, carry });
                self.write_back(computed, d, self.sets(flags));
            }
            Op::ShiftReg(shift, flags, d, n, m) => {
                let (by, sets) = (self.r[usize::from(m)] & 0xFF, self.sets(flags));
                let (value, carry) = self.shift(shift, self.r[usize::from(n)], by);
                self.r[usize::from(d)] = value;
                if sets {
                    self.set_nz(value);
                    self.c = carry;
                }
            }
            Op::Constant(d, value) => self.r[usize::from(d)] = value,
            Op::MovT(d, imm) => {
                let d = &mut self.r[usize::from(d)];
                *d = *d & 0xFFFF | u32::from(imm) << 16;
            }
            Op::Load(width, t, n, offset, index) => {
                let address = self.indexed(n, offset, index);
                let value = bus.load(width, address.0)?;
                self.r[usize::from(n)] = address.1;
                self.loaded(t, value, bus)?;
            }
            Op::LoadReg(width, t, n, m, by) => {
                let address = self.r[usize::from(n)].wrapping_add(self.r[usize::from(m)] << by);
                let value = bus.load(width, address)?;
                self.loaded(t, value, bus)?;
            }
            Op::LoadLiteral(width, t, address) => {
                let value = bus.load(width, address)?;
                self.loaded(t, value, bus)?;
            }
            Op::Store(width, t, n, offset, index) => {
                let address = self.indexed(n, offset, index);
                bus.store(width, address.0, self.r[usize::from(t)])?;
                self.r[usize::from(n)] = address.1;
            }
            Op::StoreReg(width, t, n, m, by) => {
                let address = self.r[usize::from(n)].wrapping_add(self.r[usize::from(m)] << by);
                bus.store(width, address, self.r[usize::from(t)])?;
            }
            Op::Branch(to) => self.branch(to, BRANCH, bus),
            Op::BranchIf(condition, to) => {
                if self.holds(condition) {
                    self.branch(to, BRANCH, bus);
                }
            }
            Op::CompareBranch(n, nonzero, to) => {
                if (self.r[usize::from(n)] != 0) == nonzero {
                    self.branch(to, BRANCH, bus);
                }
            }
            Op::BranchLink(to) => {
                self.r[14] = self.pc | 1;
                self.branch(to, BRANCH, bus);
            }
            Op::BranchReg(m) => self.jump(self.r[usize::from(m)], bus)?,
            Op::BranchLinkReg(m) => {
                let to = self.r[usize::from(m)];
                self.r[14] = self.pc | 1;
                self.jump(to, bus)?;
            }
            Op::MovPc(m) => self.branch(self.r[usize::from(m)] & !1, COMPUTED_BRANCH, bus),
            Op::AddPc(m) => {
                self.branch(
                    self.r[15].wrapping_add(self.r[usize::from(m)]) & !1,
                    COMPUTED_BRANCH,
                    bus,
                );
            }
            Op::TableBranch(n, m, halves) => {
                let (base, at) = (self.r[usize::from(n)], self.r[usize::from(m)]);
                let entry = if halves {
                    bus.load(Width::Half, base.wrapping_add(at << 1))?
                } else {
                    bus.load(Width::Byte, base.wrapping_add(at))?
                };
                self.branch(self.r[15].wrapping_add(entry * 2), BRANCH, bus);
            }
            Op::It(state) => {
                self.it = state;
                return Ok(());
            }
            Op::LoadPair(..)
            | Op::StorePair(..)
            | Op::LoadMany(..)
            | Op::StoreMany(..)
            | Op::LoadExclusive(..)
            | Op::StoreExclusive(..)
            | Op::ClearExclusive => self.transfer(op, bus)?,
            Op::Divide(..) => {
                bus.time.cycles += DIVISION;
                self.integer(op);
            }
            Op::Mul(..)
            | Op::MulAdd(..)
            | Op::HalfMul { .. }
            | Op::LongMul { .. }
            | Op::Extend(..)
            | Op::BitInsert(..)
            | Op::BitExtract(..)
            | Op::CountZeros(..)
            | Op::ReverseBits(..)
            | Op::ReverseBytes(..)
            | Op::ReverseHalves(..)
            | Op::Saturate { .. }
            | Op::SaturatingAdd(..)
            | Op::HalvesUnsigned(..)
            | Op::PackHalves(..) => self.integer(op),
            Op::Nop | Op::Barrier => {}
            Op::WaitForInterrupt => {
                self.is_asleep = true;
                bus.attend();
            }
            Op::ReadSpecial(..) | Op::WriteSpecial(..) | Op::Mask(..) => self.special(op, bus)?,
            Op::Undefined => return Err(Stop::Usage(Usage::Undefined)),
            Op::Unmodelled | Op::Breakpoint => {
                return Err(bus.unmodelled("an instruction", self.r[15] - 4));
            }
            _ => self.float(op, bus)?,
        }
        if self.it == LAST_OF_IT {
            self.it = 0;
        }
        Ok(())
    }

    fn sets(&self, flags: Flags) -> bool {
        match flags {
            Flags::Keep => false,
            Flags::Set => true,
            Flags::OutsideIt => self.it == 0,
        }
    }

    /// Writes a loaded value to its register; loading the program counter is a branch.
    #[inline(always)]
    fn loaded(&mut self, t: u8, value: u32, bus: &mut Bus) -> Result<(), Stop> {
        if t == 15 {
            return self.jump(value, bus);
        }
        self.r[usize::from(t)] = value;
        Ok(())
    }

    #[inline(always)]
    fn branch(&mut self, to: u32, cycles: u64, bus: &mut Bus) {
        self.pc = to;
        bus.time.cycles += cycles;
    }

    /// Executes BX and similar jumps, including the return from an exception.
    pub(super) fn jump(&mut self, to: u32, bus: &mut Bus) -> Result<(), Stop> {
        bus.time.cycles += COMPUTED_BRANCH;
        if to >> 28 == 0xF && self.ipsr != 0 {
            self.it = 0;
            return self.leave(to, bus);
        }
        if to & 1 == 0 {
            return Err(Stop::Usage(Usage::State));
        }
        self.pc = to & !1;
        Ok(())
    }
}
