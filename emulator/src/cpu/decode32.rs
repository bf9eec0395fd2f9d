//! 32-bit Thumb encodings except the floating-point ones (DDI 0403E, A5.3). `a` is the first half
//! word, `b` the second.

use super::decode16::immediate_shift;
use super::op::Op;
use super::operands::{Dp, Flags, Index, SINK, Shift, reg};
use super::{decode_branch, decode_float};
use crate::width::Width;

pub fn decode(a: u16, b: u16, pc: u32) -> Op {
    match (a >> 11 & 3, a >> 4 & 0x7F) {
        (1, 0x00..=0x1F) if a & 0x40 == 0 => many(a, b),
        (1, 0x00..=0x1F) => dual_or_exclusive(a, b),
        (1, 0x20..=0x3F) => shifted_register(a, b),
        (1, _) => decode_float::decode(a, b),
        (2, _) if b & 0x8000 != 0 => decode_branch::decode(a, b, pc),
        (2, _) if a & 0x200 == 0 => modified_immediate(a, b),
        (2, _) => plain_immediate(a, b, pc),
        (_, op) if op & 0x71 == 0 => store(a, b),
        (_, op) if op & 0x61 == 1 => load(a, b, pc),
        (_, 0x20..=0x2F) => register(a, b),
        (_, 0x30..=0x37) => multiply(a, b),
        (_, 0x38..=0x3F) => long_multiply(a, b),
        _ => Op::Undefined,
    }
}

fn many(a: u16, b: u16) -> Op {
    let (n, back) = (reg(a, 0), a & 0x20 != 0);
    let down = match a >> 7 & 3 {
        1 => false,
        2 => true,
        _ => return Op::Unmodelled,
    };
    if a & 0x10 == 0 {
        Op::StoreMany(n, b, back, down)
    } else {
        Op::LoadMany(n, b, back, down)
    }
}

fn dual_or_exclusive(a: u16, b: u16) -> Op {
    let (n, t, t2) = (reg(a, 0), reg(b, 12), reg(b, 8));
    let (before, up, back, is_load) = (a & 0x100 != 0, a & 0x80 != 0, a & 0x20 != 0, a & 0x10 != 0);
    if before || back {
        let offset = (b & 0xFF) as i16 * if up { 4 } else { -4 };
        let index = match (before, back) {
            (true, false) => Index::Offset,
            (true, true) => Index::Before,
            _ => Index::After,
        };
        return if is_load {
            Op::LoadPair(t, t2, n, offset, index)
        } else {
            Op::StorePair(t, t2, n, offset, index)
        };
    }
    let width = match b >> 4 & 15 {
        4 => Width::Byte,
        5 => Width::Half,
        _ => Width::Word,
    };
    match (up, is_load, b >> 4 & 15) {
        (false, false, _) => Op::StoreExclusive(Width::Word, reg(b, 8), t, n, (b & 0xFF) * 4),
        (false, true, _) => Op::LoadExclusive(Width::Word, t, n, (b & 0xFF) * 4),
        (true, true, 0 | 1) => Op::TableBranch(n, reg(b, 0), b & 0x10 != 0),
        (true, true, 4 | 5) => Op::LoadExclusive(width, t, n, 0),
        (true, false, 4 | 5) => Op::StoreExclusive(width, reg(b, 0), t, n, 0),
        _ => Op::Undefined,
    }
}

/// Decodes a 32-bit data-processing instruction: operation, flags, destination (none for a
/// comparison) and first operand (none for a move).
fn data_processing(a: u16, b: u16) -> Option<(Dp, Flags, u8, u8)> {
    let (sets, n, d) = (a & 0x10 != 0, reg(a, 0), reg(b, 8));
    let flags = if sets { Flags::Set } else { Flags::Keep };
    let compares = sets && d == 15;
    let d = if compares { SINK } else { d };
    Some(match (a >> 5 & 15, n) {
        (0, _) => (Dp::And, flags, d, n),
        (1, _) => (Dp::Bic, flags, d, n),
        (2, 15) => (Dp::Mov, flags, d, SINK),
        (2, _) => (Dp::Orr, flags, d, n),
        (3, 15) => (Dp::Mvn, flags, d, SINK),
        (3, _) => (Dp::Orn, flags, d, n),
        (4, _) => (Dp::Eor, flags, d, n),
        (8, _) => (Dp::Add, flags, d, n),
        (10, _) => (Dp::Adc, flags, d, n),
        (11, _) => (Dp::Sbc, flags, d, n),
        (13, _) => (Dp::Sub, flags, d, n),
        (14, _) => (Dp::Rsb, flags, d, n),
        _ => return None,
    })
}

fn shifted_register(a: u16, b: u16) -> Op {
    let by = (b >> 10 & 0x1C | b >> 6 & 3) as u8;
    let (kind, m) = ((b >> 4 & 3) as u8, reg(b, 0));
    if a >> 5 & 15 == 6 {
        return Op::PackHalves(
            reg(b, 8),
            reg(a, 0),
            m,
            immediate_shift(kind & 2, by).1,
            b & 0x20 != 0,
        );
    }
    let (shift, by) = immediate_shift(kind, by);
    match data_processing(a, b) {
        Some((_, _, 15, _)) | None => Op::Undefined,
        Some((f, flags, d, n)) => Op::DpReg {
            f,
            flags,
            d,
            n,
            m,
            shift,
            by,
        },
    }
}

/// Extracts the 12 bits i:imm3:imm8.
fn imm12(a: u16, b: u16) -> u32 {
    u32::from(a >> 10 & 1) << 11 | u32::from(b >> 12 & 7) << 8 | u32::from(b & 0xFF)
}

fn modified_immediate(a: u16, b: u16) -> Op {
    let bits = imm12(a, b);
    let byte = bits & 0xFF;
    let (imm, carry) = match bits >> 8 {
        0 => (byte, None),
        1 => (byte << 16 | byte, None),
        2 => (byte << 24 | byte << 8, None),
        3 => (byte * 0x0101_0101, None),
        _ => {
            let value = (bits & 0x7F | 0x80).rotate_right(bits >> 7);
            (value, Some(value >> 31 != 0))
        }
    };
    match data_processing(a, b) {
        Some((_, _, 15, _)) | None => Op::Undefined,
        Some((f, flags, d, n)) => Op::DpImm {
            f,
            flags,
            d,
            n,
            imm,
            carry,
        },
    }
}

fn plain_immediate(a: u16, b: u16, pc: u32) -> Op {
    let (n, d, imm) = (reg(a, 0), reg(b, 8), imm12(a, b));
    let lsb = (b >> 10 & 0x1C | b >> 6 & 3) as u8;
    let last = (b & 31) as u8;
    let wide = (u32::from(a & 15) << 12 | imm) as u16;
    let (flags, carry) = (Flags::Keep, None);
    match a >> 4 & 31 {
        0 if n == 15 => Op::Constant(d, ((pc & !3) + 4).wrapping_add(imm)),
        0 => Op::DpImm {
            f: Dp::Add,
            flags,
            d,
            n,
            imm,
            carry,
        },
        4 => Op::Constant(d, wide.into()),
        10 if n == 15 => Op::Constant(d, ((pc & !3) + 4).wrapping_sub(imm)),
        10 => Op::DpImm {
            f: Dp::Sub,
            flags,
            d,
            n,
            imm,
            carry,
        },
        12 => Op::MovT(d, wide),
        16 | 18 | 24 | 26 => {
            let signed = a & 0x80 == 0;
            let shift = if a & 0x20 == 0 {
                Shift::Lsl
            } else {
                Shift::Asr
            };
            if shift == Shift::Asr && lsb == 0 {
                return Op::Unmodelled;
            }
            Op::Saturate {
                d,
                n,
                bits: last + u8::from(signed),
                shift,
                by: lsb,
                signed,
            }
        }
        20 | 28 => Op::BitExtract(d, n, lsb, last + 1, a & 0x80 == 0),
        22 if last >= lsb => Op::BitInsert(d, if n == 15 { SINK } else { n }, lsb, last + 1 - lsb),
        _ => Op::Undefined,
    }
}

/// Decodes a 12-bit or 8-bit offset of a load or store, and its use; returns `None` if the offset
/// is a register.
fn offset(a: u16, b: u16) -> Option<(i16, Index)> {
    if a & 0x80 != 0 {
        return Some(((b & 0xFFF) as i16, Index::Offset));
    }
    if b & 0x800 == 0 {
        return None;
    }
    let offset = (b & 0xFF) as i16 * if b & 0x200 != 0 { 1 } else { -1 };
    Some((
        offset,
        if b & 0x100 == 0 {
            Index::Offset
        } else if b & 0x400 != 0 {
            Index::Before
        } else {
            Index::After
        },
    ))
}

fn width(a: u16) -> Option<Width> {
    match (a >> 5 & 3, a & 0x100 != 0) {
        (0, false) => Some(Width::Byte),
        (0, true) => Some(Width::SignedByte),
        (1, false) => Some(Width::Half),
        (1, true) => Some(Width::SignedHalf),
        (2, false) => Some(Width::Word),
        _ => None,
    }
}

fn store(a: u16, b: u16) -> Op {
    let (t, n) = (reg(b, 12), reg(a, 0));
    match (width(a), offset(a, b)) {
        (Some(width), Some((offset, index))) if n != 15 => Op::Store(width, t, n, offset, index),
        (Some(width), None) if n != 15 && b & 0xFC0 == 0 => {
            Op::StoreReg(width, t, n, reg(b, 0), (b >> 4 & 3) as u8)
        }
        _ => Op::Undefined,
    }
}

fn load(a: u16, b: u16, pc: u32) -> Op {
    let (t, n) = (reg(b, 12), reg(a, 0));
    let Some(width) = width(a) else {
        return Op::Undefined;
    };
    if t == 15 && width != Width::Word {
        // Preload hints.
        return Op::Nop;
    }
    if n == 15 {
        let imm = i32::from(b & 0xFFF);
        let offset = if a & 0x80 != 0 { imm } else { -imm };
        return Op::LoadLiteral(width, t, ((pc & !3) + 4).wrapping_add_signed(offset));
    }
    match offset(a, b) {
        Some((offset, index)) => Op::Load(width, t, n, offset, index),
        None if b & 0xFC0 == 0 => Op::LoadReg(width, t, n, reg(b, 0), (b >> 4 & 3) as u8),
        None => Op::Undefined,
    }
}

fn register(a: u16, b: u16) -> Op {
    let (d, n, m) = (reg(b, 8), reg(a, 0), reg(b, 0));
    let op = a >> 4 & 15;
    match (op, b >> 4 & 15) {
        (0..=7, 0) => {
            let shift = [Shift::Lsl, Shift::Lsr, Shift::Asr, Shift::Ror][usize::from(op >> 1)];
            let flags = if op & 1 != 0 { Flags::Set } else { Flags::Keep };
            Op::ShiftReg(shift, flags, d, n, m)
        }
        (0 | 1 | 4 | 5, 8..=15) => {
            let width = [
                Width::SignedHalf,
                Width::Half,
                Width::SignedByte,
                Width::Byte,
            ][usize::from(op & 1) + 2 * usize::from(op >> 2)];
            let n = if n == 15 { SINK } else { n };
            Op::Extend(d, n, m, (b >> 4 & 3) as u8 * 8, width)
        }
        (8, 8..=11) => Op::SaturatingAdd(d, n, m, b & 0x20 != 0, b & 0x10 != 0),
        (9, 8) => Op::ReverseBytes(d, m),
        (9, 9) => Op::ReverseHalves(d, m),
        (9, 10) => Op::ReverseBits(d, m),
        (11, 8) => Op::CountZeros(d, m),
        (9, 5) => Op::HalvesUnsigned(d, n, m, false),
        (13, 5) => Op::HalvesUnsigned(d, n, m, true),
        _ => Op::Unmodelled,
    }
}

fn multiply(a: u16, b: u16) -> Op {
    let (d, n, m, addend) = (reg(b, 8), reg(a, 0), reg(b, 0), reg(b, 12));
    match (a >> 4 & 7, b >> 4 & 3) {
        (0, 0) if addend == 15 => Op::Mul(Flags::Keep, d, n, m),
        (0, 0) => Op::MulAdd(d, n, m, addend, false),
        (0, 1) => Op::MulAdd(d, n, m, addend, true),
        (1, halves) => {
            let a = if addend == 15 { SINK } else { addend };
            Op::HalfMul {
                d,
                n,
                m,
                a,
                n_high: halves & 2 != 0,
                m_high: halves & 1 != 0,
            }
        }
        // SMMUL without rounding (DDI 0403E, A7.7.148): the upper half of a long product.
        (5, 0) if addend == 15 => Op::LongMul {
            low: SINK,
            high: d,
            n,
            m,
            signed: true,
            accumulate: false,
        },
        _ => Op::Unmodelled,
    }
}

fn long_multiply(a: u16, b: u16) -> Op {
    let (low, high, n, m) = (reg(b, 12), reg(b, 8), reg(a, 0), reg(b, 0));
    match (a >> 4 & 7, b >> 4 & 15) {
        (0, 0) => Op::LongMul {
            low,
            high,
            n,
            m,
            signed: true,
            accumulate: false,
        },
        (2, 0) => Op::LongMul {
            low,
            high,
            n,
            m,
            signed: false,
            accumulate: false,
        },
        (4, 0) => Op::LongMul {
            low,
            high,
            n,
            m,
            signed: true,
            accumulate: true,
        },
        (6, 0) => Op::LongMul {
            low,
            high,
            n,
            m,
            signed: false,
            accumulate: true,
        },
        (1, 15) => Op::Divide(high, n, m, true),
        (3, 15) => Op::Divide(high, n, m, false),
        _ => Op::Unmodelled,
    }
}
