//! A decoded instruction, with the names and fields of the Armv7-M architecture reference manual
//! (DDI 0403E).

use super::operands::{Dp, Flags, Float1, Float2, Index, Shift};
use crate::width::Width;

/// An instruction. `d` is the destination, `n` and `m` are operands, `t` is the register that a
/// load or store transfers. Code that matches a variant names its fields as in the variant's
/// comment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// An encoding that the architecture leaves undefined, or UDF.
    Undefined,
    /// An encoding that the images do not use.
    Unmodelled,
    DpImm {
        f: Dp,
        flags: Flags,
        d: u8,
        n: u8,
        imm: u32,
        carry: Option<bool>,
    },
    DpReg {
        f: Dp,
        flags: Flags,
        d: u8,
        n: u8,
        m: u8,
        shift: Shift,
        by: u8,
    },
    /// `shift`, `flags`, `d`, `n`, `m`.
    ShiftReg(Shift, Flags, u8, u8, u8),
    /// MOVW, ADR and other constants without flags. Fields: `d`, `value`.
    Constant(u8, u32),
    /// `d`, `imm`.
    MovT(u8, u16),
    /// MOV and ADD to the program counter. Fields: `m`.
    MovPc(u8),
    /// `m`.
    AddPc(u8),
    /// `width`, `t`, `n`, `offset`, `index`.
    Load(Width, u8, u8, i16, Index),
    /// `width`, `t`, `n`, `offset`, `index`.
    Store(Width, u8, u8, i16, Index),
    /// `width`, `t`, `n`, `m`, `by`.
    LoadReg(Width, u8, u8, u8, u8),
    /// `width`, `t`, `n`, `m`, `by`.
    StoreReg(Width, u8, u8, u8, u8),
    /// `width`, `t`, `address`.
    LoadLiteral(Width, u8, u32),
    /// `t`, `t2`, `n`, `offset`, `index`.
    LoadPair(u8, u8, u8, i16, Index),
    /// `t`, `t2`, `n`, `offset`, `index`.
    StorePair(u8, u8, u8, i16, Index),
    /// `n`, `list`, `back`, `down`.
    LoadMany(u8, u16, bool, bool),
    /// `n`, `list`, `back`, `down`.
    StoreMany(u8, u16, bool, bool),
    /// `width`, `t`, `n`, `offset`.
    LoadExclusive(Width, u8, u8, u16),
    /// `width`, `d`, `t`, `n`, `offset`.
    StoreExclusive(Width, u8, u8, u8, u16),
    ClearExclusive,
    /// `n`, `m`, `halves`.
    TableBranch(u8, u8, bool),
    /// `to`.
    Branch(u32),
    /// `condition`, `to`.
    BranchIf(u8, u32),
    /// `to`.
    BranchLink(u32),
    /// `m`.
    BranchReg(u8),
    /// `m`.
    BranchLinkReg(u8),
    /// `n`, `nonzero`, `to`.
    CompareBranch(u8, bool, u32),
    /// `state`.
    It(u8),
    /// `flags`, `d`, `n`, `m`.
    Mul(Flags, u8, u8, u8),
    /// `d`, `n`, `m`, `a`, `subtract`.
    MulAdd(u8, u8, u8, u8, bool),
    /// SMULxy and SMLAxy; `a` is [`SINK`](super::operands::SINK) if there is no addend.
    HalfMul {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
        n_high: bool,
        m_high: bool,
    },
    LongMul {
        low: u8,
        high: u8,
        n: u8,
        m: u8,
        signed: bool,
        accumulate: bool,
    },
    /// `d`, `n`, `m`, `signed`.
    Divide(u8, u8, u8, bool),
    /// SXTB and similar; `n` is [`SINK`](super::operands::SINK) if there is no addend. Fields: `d`,
    /// `n`, `m`, `rotate`, `width`.
    Extend(u8, u8, u8, u8, Width),
    /// `d`, `n`, `lsb`, `width`.
    BitInsert(u8, u8, u8, u8),
    /// `d`, `n`, `lsb`, `width`, `signed`.
    BitExtract(u8, u8, u8, u8, bool),
    /// `d`, `m`.
    CountZeros(u8, u8),
    /// `d`, `m`.
    ReverseBits(u8, u8),
    /// `d`, `m`.
    ReverseBytes(u8, u8),
    /// `d`, `m`.
    ReverseHalves(u8, u8),
    Saturate {
        d: u8,
        n: u8,
        bits: u8,
        shift: Shift,
        by: u8,
        signed: bool,
    },
    /// `d`, `n`, `m`, `subtract`, `twice`.
    SaturatingAdd(u8, u8, u8, bool, bool),
    /// `d`, `n`, `m`, `subtract`.
    HalvesUnsigned(u8, u8, u8, bool),
    /// `d`, `n`, `m`, `by`, `top`.
    PackHalves(u8, u8, u8, u8, bool),
    /// `d`, `number`.
    ReadSpecial(u8, u8),
    /// `n`, `number`.
    WriteSpecial(u8, u8),
    /// `primask`, `faultmask`, `set`.
    Mask(bool, bool, bool),
    Nop,
    WaitForInterrupt,
    Barrier,
    Breakpoint,
    /// `s`, `n`, `offset`, `words`.
    FloatLoad(u8, u8, i16, u8),
    /// `s`, `n`, `offset`, `words`.
    FloatStore(u8, u8, i16, u8),
    /// `n`, `s`, `words`, `back`, `down`.
    FloatLoadMany(u8, u8, u8, bool, bool),
    /// `n`, `s`, `words`, `back`, `down`.
    FloatStoreMany(u8, u8, u8, bool, bool),
    /// `t`, `s`.
    FloatToCore(u8, u8),
    /// `t`, `s`.
    CoreToFloat(u8, u8),
    /// `t`, `t2`, `s`.
    FloatPairToCore(u8, u8, u8),
    /// `t`, `t2`, `s`.
    CorePairToFloat(u8, u8, u8),
    /// VMRS; if `t` is 15, the flags go to APSR. Fields: `t`.
    FloatStatusToCore(u8),
    /// `t`.
    CoreToFloatStatus(u8),
    /// `f`, `d`, `n`, `m`.
    Float2(Float2, u8, u8, u8),
    /// `f`, `d`, `m`.
    Float1(Float1, u8, u8),
    /// `d`, `bits`.
    FloatConstant(u8, u32),
    /// VCMP; `m` is [`FLOAT_ZERO`](super::operands::FLOAT_ZERO) for a comparison with zero. Fields:
    /// `d`, `m`.
    FloatCompare(u8, u8),
    /// `d`, `m`, `signed`.
    IntToFloat(u8, u8, bool),
    /// `d`, `m`, `signed`, `to_zero`.
    FloatToInt(u8, u8, bool, bool),
}
