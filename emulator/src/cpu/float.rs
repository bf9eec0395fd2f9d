//! The floating-point unit in its default mode: round to nearest, subnormals kept, NaN propagated.

use super::op::Op;
use super::operands::{Float1, Float2};
use super::state::Cpu;
use crate::bus::Bus;
use crate::stop::{Stop, Usage};

/// Extra cycles of a division or a square root, and of a multiply-accumulate (DDI 0439B, table
/// 7-1).
const DIVISION: u64 = 13;
const ACCUMULATION: u64 = 2;

impl Cpu {
    pub(super) fn float(&mut self, op: Op, bus: &mut Bus) -> Result<(), Stop> {
        if !bus.scs.has_float() {
            return Err(Stop::Usage(Usage::NoCoprocessor));
        }
        if bus.scs.lazy_frame.is_some() {
            self.stack_lazily(bus)?;
        }
        self.fpca = true;
        let value = |s: &[u32; 33], at: u8| f32::from_bits(s[usize::from(at)]);
        match op {
            Op::FloatLoad(s, n, offset, words) => {
                let address = self.base(n).wrapping_add_signed(offset.into());
                self.load_floats(s, words, address, bus)?;
            }
            Op::FloatStore(s, n, offset, words) => {
                let address = self.base(n).wrapping_add_signed(offset.into());
                self.store_floats(s, words, address, bus)?;
            }
            Op::FloatLoadMany(n, s, words, back, down) => {
                let (from, after) = self.span(n, words, down);
                self.load_floats(s, words, from, bus)?;
                if back {
                    self.r[usize::from(n)] = after;
                }
            }
            Op::FloatStoreMany(n, s, words, back, down) => {
                let (from, after) = self.span(n, words, down);
                self.store_floats(s, words, from, bus)?;
                if back {
                    self.r[usize::from(n)] = after;
                }
            }
            Op::FloatToCore(t, s) => self.r[usize::from(t)] = self.s[usize::from(s)],
            Op::CoreToFloat(t, s) => self.s[usize::from(s)] = self.r[usize::from(t)],
            Op::FloatPairToCore(t, t2, s) => {
                (self.r[usize::from(t)], self.r[usize::from(t2)]) =
                    (self.s[usize::from(s)], self.s[usize::from(s) + 1]);
            }
            Op::CorePairToFloat(t, t2, s) => {
                (self.s[usize::from(s)], self.s[usize::from(s) + 1]) =
                    (self.r[usize::from(t)], self.r[usize::from(t2)]);
            }
            Op::FloatStatusToCore(15) => {
                let flag = |at: u32| self.fpscr >> at & 1 != 0;
                (self.n, self.z, self.c, self.v) = (flag(31), flag(30), flag(29), flag(28));
            }
            Op::FloatStatusToCore(t) => self.r[usize::from(t)] = self.fpscr,
            Op::CoreToFloatStatus(t) => {
                let status = self.r[usize::from(t)];
                if status & 0x07C0_0000 != 0 {
                    return Err(
                        bus.unmodelled("this mode of the floating-point unit", self.r[15] - 4)
                    );
                }
                self.fpscr = status;
            }
            Op::Float2(f, d, n, m) => {
                let (a, b) = (value(&self.s, n), value(&self.s, m));
                let before = value(&self.s, d);
                bus.time.cycles += match f {
                    Float2::Div => DIVISION,
                    Float2::Add | Float2::Sub | Float2::Mul | Float2::Nmul => 0,
                    _ => ACCUMULATION,
                };
                let result = match f {
                    Float2::Mla => before + a * b,
                    Float2::Mls => before + -(a * b),
                    Float2::Nmla => -before + -(a * b),
                    Float2::Nmls => -before + a * b,
                    Float2::Mul => a * b,
                    Float2::Nmul => -(a * b),
                    Float2::Add => a + b,
                    Float2::Sub => a - b,
                    Float2::Div => a / b,
                    Float2::Fma => a.mul_add(b, before),
                    Float2::Fms => (-a).mul_add(b, before),
                    Float2::Fnma => (-a).mul_add(b, -before),
                    Float2::Fnms => a.mul_add(b, -before),
                };
                self.s[usize::from(d)] = result.to_bits();
            }
            Op::Float1(f, d, m) => {
                let bits = self.s[usize::from(m)];
                self.s[usize::from(d)] = match f {
                    Float1::Mov => bits,
                    Float1::Abs => bits & !(1 << 31),
                    Float1::Neg => bits ^ 1 << 31,
                    Float1::Sqrt => {
                        bus.time.cycles += DIVISION;
                        f32::from_bits(bits).sqrt().to_bits()
                    }
                };
            }
            Op::FloatConstant(d, bits) => self.s[usize::from(d)] = bits,
            Op::FloatCompare(d, m) => {
                use std::cmp::Ordering::{Equal, Greater, Less};
                let flags = match value(&self.s, d).partial_cmp(&value(&self.s, m)) {
                    Some(Equal) => 0b0110,
                    Some(Less) => 0b1000,
                    Some(Greater) => 0b0010,
                    None => 0b0011,
                };
                self.fpscr = self.fpscr & 0x0FFF_FFFF | flags << 28;
            }
            Op::IntToFloat(d, m, signed) => {
                let bits = self.s[usize::from(m)];
                let value = if signed {
                    bits as i32 as f32
                } else {
                    bits as f32
                };
                self.s[usize::from(d)] = value.to_bits();
            }
            Op::FloatToInt(d, m, signed, to_zero) => {
                let value = value(&self.s, m);
                // Like the chip, the cast saturates values out of range and converts NaN to zero.
                let value = if to_zero {
                    value
                } else {
                    value.round_ties_even()
                };
                self.s[usize::from(d)] = if signed {
                    value as i32 as u32
                } else {
                    value as u32
                };
            }
            _ => return Err(bus.unmodelled("an instruction", self.r[15] - 4)),
        }
        Ok(())
    }

    /// Base address of a load or store; the program counter is aligned to a word.
    fn base(&self, n: u8) -> u32 {
        if n == 15 {
            self.r[15] & !3
        } else {
            self.r[usize::from(n)]
        }
    }

    fn load_floats(&mut self, s: u8, words: u8, from: u32, bus: &mut Bus) -> Result<(), Stop> {
        bus.time.cycles += u64::from(words);
        for at in 0..words {
            self.s[usize::from(s + at)] = bus.read_aligned(from.wrapping_add(u32::from(at) * 4))?;
        }
        Ok(())
    }

    fn store_floats(&mut self, s: u8, words: u8, from: u32, bus: &mut Bus) -> Result<(), Stop> {
        bus.time.cycles += u64::from(words);
        for at in 0..words {
            bus.write_aligned(
                from.wrapping_add(u32::from(at) * 4),
                self.s[usize::from(s + at)],
            )?;
        }
        Ok(())
    }
}
