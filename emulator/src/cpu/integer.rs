//! Integer arithmetic: data processing, shifts, products, bit fields.

use super::op::Op;
use super::operands::{Dp, Shift, or_zero};
use super::state::Cpu;

/// Both operands of a data-processing instruction, and the shifter's carry.
pub(super) struct Operands {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) carry: bool,
}

pub(super) struct Computed {
    value: u32,
    c: bool,
    v: bool,
}

impl Cpu {
    pub(super) fn set_nz(&mut self, value: u32) {
        (self.n, self.z) = (value >> 31 != 0, value == 0);
    }

    #[inline(always)]
    pub(super) fn data_processing(&self, f: Dp, operands: Operands) -> Computed {
        let Operands { a, b, carry } = operands;
        let (value, c, v) = match f {
            Dp::And => (a & b, carry, self.v),
            Dp::Bic => (a & !b, carry, self.v),
            Dp::Orr => (a | b, carry, self.v),
            Dp::Orn => (a | !b, carry, self.v),
            Dp::Eor => (a ^ b, carry, self.v),
            Dp::Mov => (b, carry, self.v),
            Dp::Mvn => (!b, carry, self.v),
            Dp::Add => add(a, b, false),
            Dp::Adc => add(a, b, self.c),
            Dp::Sub => add(a, !b, true),
            Dp::Sbc => add(a, !b, self.c),
            Dp::Rsb => add(b, !a, true),
        };
        Computed { value, c, v }
    }

    /// Writes a result to register `d`, and its flags if the instruction `sets` them.
    #[inline(always)]
    pub(super) fn write_back(&mut self, computed: Computed, d: u8, sets: bool) {
        self.r[usize::from(d)] = computed.value;
        if sets {
            self.set_nz(computed.value);
            (self.c, self.v) = (computed.c, computed.v);
        }
    }

    /// Shifts a value; returns the result and the carry (Shift_C).
    pub(super) fn shift(&self, shift: Shift, value: u32, by: u32) -> (u32, bool) {
        if by == 0 {
            return (value, self.c);
        }
        match shift {
            Shift::Lsl if by > 32 => (0, false),
            Shift::Lsl => (
                value.checked_shl(by).unwrap_or(0),
                value >> (32 - by) & 1 != 0,
            ),
            Shift::Lsr if by > 32 => (0, false),
            Shift::Lsr => (
                value.checked_shr(by).unwrap_or(0),
                value >> (by - 1) & 1 != 0,
            ),
            Shift::Asr if by > 31 => ((value as i32 >> 31) as u32, value >> 31 != 0),
            Shift::Asr => ((value as i32 >> by) as u32, value >> (by - 1) & 1 != 0),
            Shift::Ror => {
                let turned = value.rotate_right(by);
                (turned, turned >> 31 != 0)
            }
            Shift::Rrx => (u32::from(self.c) << 31 | value >> 1, value & 1 != 0),
        }
    }

    pub(super) fn integer(&mut self, op: Op) {
        let r = |n: u8| self.r[usize::from(n)];
        let (d, value) = match op {
            Op::Mul(flags, d, n, m) => {
                let value = r(n).wrapping_mul(r(m));
                if flags == super::operands::Flags::OutsideIt && self.it == 0 {
                    self.set_nz(value);
                }
                (d, value)
            }
            Op::MulAdd(d, n, m, a, subtract) => {
                let product = r(n).wrapping_mul(r(m));
                (
                    d,
                    if subtract {
                        r(a).wrapping_sub(product)
                    } else {
                        r(a).wrapping_add(product)
                    },
                )
            }
            Op::HalfMul {
                d,
                n,
                m,
                a,
                n_high,
                m_high,
            } => {
                let half =
                    |value: u32, high: bool| i32::from((value >> if high { 16 } else { 0 }) as i16);
                let product = half(r(n), n_high).wrapping_mul(half(r(m), m_high));
                let (sum, overflows) = product.overflowing_add(or_zero(&self.r, a) as i32);
                self.q |= overflows;
                (d, sum as u32)
            }
            Op::LongMul {
                low,
                high,
                n,
                m,
                signed,
                accumulate,
            } => {
                let product = if signed {
                    i64::from(r(n) as i32).wrapping_mul(i64::from(r(m) as i32)) as u64
                } else {
                    u64::from(r(n)) * u64::from(r(m))
                };
                let before = if accumulate {
                    u64::from(r(high)) << 32 | u64::from(r(low))
                } else {
                    0
                };
                let sum = product.wrapping_add(before);
                self.r[usize::from(low)] = sum as u32;
                (high, (sum >> 32) as u32)
            }
            Op::Divide(d, n, m, signed) => {
                let (a, b) = (r(n), r(m));
                let signed_quotient = || {
                    (a as i32)
                        .checked_div(b as i32)
                        .unwrap_or(if b == 0 { 0 } else { i32::MIN })
                };
                (
                    d,
                    if signed {
                        signed_quotient() as u32
                    } else {
                        a.checked_div(b).unwrap_or(0)
                    },
                )
            }
            Op::Extend(d, n, m, rotate, width) => {
                let value = width.extend(r(m).rotate_right(rotate.into()));
                (d, value.wrapping_add(or_zero(&self.r, n)))
            }
            Op::BitInsert(d, n, lsb, width) => {
                let mask = ((1_u64 << width) - 1) as u32;
                (
                    d,
                    r(d) & !(mask << lsb) | (or_zero(&self.r, n) & mask) << lsb,
                )
            }
            Op::BitExtract(d, n, lsb, width, signed) => {
                let high = r(n) << (32 - u32::from(lsb) - u32::from(width));
                let right = 32 - u32::from(width);
                (
                    d,
                    if signed {
                        (high as i32 >> right) as u32
                    } else {
                        high >> right
                    },
                )
            }
            Op::CountZeros(d, m) => (d, r(m).leading_zeros()),
            Op::ReverseBits(d, m) => (d, r(m).reverse_bits()),
            Op::ReverseBytes(d, m) => (d, r(m).swap_bytes()),
            Op::ReverseHalves(d, m) => (d, r(m).swap_bytes().rotate_right(16)),
            Op::Saturate {
                d,
                n,
                bits,
                shift,
                by,
                signed,
            } => {
                let value = i64::from(self.shift(shift, r(n), by.into()).0 as i32);
                let (low, high) = if signed {
                    (-(1_i64 << (bits - 1)), (1 << (bits - 1)) - 1)
                } else {
                    (0, (1 << bits) - 1)
                };
                let bounded = value.clamp(low, high);
                self.q |= bounded != value;
                (d, bounded as u32)
            }
            Op::SaturatingAdd(d, n, m, subtract, twice) => {
                let (n, m) = (r(n) as i32, r(m) as i32);
                let addend = if twice { n.saturating_mul(2) } else { n };
                let exact = if subtract {
                    m.checked_sub(addend)
                } else {
                    m.checked_add(addend)
                };
                self.q |= exact.is_none() || twice && n.checked_mul(2).is_none();
                (
                    d,
                    if subtract {
                        m.saturating_sub(addend)
                    } else {
                        m.saturating_add(addend)
                    } as u32,
                )
            }
            Op::HalvesUnsigned(d, n, m, subtract) => {
                let half = |at: u32| {
                    let (a, b) = ((r(n) >> at) as u16, (r(m) >> at) as u16);
                    u32::from(if subtract {
                        a.saturating_sub(b)
                    } else {
                        a.saturating_add(b)
                    }) << at
                };
                (d, half(0) | half(16))
            }
            Op::PackHalves(d, n, m, by, top) => {
                let shifted = self
                    .shift(if top { Shift::Asr } else { Shift::Lsl }, r(m), by.into())
                    .0;
                let (upper, lower) = if top {
                    (r(n), shifted)
                } else {
                    (shifted, r(n))
                };
                (d, upper & 0xFFFF_0000 | lower & 0xFFFF)
            }
            _ => return,
        };
        self.r[usize::from(d)] = value;
    }
}

/// AddWithCarry: returns the sum, the carry out and the overflow.
fn add(a: u32, b: u32, carry: bool) -> (u32, bool, bool) {
    let (sum, first) = a.overflowing_add(b);
    let (sum, second) = sum.overflowing_add(carry.into());
    (sum, first || second, (a ^ sum) & (b ^ sum) & 1 << 31 != 0)
}
