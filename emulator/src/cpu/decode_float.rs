//! Encodings of the single-precision floating-point unit (DDI 0403E, A6.4 to A6.6).

use super::op::Op;
use super::operands::{FLOAT_ZERO, Float1, Float2};

/// Decodes a coprocessor encoding; only coprocessors 10 and 11, the floating-point unit, exist.
pub fn decode(a: u16, b: u16) -> Op {
    if b & 0x0E00 != 0x0A00 || a & 0x1000 != 0 {
        return Op::Undefined;
    }
    let is_double = b & 0x100 != 0;
    if a & 0x0200 == 0 {
        return transfer(a, b, is_double);
    }
    match (b & 0x10 != 0, is_double) {
        (true, false) => core_transfer(a, b),
        (false, false) => arithmetic(a, b),
        // Double precision, and scalar moves.
        _ => Op::Unmodelled,
    }
}

/// Number of a single-precision register: four bits of the field, then a separate lowest bit.
fn sd(a: u16, b: u16) -> u8 {
    (b >> 11 & 0x1E | a >> 6 & 1) as u8
}

fn sn(a: u16, b: u16) -> u8 {
    (a << 1 & 0x1E | b >> 7 & 1) as u8
}

fn sm(b: u16) -> u8 {
    (b << 1 & 0x1E | b >> 5 & 1) as u8
}

fn transfer(a: u16, b: u16, is_double: bool) -> Op {
    let n = (a & 15) as u8;
    let (before, up, back, is_load) = (a & 0x100 != 0, a & 0x80 != 0, a & 0x20 != 0, a & 0x10 != 0);
    if !before && !up {
        // Bit 6 is not part of a register number in pair transfers.
        let (t, t2) = ((b >> 12) as u8, n);
        let t2 = if a & 0x40 == 0 {
            return Op::Undefined;
        } else {
            t2
        };
        let s = if is_double {
            (b << 1 & 0x1E) as u8
        } else {
            sm(b)
        };
        return if is_load {
            Op::FloatPairToCore(t, t2, s)
        } else {
            Op::CorePairToFloat(t, t2, s)
        };
    }
    // A double register is two singles.
    let s = if is_double {
        (b >> 11 & 0x1E | a >> 1 & 0x20) as u8
    } else {
        sd(a, b)
    };
    if s >= 32 {
        return Op::Undefined;
    }
    let words = (b & 0xFF) as u8;
    if before && !back {
        let (offset, words) = (
            i16::from(words) * if up { 4 } else { -4 },
            1 + u8::from(is_double),
        );
        return if is_load {
            Op::FloatLoad(s, n, offset, words)
        } else {
            Op::FloatStore(s, n, offset, words)
        };
    }
    if u32::from(s) + u32::from(words) > 32 {
        return Op::Undefined;
    }
    let down = before;
    if is_load {
        Op::FloatLoadMany(n, s, words, back, down)
    } else {
        Op::FloatStoreMany(n, s, words, back, down)
    }
}

fn core_transfer(a: u16, b: u16) -> Op {
    let t = (b >> 12) as u8;
    match a >> 4 & 15 {
        0 => Op::CoreToFloat(t, sn(a, b)),
        1 => Op::FloatToCore(t, sn(a, b)),
        14 if a & 15 == 1 => Op::CoreToFloatStatus(t),
        15 if a & 15 == 1 => Op::FloatStatusToCore(t),
        _ => Op::Unmodelled,
    }
}

fn arithmetic(a: u16, b: u16) -> Op {
    let (d, n, m) = (sd(a, b), sn(a, b), sm(b));
    let second = b & 0x40 != 0;
    let two = |first, other| Op::Float2(if second { other } else { first }, d, n, m);
    match a >> 4 & 11 {
        0 => two(Float2::Mla, Float2::Mls),
        1 => two(Float2::Nmls, Float2::Nmla),
        2 => two(Float2::Mul, Float2::Nmul),
        3 => two(Float2::Add, Float2::Sub),
        8 if !second => two(Float2::Div, Float2::Div),
        9 => two(Float2::Fnms, Float2::Fnma),
        10 => two(Float2::Fma, Float2::Fms),
        11 if !second => Op::FloatConstant(d, constant((a << 4 & 0xF0 | b & 15) as u8)),
        11 => other(a, b, d, m),
        _ => Op::Undefined,
    }
}

/// VFPExpandImm for single precision.
fn constant(imm8: u8) -> u32 {
    let (sign, b6, low) = (
        u32::from(imm8 >> 7),
        u32::from(imm8 >> 6 & 1),
        u32::from(imm8 & 0x3F),
    );
    let exponent = (1 - b6) << 7 | if b6 != 0 { 0x7C } else { 0 } | low >> 4;
    sign << 31 | exponent << 23 | (low & 15) << 19
}

fn other(a: u16, b: u16, d: u8, m: u8) -> Op {
    let high = b & 0x80 != 0;
    match (a & 15, high) {
        (0, false) => Op::Float1(Float1::Mov, d, m),
        (0, true) => Op::Float1(Float1::Abs, d, m),
        (1, false) => Op::Float1(Float1::Neg, d, m),
        (1, true) => Op::Float1(Float1::Sqrt, d, m),
        (4, _) => Op::FloatCompare(d, m),
        (5, _) => Op::FloatCompare(d, FLOAT_ZERO),
        (8, signed) => Op::IntToFloat(d, m, signed),
        (12, to_zero) => Op::FloatToInt(d, m, false, to_zero),
        (13, to_zero) => Op::FloatToInt(d, m, true, to_zero),
        _ => Op::Unmodelled,
    }
}

#[cfg(test)]
mod tests {
    use super::{constant, decode};
    use crate::cpu::op::Op;

    /// Tests `vmov d0, r0, r3`, `vmov r0, r1, d0` and `vmov s0, s1, r0, r3` as an assembler encodes
    /// them.
    #[test]
    fn pairs_move_to_a_double_and_back() {
        assert!(matches!(
            decode(0xEC43, 0x0B10),
            Op::CorePairToFloat(0, 3, 0)
        ));
        assert!(matches!(
            decode(0xEC51, 0x0B10),
            Op::FloatPairToCore(0, 1, 0)
        ));
        assert!(matches!(
            decode(0xEC43, 0x0A10),
            Op::CorePairToFloat(0, 3, 0)
        ));
    }

    #[test]
    fn constants_expand() {
        for (imm8, value) in [
            (0x70, 1.0_f32),
            (0x00, 2.0),
            (0x60, 0.5),
            (0xF0, -1.0),
            (0x78, 1.5),
            (0x3F, 31.0),
        ] {
            assert_eq!(constant(imm8), value.to_bits(), "{imm8:#x}");
        }
    }
}
