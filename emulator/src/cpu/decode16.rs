//! 16-bit Thumb encodings (DDI 0403E, A5.2).

use super::op::Op;
use super::operands::{Dp, Flags, Index, SINK, Shift};
use crate::width::Width;

pub fn decode(hw: u16, pc: u32) -> Op {
    let low = |at: u32| (hw >> at & 7) as u8;
    let imm8 = u32::from(hw & 0xFF);
    let flags = Flags::OutsideIt;
    match hw >> 11 {
        0b00000..=0b00010 => {
            let (shift, by) = immediate_shift((hw >> 11 & 3) as u8, (hw >> 6 & 31) as u8);
            Op::DpReg {
                f: Dp::Mov,
                flags,
                d: low(0),
                n: SINK,
                m: low(3),
                shift,
                by,
            }
        }
        0b00011 => {
            let f = if hw & 0x200 == 0 { Dp::Add } else { Dp::Sub };
            if hw & 0x400 == 0 {
                Op::DpReg {
                    f,
                    flags,
                    d: low(0),
                    n: low(3),
                    m: low(6),
                    shift: Shift::Lsl,
                    by: 0,
                }
            } else {
                Op::DpImm {
                    f,
                    flags,
                    d: low(0),
                    n: low(3),
                    imm: low(6).into(),
                    carry: None,
                }
            }
        }
        0b00100 => Op::DpImm {
            f: Dp::Mov,
            flags,
            d: low(8),
            n: SINK,
            imm: imm8,
            carry: None,
        },
        0b00101 => Op::DpImm {
            f: Dp::Sub,
            flags: Flags::Set,
            d: SINK,
            n: low(8),
            imm: imm8,
            carry: None,
        },
        0b00110 => Op::DpImm {
            f: Dp::Add,
            flags,
            d: low(8),
            n: low(8),
            imm: imm8,
            carry: None,
        },
        0b00111 => Op::DpImm {
            f: Dp::Sub,
            flags,
            d: low(8),
            n: low(8),
            imm: imm8,
            carry: None,
        },
        0b01000 if hw & 0x400 == 0 => data_processing(hw),
        0b01000 => high_registers(hw),
        0b01001 => Op::LoadLiteral(Width::Word, low(8), (pc & !3) + 4 + imm8 * 4),
        0b01010 | 0b01011 => {
            let (t, n, m, by) = (low(0), low(3), low(6), 0);
            match hw >> 9 & 7 {
                0 => Op::StoreReg(Width::Word, t, n, m, by),
                1 => Op::StoreReg(Width::Half, t, n, m, by),
                2 => Op::StoreReg(Width::Byte, t, n, m, by),
                3 => Op::LoadReg(Width::SignedByte, t, n, m, by),
                4 => Op::LoadReg(Width::Word, t, n, m, by),
                5 => Op::LoadReg(Width::Half, t, n, m, by),
                6 => Op::LoadReg(Width::Byte, t, n, m, by),
                _ => Op::LoadReg(Width::SignedHalf, t, n, m, by),
            }
        }
        0b01100..=0b10001 => {
            let (width, scale) = match hw >> 12 {
                0b0110 => (Width::Word, 4),
                0b0111 => (Width::Byte, 1),
                _ => (Width::Half, 2),
            };
            let (t, n, offset, index) =
                (low(0), low(3), (hw >> 6 & 31) as i16 * scale, Index::Offset);
            if hw & 0x800 == 0 {
                Op::Store(width, t, n, offset, index)
            } else {
                Op::Load(width, t, n, offset, index)
            }
        }
        0b10010 => Op::Store(Width::Word, low(8), 13, imm8 as i16 * 4, Index::Offset),
        0b10011 => Op::Load(Width::Word, low(8), 13, imm8 as i16 * 4, Index::Offset),
        0b10100 => Op::Constant(low(8), (pc & !3) + 4 + imm8 * 4),
        0b10101 => Op::DpImm {
            f: Dp::Add,
            flags: Flags::Keep,
            d: low(8),
            n: 13,
            imm: imm8 * 4,
            carry: None,
        },
        0b10110 | 0b10111 => miscellaneous(hw, pc),
        0b11000 => Op::StoreMany(low(8), hw & 0xFF, true, false),
        0b11001 => Op::LoadMany(low(8), hw & 0xFF, hw & 1 << low(8) == 0, false),
        0b11010 | 0b11011 => match hw >> 8 & 15 {
            14 => Op::Undefined,
            15 => Op::Unmodelled,
            condition => {
                let offset = i32::from(hw as u8 as i8) * 2;
                Op::BranchIf(
                    condition as u8,
                    pc.wrapping_add(4).wrapping_add_signed(offset),
                )
            }
        },
        _ => {
            let offset = i32::from((hw << 5) as i16 >> 4);
            Op::Branch(pc.wrapping_add(4).wrapping_add_signed(offset))
        }
    }
}

/// Shift type and amount of an immediate shift (DecodeImmShift).
pub fn immediate_shift(kind: u8, by: u8) -> (Shift, u8) {
    match (kind, by) {
        (0, _) => (Shift::Lsl, by),
        (1, 0) => (Shift::Lsr, 32),
        (1, _) => (Shift::Lsr, by),
        (2, 0) => (Shift::Asr, 32),
        (2, _) => (Shift::Asr, by),
        (_, 0) => (Shift::Rrx, 1),
        _ => (Shift::Ror, by),
    }
}

fn data_processing(hw: u16) -> Op {
    let (d, m, flags, by) = ((hw & 7) as u8, (hw >> 3 & 7) as u8, Flags::OutsideIt, 0);
    let two = |f| Op::DpReg {
        f,
        flags,
        d,
        n: d,
        m,
        shift: Shift::Lsl,
        by,
    };
    let compare = |f| Op::DpReg {
        f,
        flags: Flags::Set,
        d: SINK,
        n: d,
        m,
        shift: Shift::Lsl,
        by,
    };
    let shift = |shift| Op::ShiftReg(shift, flags, d, d, m);
    match hw >> 6 & 15 {
        0 => two(Dp::And),
        1 => two(Dp::Eor),
        2 => shift(Shift::Lsl),
        3 => shift(Shift::Lsr),
        4 => shift(Shift::Asr),
        5 => two(Dp::Adc),
        6 => two(Dp::Sbc),
        7 => shift(Shift::Ror),
        8 => compare(Dp::And),
        9 => Op::DpImm {
            f: Dp::Rsb,
            flags,
            d,
            n: m,
            imm: 0,
            carry: None,
        },
        10 => compare(Dp::Sub),
        11 => compare(Dp::Add),
        12 => two(Dp::Orr),
        13 => Op::Mul(flags, d, d, m),
        14 => two(Dp::Bic),
        _ => two(Dp::Mvn),
    }
}

fn high_registers(hw: u16) -> Op {
    let (d, m) = ((hw & 7 | hw >> 4 & 8) as u8, (hw >> 3 & 15) as u8);
    let (flags, shift, by) = (Flags::Keep, Shift::Lsl, 0);
    match (hw >> 8 & 3, d) {
        (0, 15) => Op::AddPc(m),
        (0, _) => Op::DpReg {
            f: Dp::Add,
            flags,
            d,
            n: d,
            m,
            shift,
            by,
        },
        (1, _) => Op::DpReg {
            f: Dp::Sub,
            flags: Flags::Set,
            d: SINK,
            n: d,
            m,
            shift,
            by,
        },
        (2, 15) => Op::MovPc(m),
        (2, _) => Op::DpReg {
            f: Dp::Mov,
            flags,
            d,
            n: SINK,
            m,
            shift,
            by,
        },
        _ if hw & 0x80 == 0 => Op::BranchReg(m),
        _ => Op::BranchLinkReg(m),
    }
}

fn miscellaneous(hw: u16, pc: u32) -> Op {
    let (d, m) = ((hw & 7) as u8, (hw >> 3 & 7) as u8);
    match hw >> 8 & 15 {
        0 => {
            let f = if hw & 0x80 == 0 { Dp::Add } else { Dp::Sub };
            Op::DpImm {
                f,
                flags: Flags::Keep,
                d: 13,
                n: 13,
                imm: u32::from(hw & 0x7F) * 4,
                carry: None,
            }
        }
        1 | 3 | 9 | 11 => {
            let offset = u32::from(hw >> 3 & 31) * 2 + u32::from(hw >> 9 & 1) * 64;
            Op::CompareBranch(d, hw & 0x800 != 0, pc + 4 + offset)
        }
        2 => {
            let width = [
                Width::SignedHalf,
                Width::SignedByte,
                Width::Half,
                Width::Byte,
            ][usize::from(hw >> 6 & 3)];
            Op::Extend(d, SINK, m, 0, width)
        }
        4 | 5 => Op::StoreMany(13, hw & 0xFF | (hw & 0x100) << 6, true, true),
        12 | 13 => Op::LoadMany(13, hw & 0xFF | (hw & 0x100) << 7, true, false),
        6 if hw & 0xE0 == 0x60 => Op::Mask(hw & 2 != 0, hw & 1 != 0, hw & 0x10 != 0),
        10 => match hw >> 6 & 3 {
            0 => Op::ReverseBytes(d, m),
            1 => Op::ReverseHalves(d, m),
            _ => Op::Unmodelled,
        },
        14 => Op::Breakpoint,
        15 => match (hw >> 4 & 15, hw & 15) {
            (0, 0) => Op::Nop,
            (3, 0) => Op::WaitForInterrupt,
            (_, 0) => Op::Unmodelled,
            _ => Op::It((hw & 0xFF) as u8),
        },
        _ => Op::Undefined,
    }
}
