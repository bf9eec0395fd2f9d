//! A decoded instruction. Names and fields are those of the Armv7-M architecture reference manual
//! (DDI 0403E).

use super::operands::{Dp, Flags, Float1, Float2, Index, Shift};
use crate::width::Width;

/// An instruction. `d` is the destination, `n` and `m` are operands, `t` is what a load or store
/// moves.
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
    ShiftReg {
        shift: Shift,
        flags: Flags,
        d: u8,
        n: u8,
        m: u8,
    },
    /// MOVW, ADR and other constants without flags.
    Constant {
        d: u8,
        value: u32,
    },
    MovT {
        d: u8,
        imm: u16,
    },
    /// MOV and ADD to the program counter.
    MovPc {
        m: u8,
    },
    AddPc {
        m: u8,
    },
    Load {
        width: Width,
        t: u8,
        n: u8,
        offset: i16,
        index: Index,
    },
    Store {
        width: Width,
        t: u8,
        n: u8,
        offset: i16,
        index: Index,
    },
    LoadReg {
        width: Width,
        t: u8,
        n: u8,
        m: u8,
        by: u8,
    },
    StoreReg {
        width: Width,
        t: u8,
        n: u8,
        m: u8,
        by: u8,
    },
    LoadLiteral {
        width: Width,
        t: u8,
        address: u32,
    },
    LoadPair {
        t: u8,
        t2: u8,
        n: u8,
        offset: i16,
        index: Index,
    },
    StorePair {
        t: u8,
        t2: u8,
        n: u8,
        offset: i16,
        index: Index,
    },
    LoadMany {
        n: u8,
        list: u16,
        back: bool,
        down: bool,
    },
    StoreMany {
        n: u8,
        list: u16,
        back: bool,
        down: bool,
    },
    LoadExclusive {
        width: Width,
        t: u8,
        n: u8,
        offset: u16,
    },
    StoreExclusive {
        width: Width,
        d: u8,
        t: u8,
        n: u8,
        offset: u16,
    },
    ClearExclusive,
    TableBranch {
        n: u8,
        m: u8,
        halves: bool,
    },
    Branch {
        to: u32,
    },
    BranchIf {
        condition: u8,
        to: u32,
    },
    BranchLink {
        to: u32,
    },
    BranchReg {
        m: u8,
    },
    BranchLinkReg {
        m: u8,
    },
    CompareBranch {
        n: u8,
        nonzero: bool,
        to: u32,
    },
    It {
        state: u8,
    },
    Mul {
        flags: Flags,
        d: u8,
        n: u8,
        m: u8,
    },
    MulAdd {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
        subtract: bool,
    },
    /// SMULxy and SMLAxy; `a` is [`SINK`](super::operands::SINK) without an addend.
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
    Divide {
        d: u8,
        n: u8,
        m: u8,
        signed: bool,
    },
    /// SXTB and its kin; `n` is [`SINK`](super::operands::SINK) without an addend.
    Extend {
        d: u8,
        n: u8,
        m: u8,
        rotate: u8,
        width: Width,
    },
    BitInsert {
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
    },
    BitExtract {
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
        signed: bool,
    },
    CountZeros {
        d: u8,
        m: u8,
    },
    ReverseBits {
        d: u8,
        m: u8,
    },
    ReverseBytes {
        d: u8,
        m: u8,
    },
    ReverseHalves {
        d: u8,
        m: u8,
    },
    Saturate {
        d: u8,
        n: u8,
        bits: u8,
        shift: Shift,
        by: u8,
        signed: bool,
    },
    SaturatingAdd {
        d: u8,
        n: u8,
        m: u8,
        subtract: bool,
        twice: bool,
    },
    HalvesUnsigned {
        d: u8,
        n: u8,
        m: u8,
        subtract: bool,
    },
    PackHalves {
        d: u8,
        n: u8,
        m: u8,
        by: u8,
        top: bool,
    },
    ReadSpecial {
        d: u8,
        number: u8,
    },
    WriteSpecial {
        n: u8,
        number: u8,
    },
    Mask {
        primask: bool,
        faultmask: bool,
        set: bool,
    },
    Nop,
    WaitForInterrupt,
    Barrier,
    Breakpoint,
    FloatLoad {
        s: u8,
        n: u8,
        offset: i16,
        words: u8,
    },
    FloatStore {
        s: u8,
        n: u8,
        offset: i16,
        words: u8,
    },
    FloatLoadMany {
        n: u8,
        s: u8,
        words: u8,
        back: bool,
        down: bool,
    },
    FloatStoreMany {
        n: u8,
        s: u8,
        words: u8,
        back: bool,
        down: bool,
    },
    FloatToCore {
        t: u8,
        s: u8,
    },
    CoreToFloat {
        t: u8,
        s: u8,
    },
    FloatPairToCore {
        t: u8,
        t2: u8,
        s: u8,
    },
    CorePairToFloat {
        t: u8,
        t2: u8,
        s: u8,
    },
    /// VMRS; 15 moves the flags to APSR.
    FloatStatusToCore {
        t: u8,
    },
    CoreToFloatStatus {
        t: u8,
    },
    Float2 {
        f: Float2,
        d: u8,
        n: u8,
        m: u8,
    },
    Float1 {
        f: Float1,
        d: u8,
        m: u8,
    },
    FloatConstant {
        d: u8,
        bits: u32,
    },
    /// VCMP; `m` is [`FLOAT_ZERO`](super::operands::FLOAT_ZERO) for a comparison with zero.
    FloatCompare {
        d: u8,
        m: u8,
    },
    IntToFloat {
        d: u8,
        m: u8,
        signed: bool,
    },
    FloatToInt {
        d: u8,
        m: u8,
        signed: bool,
        to_zero: bool,
    },
}
