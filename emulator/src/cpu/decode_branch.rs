//! 32-bit branches, and special registers (DDI 0403E, A5.3.4).

use super::op::Op;
use super::operands::reg;

pub fn decode(a: u16, b: u16, pc: u32) -> Op {
    let s = i32::from((a << 5) as i16 >> 15);
    let (j1, j2) = (i32::from(b >> 13 & 1), i32::from(b >> 11 & 1));
    let low = i32::from(b & 0x7FF) << 1;
    let from = pc.wrapping_add(4);
    if b & 0x1000 != 0 {
        // i1 = not (j1 xor s), and i2 = not (j2 xor s).
        let (i1, i2) = (!(j1 ^ s) & 1, !(j2 ^ s) & 1);
        let offset = s << 24 | i1 << 23 | i2 << 22 | i32::from(a & 0x3FF) << 12 | low;
        let to = from.wrapping_add_signed(offset);
        return if b & 0x4000 != 0 {
            Op::BranchLink(to)
        } else {
            Op::Branch(to)
        };
    }
    if b & 0x4000 != 0 {
        return Op::Undefined;
    }
    if a >> 7 & 7 != 7 {
        let offset = s << 20 | j2 << 19 | j1 << 18 | i32::from(a & 0x3F) << 12 | low;
        return Op::BranchIf((a >> 6 & 15) as u8, from.wrapping_add_signed(offset));
    }
    match a >> 4 & 0x7F {
        0x38 | 0x39 => Op::WriteSpecial(reg(a, 0), (b & 0xFF) as u8),
        0x3A if b & 0xFF == 0 => Op::Nop,
        0x3A => Op::Unmodelled,
        0x3B if b >> 4 & 15 == 2 => Op::ClearExclusive,
        0x3B => Op::Barrier,
        0x3E | 0x3F => Op::ReadSpecial(reg(b, 8), (b & 0xFF) as u8),
        _ => Op::Undefined,
    }
}
